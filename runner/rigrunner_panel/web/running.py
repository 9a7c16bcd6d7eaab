"""Preflight, start, and what is asked of a run in progress."""

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
from rigrunner_panel.web.looking import named_file
from rigrunner_panel.web.panel import LookedAt

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from rigrunner_panel.view.sections import Preflight
    from rigrunner_panel.web.asked import Asked
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

NOTHING: Mapping[str, str] = MappingProxyType({})
FRESH_S = 15 * 60.0
"""How long a preflight counts."""


def take_control(rig: Rig, asked: Asked) -> Done:
    """Let this client steer."""
    body: TakeControl = asked.body
    name = body.name.strip()
    before = rig.control.take(asked.client, name, rig.panel.now(), take_over=body.take_over)
    if before is not None:
        subject = f"control was with {before.name}"
        rig.desk.put_on_record(Interference("take over", name, subject=subject))
    return Done()


def release_control(rig: Rig, asked: Asked) -> Done:
    """Let somebody else steer."""
    rig.control.release(asked.client)
    return Done()


def start_preflight(rig: Rig, asked: Asked) -> Done:
    """Connect to the rig and look; what is found comes in the state."""
    begin_preflight(rig, asked.body, asked.by)
    return Done()


def begin_preflight(rig: Rig, body: StartPreflight, by: str) -> None:
    """Start to look at the rig; raise PanelError while it is in use."""
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
    rig.looked_at = LookedAt(digest=digest, at_s=time.monotonic())


def ready_preflight(rig: Rig, body: Pair) -> bool:
    """Say whether the last preflight was of these files, is fresh, and found nothing wrong."""
    try:
        return _preflight(rig, body, _digest(*files(rig.panel, body))).may_start
    except PanelError:
        return False


def start_job(
    rig: Rig,
    kind: Literal["run", "manual"],
    body: StartRun | OpenManual,
    by: str,
    inputs: Mapping[str, str] = NOTHING,
    *,
    entry: int | None = None,
) -> None:
    """Start a job that moves the rig; raise PanelError where the preflight does not let it."""
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


def resume_stored(rig: Rig, asked: Asked) -> Done:
    """Resume an interrupted run where it was interrupted; the process checks what is the same."""
    body: ResumeRun = asked.body
    panel, run = rig.panel, asked.path["run"]
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
        operator=asked.by,
        realtime=body.realtime,
        started_utc=header.started_utc,
    )
    paths = [
        panel.catalogue.path("procedure", procedure),
        panel.catalogue.path("station", rig.name),
    ]
    job = Job(
        view=view, procedure=paths[0], station=paths[1], runs=panel.settings.runs, resumes=True
    )
    rig.desk.start(job, panel)
    return Done()


def answer(rig: Rig, asked: Asked) -> Done:
    """Answer the open prompt."""
    body: GiveAnswer = asked.body
    rig.desk.answer(body.prompt, body.text, asked.by)
    return Done()


def pause(rig: Rig, asked: Asked) -> Done:
    """Pause at the next safe point."""
    rig.desk.pause(asked.by)
    return Done()


def deciding(choice: Choice) -> Callable[[Rig, Asked], Done]:
    """Return what decides how a paused run is resumed, with the reason or remark of the body."""

    def decide(rig: Rig, asked: Asked) -> Done:
        said = getattr(asked.body, "text" if choice is Choice.NOTE else "reason", "")
        rig.desk.decide(choice, asked.by, said.strip())
        return Done()

    return decide


def abort(rig: Rig, asked: Asked) -> Done:
    """End the run in order."""
    body: Why = asked.body
    rig.sequence.stop()
    rig.desk.abort(asked.by, body.reason.strip())
    return Done()


def stop(panel: Panel, asked: Asked) -> Stopped:
    """Make the rig safe at once, for any client; all rigs if none is named."""
    body: Why = asked.body
    named = asked.query.get("rig", "")
    rigs = [each for each in panel.opened() if named in ("", each.name)]
    if not rigs and named:
        raise not_found(f"there is no rig '{named[:80]}'", "see GET /api/v1/rigs")
    by, reason = panel.name_of(asked.client), body.reason.strip()
    for each in rigs:
        each.sequence.stop()
    # each in a thread of its own: a rig that does not take the word holds up no other
    with ThreadPoolExecutor(max(len(rigs), 1)) as at_once:
        stopped = list(at_once.map(lambda each: each.desk.stop(by, reason), rigs))
    return Stopped(stopped=any(stopped))


def _preflight(rig: Rig, body: Pair, digest: str) -> Preflight:
    """Return the preflight that lets this run start; raise PanelError if there is none."""
    found: Preflight | None = rig.board.get("preflight")
    looked = rig.looked_at
    hint = "POST /api/v1/preflight first"
    if found is None or not found.done or looked is None:
        raise wrong_state("no preflight was made", hint)
    if (found.procedure, found.station) != (body.procedure, body.station):
        raise wrong_state("the preflight was of another procedure or station", hint)
    if looked.digest != digest:
        raise wrong_state("procedure or station has changed since the preflight", hint)
    if time.monotonic() - looked.at_s > FRESH_S:
        raise wrong_state("the preflight is too old", hint)
    return found


def _overridden(found: Preflight, override: Overridden | None) -> tuple[PreflightItem, ...]:
    """Return what is let pass; raise PanelError for what is not, and for what needs it not."""
    failed = [each for each in found.items if each.state == "fail"]
    words = set(override.what) if override else set()
    for word in words - {each.override for each in failed if each.override}:
        message = f"'{word[:80]}' cannot be overridden here"
        raise PanelError(422, "invalid", message, "see override of the preflight's items")
    left = [each for each in failed if each.override not in words]
    if left:
        message = "; ".join(f"{each.name}: {each.text}" for each in left)
        hint = "fix it, or override items that allow it, with a name and a reason"
        raise PanelError(409, "wrong_state", message, hint)
    return tuple(each for each in failed if each.override in words)


def check_inputs(procedure: Path, given: Mapping[str, str]) -> None:
    """Raise PanelError for an input that is not asked for, or not accepted."""
    inputs = load_procedure(procedure).inputs
    for name, text in given.items():
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
