"""Preflight, start, and the control of a run in progress."""

from __future__ import annotations

import hashlib
import time
from concurrent.futures import ThreadPoolExecutor
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

from rigrunner.clock import utc_text
from rigrunner.engine import Choice, Interference
from rigrunner.procedure import load_procedure
from rigrunner.procedure.answers import AnswerError
from rigrunner.run.interrupted import read_interrupted
from rigrunner_panel.errors import PanelError, not_found, wrong_state
from rigrunner_panel.process.messages import Job
from rigrunner_panel.view.sections import JobView, PreflightItem
from rigrunner_panel.web.answers import Done, Stopped
from rigrunner_panel.web.choosing import files
from rigrunner_panel.web.panel import CheckedFiles
from rigrunner_panel.web.stored_runs import named_file

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from rigrunner_panel.view.sections import Preflight
    from rigrunner_panel.web.operation import ApiRequest
    from rigrunner_panel.web.panel import Panel, Rig
    from rigrunner_panel.web.requests import (
        GiveAnswer,
        OpenManual,
        Overridden,
        Pair,
        ResumeRun,
        StartPreflight,
        StartRun,
        TakeControl,
        Why,
    )

FRESH_S = 15 * 60.0
"""How long a preflight is valid."""


def take_control(rig: Rig, request: ApiRequest) -> Done:
    """Let this client steer."""
    body: TakeControl = request.body
    name = body.name.strip()
    before = rig.control.take(request.client, name, rig.panel.now(), take_over=body.take_over)
    if before is not None:
        subject = f"control was with {before.name}"
        rig.desk.put_on_record(Interference("take over", name, subject=subject))
    return Done()


def release_control(rig: Rig, request: ApiRequest) -> Done:
    """Let somebody else steer."""
    rig.control.release(request.client)
    return Done()


def start_preflight(rig: Rig, request: ApiRequest) -> Done:
    """Connect to the rig and check it; the findings come in the state."""
    begin_preflight(rig, request.body, request.by)
    return Done()


def begin_preflight(rig: Rig, body: StartPreflight, by: str) -> None:
    """Start the preflight; raise PanelError while the rig is in use."""
    procedure, station = files(rig.panel, body)
    digest = _digest(procedure, station)
    view = JobView(
        kind="preflight",
        procedure=body.procedure,
        station=body.station,
        operator=by,
        started_utc=utc_text(rig.panel.now()),
    )
    job = Job(
        view=view,
        procedure=procedure,
        station=station,
        runs=rig.panel.settings.runs,
        partners=named_runs(rig, body.partners),
        by=by,
        reason=body.safe.strip(),
    )
    rig.desk.start(job, rig.panel)
    rig.checked_files = CheckedFiles(digest=digest, at_s=time.monotonic())


def preflight_passed(rig: Rig, body: Pair) -> bool:
    """Return whether the last preflight was of these files, is fresh, and found nothing wrong."""
    try:
        return _preflight(rig, body, _digest(*files(rig.panel, body))).may_start
    except PanelError:
        return False


def start_job(
    rig: Rig,
    kind: Literal["run", "manual"],
    body: StartRun | OpenManual,
    by: str,
    inputs: Mapping[str, str] = MappingProxyType({}),
    *,
    entry: int | None = None,
) -> None:
    """Start a job that moves the rig; raise PanelError if the preflight does not permit it."""
    procedure, station = files(rig.panel, body)
    overridden = _overridden(_preflight(rig, body, _digest(procedure, station)), body.override)
    operator = body.operator.strip() or inputs.get("operator", "").strip() or by
    view = JobView(
        kind=kind,
        procedure=body.procedure,
        station=body.station,
        title=load_procedure(procedure).model.title,
        inputs=dict(inputs),
        operator=operator,
        realtime=body.realtime,
        started_utc=utc_text(rig.panel.now()),
    )
    job = Job(
        view=view,
        procedure=procedure,
        station=station,
        runs=rig.panel.settings.runs,
        partners=named_runs(rig, body.partners),
        items=overridden,
        by=body.override.by.strip() if body.override else "",
        reason=body.override.reason.strip() if body.override else "",
        entry=entry,
    )
    rig.desk.start(job, rig.panel)


def resume_stored(rig: Rig, request: ApiRequest) -> Done:
    """Resume an interrupted run where it was interrupted; the process checks what is the same."""
    body: ResumeRun = request.body
    panel, run = rig.panel, request.path["run"]
    header = read_interrupted(panel.history.folder(run)).header
    if header.station_id != rig.station.id:
        message = f"{run} was on {header.station_id}, not on {rig.station.id}"
        raise wrong_state(message, "resume it at its own rig")
    procedure = named_file(panel, "procedure", header.procedure_id, header.procedure_text)
    if not procedure:
        message = f"there is no procedure {header.procedure_id} in the list"
        raise wrong_state(message, "save the procedure of the run again, or close the run as it is")
    view = JobView(
        kind="run",
        procedure=procedure,
        station=rig.name,
        run=run,
        inputs=dict(header.inputs),
        operator=request.by,
        realtime=body.realtime,
        started_utc=header.started_utc,
    )
    job = Job(
        view=view,
        procedure=panel.catalogue.path("procedure", procedure),
        station=panel.catalogue.path("station", rig.name),
        runs=panel.settings.runs,
        resumes=True,
    )
    rig.desk.start(job, panel)
    return Done()


def answer(rig: Rig, request: ApiRequest) -> Done:
    """Answer the open prompt."""
    body: GiveAnswer = request.body
    rig.desk.answer(body.prompt, body.text, request.by)
    return Done()


def pause(rig: Rig, request: ApiRequest) -> Done:
    """Pause at the next safe point."""
    rig.desk.pause(request.by)
    return Done()


def decision_handler(choice: Choice) -> Callable[[Rig, ApiRequest], Done]:
    """Return a handler that resumes a paused run in this way, with the body's reason or remark."""

    def decide(rig: Rig, request: ApiRequest) -> Done:
        text = getattr(request.body, "text" if choice is Choice.NOTE else "reason", "")
        rig.desk.decide(choice, request.by, text.strip())
        return Done()

    return decide


def abort(rig: Rig, request: ApiRequest) -> Done:
    """End the run in order."""
    body: Why = request.body
    rig.sequence.stop()
    rig.desk.abort(request.by, body.reason.strip())
    return Done()


def stop(panel: Panel, request: ApiRequest) -> Stopped:
    """Make the rig safe at once, for any client; all rigs if none is named."""
    body: Why = request.body
    name = request.query.get("rig", "")
    rigs = [rig for rig in panel.open_rigs() if name in ("", rig.name)]
    if not rigs and name:
        raise not_found(f"there is no rig '{name[:80]}'", "see GET /api/v1/rigs")
    by, reason = panel.name_of(request.client), body.reason.strip()
    for rig in rigs:
        rig.sequence.stop()
    # each in its own thread: a rig that does not respond delays no other
    with ThreadPoolExecutor(max(len(rigs), 1)) as pool:
        stopped = list(pool.map(lambda rig: rig.desk.stop(by, reason), rigs))
    return Stopped(stopped=any(stopped))


def _preflight(rig: Rig, body: Pair, digest: str) -> Preflight:
    """Return the preflight that lets this run start; raise PanelError if there is none."""
    preflight: Preflight | None = rig.board.get("preflight")
    checked = rig.checked_files
    hint = "POST /api/v1/preflight first"
    if preflight is None or not preflight.done or checked is None:
        raise wrong_state("no preflight was made", hint)
    if (preflight.procedure, preflight.station) != (body.procedure, body.station):
        raise wrong_state("the preflight was of another procedure or station", hint)
    if checked.digest != digest:
        raise wrong_state("procedure or station has changed since the preflight", hint)
    if time.monotonic() - checked.at_s > FRESH_S:
        raise wrong_state("the preflight is too old", hint)
    return preflight


def _overridden(preflight: Preflight, override: Overridden | None) -> tuple[PreflightItem, ...]:
    """Return the overridden items; raise PanelError for other failed ones and wrong overrides."""
    failed = [item for item in preflight.items if item.state == "fail"]
    overrides = set(override.what) if override else set()
    for name in overrides - {item.override for item in failed if item.override}:
        message = f"'{name[:80]}' cannot be overridden here"
        raise PanelError(422, "invalid", message, "see override of the preflight's items")
    remaining = [item for item in failed if item.override not in overrides]
    if remaining:
        message = "; ".join(f"{item.name}: {item.text}" for item in remaining)
        hint = "fix it, or override items that allow it, with a name and a reason"
        raise PanelError(409, "wrong_state", message, hint)
    return tuple(item for item in failed if item.override in overrides)


def check_inputs(procedure: Path, texts: Mapping[str, str]) -> None:
    """Raise PanelError for an unknown input, or one that is not accepted."""
    inputs = load_procedure(procedure).inputs
    for name, text in texts.items():
        if name not in inputs:
            raise not_found(f"the procedure has no input '{name}'")
        try:
            inputs[name].expected.accept(text)
        except AnswerError as error:
            raise PanelError(422, "invalid", f"{name}: {error.message}", error.hint) from error


def named_runs(rig: Rig, partners: Mapping[str, str]) -> dict[str, str]:
    """Return partner runs, each in the folder of runs; raise PanelError for another, or a path."""
    return {name: rig.panel.history.folder(run).name for name, run in partners.items()}


def _digest(*paths: Path) -> str:
    return hashlib.sha256(b"\0".join(path.read_bytes() for path in paths)).hexdigest()
