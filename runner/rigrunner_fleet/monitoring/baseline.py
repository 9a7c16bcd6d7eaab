"""Parse the baseline of a chart: '20', or '2026-01-01..2026-02-28'."""

from __future__ import annotations

from rigrunner.api.errors import UsageError
from rigrunner_fleet.archive.ranges import since, until
from rigrunner_fleet.trends.charting import Baseline
from rigrunner_fleet.trends.charts import FEWEST


def baseline_of(text: str) -> Baseline:
    """Parse the number of first values, or FROM..TO, days in UTC; raise UsageError."""
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
    found = Baseline(None, since(first) if first else None, until(last) if last else None)
    if found.since is not None and found.until is not None and found.since >= found.until:
        raise UsageError(
            f"the baseline '{text}' is empty", hint="the earlier day comes first", field="baseline"
        )
    return found
