"""Control charts of results in an archive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.studies import Trend
from rigrunner_fleet.monitoring.observing import each_group
from rigrunner_fleet.trends.charting import charted

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner_fleet.monitoring.observing import Observations
    from rigrunner_fleet.trends.charting import Charting


def trend(found: Observations, how: Charting, asked: Mapping[str, str]) -> Trend:
    """Return the chart of each group; raise NoStudyError if there is none."""
    series, refused = each_group(
        found,
        lambda name, group: charted(name, group.observed, how),
        "no chart can be made",
    )
    return Trend(
        quantity=found.quantity.name,
        unit=found.unit,
        asked=asked,
        excluded=found.excluded,
        warnings=found.warnings,
        chart=how.chart,
        rules=how.rule_texts(),
        series=series,
        not_charted=refused,
    )
