"""The procedures and stations to choose, the plan of a run, and its inputs."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.analysis.requirements import partner_words
from rigrunner.api.errors import RigrunnerError
from rigrunner.clock import SimulatedClock
from rigrunner.procedure import load_procedure
from rigrunner.procedure.answers import AnswerError
from rigrunner.queue import SPECIMEN, tested_before
from rigrunner.run.calibration import calibration_findings
from rigrunner.run.partners import each_partner
from rigrunner.run.planning import planned_run
from rigrunner_panel.errors import not_found
from rigrunner_panel.jobs.preflight import free_bytes, needed_bytes
from rigrunner_panel.view.plan import plan_view
from rigrunner_panel.web.answers import (
    ExpectedReading,
    InputAnswer,
    InputItem,
    Partner,
    PlanAnswer,
    PlannedProcedure,
    PlannedStation,
    ProcedureItem,
    Procedures,
    StationItem,
    Stations,
)

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.run.prepare import Planned
    from rigrunner_panel.catalogue import What
    from rigrunner_panel.web.operation import ApiRequest
    from rigrunner_panel.web.panel import Panel
    from rigrunner_panel.web.requests import AskPlan, CheckInput, Pair

_Item = TypeVar("_Item", ProcedureItem, StationItem)


def procedures(panel: Panel, request: ApiRequest) -> Procedures:
    """Return the procedures, last used first."""
    return Procedures(items=_listed(panel, request, "procedure", ProcedureItem))


def stations(panel: Panel, request: ApiRequest) -> Stations:
    """Return the stations, last used first."""
    return Stations(items=_listed(panel, request, "station", StationItem))


def plan(panel: Panel, request: ApiRequest) -> PlanAnswer:
    """Return what a run would do; nothing is connected."""
    body: AskPlan = request.body
    planned = planned_run(*files(panel, body), text=body.text)
    model, prediction = planned.procedure.model, planned.prediction()
    view = plan_view(planned.plan, planned.devices)
    return PlanAnswer(
        procedure=PlannedProcedure(
            name=body.procedure,
            id=model.id,
            title=model.title,
            revision=model.revision,
            approval=planned.approval.sentence(),
            draft=planned.approval.is_draft,
        ),
        station=PlannedStation(
            name=body.station,
            id=planned.station.model.id,
            title=planned.station.model.title,
            simulated=isinstance(planned.clock, SimulatedClock),
        ),
        estimated_s=view.estimated_s,
        disk_bytes=needed_bytes(planned),
        disk_free_bytes=free_bytes(panel.settings.runs),
        steps=view.steps,
        readings=tuple(
            ExpectedReading(**asdict(reading), share=reading.share)
            for reading in prediction.readings
        ),
        inputs=tuple(_inputs(planned)),
        partners=tuple(_partners(planned, panel.settings.runs)),
        warnings=tuple(_warnings(planned)),
    )


def check_input(panel: Panel, request: ApiRequest) -> InputAnswer:
    """Return whether an answer would be accepted; an empty one would not."""
    body: CheckInput = request.body
    procedure = load_procedure(panel.catalogue.path("procedure", body.procedure))
    if body.input not in procedure.inputs:
        raise not_found(f"the procedure has no input '{body.input}'")
    expected = procedure.inputs[body.input].expected
    if not body.text.strip():
        return InputAnswer(ok=False, message="nothing was given", hint=expected.words)
    try:
        value = expected.accept(body.text)
    except AnswerError as error:
        return InputAnswer(ok=False, message=error.message, hint=error.hint)
    specimens = [value] if body.input == SPECIMEN else []
    notes = tested_before(panel.settings.runs, procedure.model.id, specimens)
    return InputAnswer(ok=True, value=value, note=notes.get(value, ""))


def files(panel: Panel, pair: Pair) -> tuple[Path, Path]:
    """Return the files that a pair of names stands for; raise PanelError."""
    return (
        panel.catalogue.path("procedure", pair.procedure),
        panel.catalogue.path("station", pair.station),
    )


def _listed(panel: Panel, request: ApiRequest, what: What, item: type[_Item]) -> list[_Item]:
    """Return the files that have all words of the search, last used first."""
    # Oldest first, so that the latest start of each remains.
    used = {getattr(run, what): run.started_utc for run in reversed(list(panel.history.items()))}
    words = request.query.get("search", "").casefold().split()
    items = [
        item(**vars(entry), last_used_utc=used.get(entry.id, ""))
        for entry in panel.catalogue.entries(what)
        if all(word in f"{entry.name} {entry.id} {entry.title}".casefold() for word in words)
    ]
    return sorted(items, key=lambda item: item.last_used_utc, reverse=True)


def _inputs(planned: Planned) -> Iterator[InputItem]:
    for name, definition in planned.procedure.inputs.items():
        expected = definition.expected
        yield InputItem(
            name=name,
            ask=definition.ask,
            choices=expected.choices,
            unit=expected.unit,
            expected=expected.words,
            unattended=definition.unattended,
        )


def _partners(planned: Planned, runs: Path) -> Iterator[Partner]:
    for name, result in each_partner(planned, runs):
        words = partner_words(name)
        if isinstance(result, RigrunnerError):
            yield Partner(name=name, words=words, problem=result.message, hint=result.hint)
        else:
            yield Partner(name=name, words=words, run=result.name)


def _warnings(planned: Planned) -> Iterator[str]:
    if planned.approval.is_draft:
        yield f"{planned.procedure.model.id} is a {planned.approval.sentence()}"
    for reading in planned.prediction().overloads:
        yield f"{reading.recording} would overload {reading.channel}"
    for finding in calibration_findings(planned):
        yield finding.problem.message
