"""Control charts of results in an archive, and their baselines."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.api.studies import Trend
from rigrunner_fleet.archive.ranges import since, until
from rigrunner_fleet.monitoring.observing import study_groups
from rigrunner_fleet.trends.charting import Baseline, control_chart
from rigrunner_fleet.trends.charts import FEWEST

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner_fleet.monitoring.observing import Observations
    from rigrunner_fleet.trends.charting import Charting


def trend(observations: Observations, charting: Charting, asked: Mapping[str, str]) -> Trend:
    """Return the chart of each group; raise NoStudyError if there is none."""
    series, refused = study_groups(
        observations,
        lambda name, group: control_chart(name, group.observed, charting),
        "no chart can be made",
    )
    return Trend(
        quantity=observations.quantity.name,
        unit=observations.unit,
        asked=asked,
        excluded=observations.excluded,
        warnings=observations.warnings,
        chart=charting.chart,
        rules=charting.rule_texts(),
        series=series,
        not_charted=refused,
    )


def baseline_of(text: str) -> Baseline:
    """Parse the number of first values, as '20', or FROM..TO, days in UTC; raise UsageError."""
    if text.isdecimal():
        if int(text) < FEWEST:
            raise UsageError(
                f"a baseline of {text} values is too short",
                hint=f"at least {FEWEST}; 20 to 25 are advised",
                field="baseline",
            )
        return Baseline(int(text))
    first, dots, last = text.partition("..")
    if not dots or not (first or last):
        raise UsageError(
            f"'{text}' is not a baseline",
            hint="such as 20, or 2026-01-01..2026-02-28, days in UTC",
            field="baseline",
        )
    span = Baseline(None, since(first) if first else None, until(last) if last else None)
    if span.since is not None and span.until is not None and span.since >= span.until:
        raise UsageError(
            f"the baseline '{text}' is empty", hint="the earlier day comes first", field="baseline"
        )
    return span
