"""Many stored runs: curves laid over each other, and control charts of the archive.

What needs the archive is imported by the first request for it: SQLAlchemy takes a fifth of the
time in which a panel starts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.clock import utc_text
from rigrunner.runfile import read
from rigrunner_panel.errors import PanelError
from rigrunner_panel.overlay import channel_figure, channels_in, result_figures, result_rows
from rigrunner_panel.web.answers import (
    AlarmAt,
    ArchiveUpdated,
    ChartOfGroup,
    OverlayAnswer,
    OverlayRow,
    Quantities,
    RunAndReason,
    TrendAnswer,
)

if TYPE_CHECKING:
    from rigrunner.api.figures import Figure
    from rigrunner.api.studies import TrendSeries
    from rigrunner_panel.web.operation import ApiRequest
    from rigrunner_panel.web.panel import Panel

MOST_RUNS = 6
"""The most curves in one figure: more colours cannot be distinguished."""
GROUPS = ("type", "lot", "rig", "mandrel", "specimen", "operator", "procedure", "revision")


def overlay(panel: Panel, request: ApiRequest) -> OverlayAnswer:
    """Return the results of some runs, and one of their channels, in figures."""
    names = [name for name in request.query.get("runs", "").split(",") if name]
    if not 1 <= len(names) <= MOST_RUNS:
        message = f"got {len(names)} runs, expected 1 to {MOST_RUNS}"
        raise PanelError(400, "bad_request", message)
    runs = {name: read(panel.history.folder(name)) for name in names}
    recording, channel = request.query.get("recording", ""), request.query.get("channel", "")
    return OverlayAnswer(
        recordings=channels_in(runs),
        results=tuple(result_figures(runs)),
        rows=[
            OverlayRow(name=name, unit=unit, values=values)
            for name, unit, values in result_rows(runs)
        ],
        curve=channel_figure(runs, recording, channel) if recording else None,
    )


def update(panel: Panel, _: ApiRequest) -> ArchiveUpdated:
    """Bring the archive up to date with the runs: a file beside them, made of them alone."""
    from rigrunner_panel import trends  # noqa: PLC0415  (see above)

    with panel.archiving:
        result = trends.update(panel.settings.runs)
    if result is None:
        return ArchiveUpdated(runs=0, new=0, changed=0, unreadable=0)
    return ArchiveUpdated(
        runs=result.runs, new=result.new, changed=result.changed, unreadable=len(result.unreadable)
    )


def quantities(panel: Panel, _: ApiRequest) -> Quantities:
    """Return the results that can be charted."""
    from rigrunner_panel import trends  # noqa: PLC0415  (see above)

    return Quantities(items=trends.quantities(panel.settings.runs))


def trend(panel: Panel, request: ApiRequest) -> TrendAnswer:
    """Return control charts of a quantity, one for each group of runs."""
    from rigrunner_fleet.trends.rules import RULES  # noqa: PLC0415  (see above)
    from rigrunner_panel import trends  # noqa: PLC0415  (see above)

    query = request.query
    by = tuple(name for name in query.get("by", "").split(",") if name)
    chart, rules = query.get("chart") or "i-mr", query.get("rules") or "nelson"
    if set(by) - set(GROUPS) or chart not in ("i-mr", "ewma") or rules not in RULES:
        message = "got by, chart or rules with a value that is not known"
        raise PanelError(400, "bad_request", message, "GET /api/v1/openapi.json describes it")
    settings = trends.chart_settings(chart, rules, query.get("baseline") or "20")
    filters = {name: query[name] for name in ("procedure", "since", "until") if query.get(name)}
    study = trends.charts(panel.settings.runs, query.get("quantity", ""), by, filters, settings)
    return TrendAnswer(
        quantity=study.quantity,
        unit=study.unit,
        rules=dict(study.rules),
        charts=[_chart(series, trends.figure(study, series)) for series in study.series],
        not_charted=dict(study.not_charted),
        excluded=[RunAndReason(run=run.run_id, reason=run.reason) for run in study.excluded],
        warnings=list(study.warnings),
    )


def _chart(series: TrendSeries, figure: Figure) -> ChartOfGroup:
    alarms = [
        AlarmAt(
            run=alarm.observed.run_id,
            utc=utc_text(alarm.observed.started_utc),
            value=alarm.observed.value,
            rules=alarm.rules,
        )
        for alarm in series.alarms
    ]
    return ChartOfGroup(
        name=series.name,
        centre=series.individuals.centre,
        lower=series.individuals.lower,
        upper=series.individuals.upper,
        runs=[point.observed.run_id for point in series.points],
        alarms=alarms,
        warnings=list(series.warnings),
        figure=figure,
    )
