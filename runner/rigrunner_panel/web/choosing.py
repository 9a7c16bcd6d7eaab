"""What there is to choose, what it would do, and what it asks."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

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
from rigrunner_panel.view.of_plan import plan_view
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
    from rigrunner_panel.catalogue import Entry
    from rigrunner_panel.web.asked import Asked
    from rigrunner_panel.web.panel import Panel
    from rigrunner_panel.web.requests import AskPlan, CheckInput, Pair


def procedures(panel: Panel, asked: Asked) -> Procedures:
    """Return the procedures, last used first."""
    # Oldest first: of each the latest start is what stays.
    used = {each.procedure: each.started_utc for each in reversed(list(panel.history.items()))}
    items = [
        ProcedureItem(
            name=each.name,
            id=each.id,
            title=each.title,
            note=each.note,
            shipped=each.shipped,
            last_used_utc=used.get(each.id, ""),
            problem=each.problem,
        )
        for each in _found(panel.catalogue.entries("procedure"), asked)
    ]
    return Procedures(items=sorted(items, key=lambda each: each.last_used_utc, reverse=True))


def stations(panel: Panel, asked: Asked) -> Stations:
    """Return the stations, last used first."""
    used = {each.station: each.started_utc for each in reversed(list(panel.history.items()))}
    items = [
        StationItem(
            name=each.name,
            id=each.id,
            title=each.title,
            shipped=each.shipped,
            last_used_utc=used.get(each.id, ""),
            problem=each.problem,
        )
        for each in _found(panel.catalogue.entries("station"), asked)
    ]
    return Stations(items=sorted(items, key=lambda each: each.last_used_utc, reverse=True))


def plan(panel: Panel, asked: Asked) -> PlanAnswer:
    """Return what a run would do; nothing is connected."""
    body: AskPlan = asked.body
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
            ExpectedReading(**asdict(each), share=each.share) for each in prediction.readings
        ),
        inputs=tuple(_inputs(planned)),
        partners=tuple(_partners(planned, panel.settings.runs)),
        warnings=tuple(_warnings(planned)),
    )


def check_input(panel: Panel, asked: Asked) -> InputAnswer:
    """Say whether an answer would be taken; an empty one would not."""
    body: CheckInput = asked.body
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


def _found(entries: list[Entry], asked: Asked) -> list[Entry]:
    words = asked.query.get("search", "").casefold().split()
    return [
        each
        for each in entries
        if all(word in f"{each.name} {each.id} {each.title}".casefold() for word in words)
    ]


def _inputs(planned: Planned) -> Iterator[InputItem]:
    for name, each in planned.procedure.inputs.items():
        expected = each.expected
        yield InputItem(
            name=name,
            ask=each.ask,
            choices=expected.choices,
            unit=expected.unit,
            expected=expected.words,
            unattended=each.unattended,
        )


def _partners(planned: Planned, runs: Path) -> Iterator[Partner]:
    for name, found in each_partner(planned, runs):
        words = partner_words(name)
        if isinstance(found, RigrunnerError):
            yield Partner(name=name, words=words, problem=found.message, hint=found.hint)
        else:
            yield Partner(name=name, words=words, run=found.name)


def _warnings(planned: Planned) -> Iterator[str]:
    if planned.approval.is_draft:
        yield f"{planned.procedure.model.id} is a {planned.approval.sentence()}"
    for reading in planned.prediction().overloads:
        yield f"{reading.recording} would overload {reading.channel}"
    for finding in calibration_findings(planned):
        yield finding.problem.message
