"""Control charts of the archive of the runs' folder."""

from __future__ import annotations

from contextlib import closing
from math import nan
from typing import TYPE_CHECKING

from rigrunner.api.figures import Axis, Figure, Mark, Series
from rigrunner.api.studies import Trend
from rigrunner_fleet.archive.filters import filters_of
from rigrunner_fleet.archive.indexing import index
from rigrunner_fleet.archive.querying import open_archive, rows
from rigrunner_fleet.monitoring.observing import NoStudyError, observe
from rigrunner_fleet.monitoring.quantities import TORQUES
from rigrunner_fleet.monitoring.trending import baseline_of, trend
from rigrunner_fleet.trends.charting import Charting

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.api.studies import TrendSeries
    from rigrunner_fleet.archive.indexing import Indexed


def update(runs: Path) -> Indexed | None:
    """Update the archive from the folder of runs; None if there is no such folder."""
    if not runs.is_dir():
        return None
    with closing(open_archive(runs)) as archive:
        (indexed,) = index(archive, [runs])
    return indexed


def quantities(runs: Path) -> list[str]:
    """Return the names of the quantities in the archive: results of runs, figures of rigs."""
    everything = filters_of()
    with closing(open_archive(runs)) as archive:
        torques = {
            name
            for run in rows(archive, "runs", everything)
            for name, (column, _) in TORQUES.items()
            if run[column] is not None
        }
        results = {result["name"] for result in rows(archive, "results", everything)} - set(TORQUES)
        figures = {
            f"{figure['source']}/{figure['name']}"
            for figure in rows(archive, "figures", everything)
        }
    return [*(name for name in TORQUES if name in torques), *sorted(results), *sorted(figures)]


def charts(
    runs: Path, quantity: str, by: tuple[str, ...], filters: Mapping[str, str], settings: Charting
) -> Trend:
    """Return the charts of a quantity, and why groups have none; raises the errors of `observe`."""
    with closing(open_archive(runs)) as archive:
        observations = observe(archive, quantity, filters_of(**filters), by)
    try:
        return trend(observations, settings, {"quantity": quantity})
    except NoStudyError as error:  # too few runs so far are no failure
        return Trend(
            quantity=observations.quantity.name,
            unit=observations.unit,
            asked={},
            excluded=observations.excluded,
            warnings=observations.warnings,
            chart=settings.chart,
            rules={},
            series=(),
            not_charted=error.refused,
        )


def chart_settings(chart: str, rules: str, baseline: str) -> Charting:
    """Return the chart settings; raise UsageError for an invalid baseline."""
    return Charting(chart, rules, baseline_of(baseline))


def figure(study: Trend, series: TrendSeries) -> Figure:
    """Return the chart of a group: values in order, limits, and rule violations."""
    plotted = [point.plotted for point in series.points]
    numbers = range(1, len(plotted) + 1)
    expanded = [point.observed.expanded or nan for point in series.points]
    values = Series.over(numbers, plotted, series.name, "joined", expanded)
    alarms = [(n, point.plotted) for n, point in zip(numbers, series.points, strict=True)
              if point.rules and not point.baseline]  # fmt: skip
    marked = Series.over([n for n, _ in alarms], [y for _, y in alarms], "alarm", "marked")
    last = series.points[-1]
    centre = Mark("y", series.individuals.centre, name="centre")
    limits = (Mark("y", limit, is_limit=True) for limit in (last.lower, last.upper))
    return Figure(
        series.name,
        Axis("run"),
        Axis(study.quantity, study.unit),
        (values, marked) if alarms else (values,),
        (centre, *limits),
    )
