"""A run from start to sealed folder: connect, measure, make safe, and finish."""

from __future__ import annotations

from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rigrunner.api.cleanup import noted_on
from rigrunner.api.errors import DeviceError
from rigrunner.api.events import RunFinished, RunPlanned
from rigrunner.api.progress import unseen
from rigrunner.bus import Bus
from rigrunner.clock import utc_text
from rigrunner.engine import run_plan, streams_before
from rigrunner.plan import plan_text
from rigrunner.rig import Rig, note_unsafe
from rigrunner.run.finish import collecting, finish, stoppable
from rigrunner.run.guardian.guarding import guarding, unguarded
from rigrunner.run.left_energised import NOBODY, LeftAsItStandsError, check_left
from rigrunner.run.listening import listeners_of
from rigrunner.run.log import RunLog
from rigrunner.run.overrides import require_overridden, without_time_limits
from rigrunner.run.partners import later_partners
from rigrunner.run.prepare import patience_of
from rigrunner.run.provenance import identities, software
from rigrunner.run.rig_lock import rig_lock
from rigrunner.run.stored import result_by_now
from rigrunner.run.taping import from_tape, mark_of, on_tape
from rigrunner.runfile import RunHeader, RunWriter, create_run_folder, run_lock
from rigrunner.runfile.compressed import LongText
from rigrunner.station.drive_rules import DriveRules

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from contextlib import AbstractContextManager

    from rigrunner.api.devices import Identity, StopToken
    from rigrunner.api.events import EventSink
    from rigrunner.api.progress import Progress
    from rigrunner.engine import (
        AnswerSource,
        Interference,
        Override,
        Pauses,
        ResumePoint,
        RunSummary,
    )
    from rigrunner.rig import Pulse
    from rigrunner.rig_state import RigMarks
    from rigrunner.run.finish import FinishedRun
    from rigrunner.run.guardian.guarding import Guardian
    from rigrunner.run.left_energised import Person
    from rigrunner.run.prepare import Planned


def execute(
    planned: Planned,
    *,
    runs: Path,
    inputs: Mapping[str, str],
    partners: Mapping[str, Path],
    answers: AnswerSource,
    stop: StopToken,
    listeners: Sequence[EventSink] = (),
    operator: str = "",
    overrides: Sequence[Override] = (),
    pauses: Pauses | None = None,
    progress: Progress = unseen,
    person: Person = NOBODY,
    before: Sequence[Interference] = (),
) -> FinishedRun:
    """Connect the rig, run the plan, seal the folder and write the report.

    `operator` is the name of the operator, by default the input of that name. A rig that is found
    energised is reported to `person`. Actions `before` the run are recorded. Raises
    InvalidFileError if a calibration prevents the start and is not overridden, a DeviceError if the
    rig cannot be connected or another run has it, and DataError if the folder cannot be created.
    Later problems are in the FinishedRun, and the rig is always made safe.
    """
    require_overridden(planned, overrides)
    if (tape := planned.tape) is not None:
        attended = pauses is not None
        planned, answers = on_tape(planned, tape, inputs, overrides, answers, attended=attended)
        pauses = tape.pauses(pauses)
        listeners = (*tape.listeners, *listeners)
    people = {"operator": name} if (name := operator or inputs.get("operator", "")) else {}
    return carry_out(
        planned,
        lambda identified: new_folder(planned, runs, inputs, people, identified, partners),
        inputs=inputs,
        partners=partners,
        answers=answers,
        stop=stop,
        listeners=listeners,
        overrides=overrides,
        pauses=pauses,
        progress=progress,
        person=person,
        before=before,
    )


def carry_out(
    planned: Planned,
    opened: Callable[[Mapping[str, Identity]], AbstractContextManager[RunWriter]],
    *,
    inputs: Mapping[str, str],
    partners: Mapping[str, Path],
    answers: AnswerSource,
    stop: StopToken,
    listeners: Sequence[EventSink] = (),
    overrides: Sequence[Override] = (),
    pauses: Pauses | None = None,
    progress: Progress = unseen,
    resume_at: ResumePoint | None = None,
    person: Person = NOBODY,
    before: Sequence[Interference] = (),
) -> FinishedRun:
    """Connect the rig, run the plan into the folder that is `opened`, seal it, write the report.

    `opened` is called with the identities of the devices, and holds the folder until it is sealed.
    Raises as `execute`.
    """
    run_stop = stop if planned.tape is None else planned.tape.stop(stop)

    def work(rig: Rig, bus: Bus, folder: Path, rig_events: Sequence[Interference]) -> RunSummary:
        if resume_at is not None:
            rig.continue_after(streams_before(planned.plan.steps, resume_at))
        return run_plan(
            planned.plan,
            rig,
            bus,
            planned.clock,
            answers,
            run_stop,
            folder.name,
            overrides,
            pauses=pauses,
            resume_at=resume_at,
            before=(*before, *rig_events),
            watches_drives=planned.tape is None or planned.tape.watches_drives,
            inputs=inputs,
            results=partial(result_by_now, folder, planned.procedure.model, planned.registry),
        )

    return into_folder(
        planned,
        opened,
        work,
        inputs=inputs,
        partners=partners,
        listeners=listeners,
        # The plain token: the analysis is not on the tape.
        progress=stoppable(progress, stop),
        person=person,
    )


def into_folder(
    planned: Planned,
    opened: Callable[[Mapping[str, Identity]], AbstractContextManager[RunWriter]],
    work: Callable[[Rig, Bus, Path, Sequence[Interference]], RunSummary],
    *,
    inputs: Mapping[str, str],
    partners: Mapping[str, Path],
    listeners: Sequence[EventSink],
    progress: Progress,
    person: Person,
) -> FinishedRun:
    """Connect the rig, let `work` measure into the folder that is `opened`, seal it, report.

    `work` is called with the rig, the bus, the folder of the run, and events on how the rig was
    found. Raises as `execute`.
    """
    errors: list[BaseException] = []
    with ExitStack() as stack:
        # Outermost: the listeners hear how the run ended, after the rig is free.
        station_listeners = stack.enter_context(listeners_of(planned))
        with rig_lock(planned) as marks, guarded(planned, marks) as guardian:
            rig = rig_of(planned, marks, guardian.pulse if guardian else None)
            identified = rig.connect()
            try:
                file, reads = planned.station.document.name, planned.tape is None
                # A person may be asked whether the rig may be made safe, and may take any time.
                with rig.person():
                    before = check_left(rig, marks, person, file, reads=reads)
                if marks is not None:
                    before = (*before, *unguarded(planned.station, planned.registry, marks.roles))
                before = (*before, *without_time_limits(planned.station))
                writer = stack.enter_context(opened(identified))
                if marks is not None:
                    marks.describe(run=str(writer.folder.absolute()))
                station_listeners.send(RunPlanned, **_run_fields(planned, writer.folder, inputs))
                with open_log(writer.folder) as logs:
                    beats = [guardian.pulse.note] if guardian else []
                    tracers = [log.trace for log in logs]
                    bus = Bus(
                        writer.sinks, [*logs, *beats, *station_listeners.sinks, *listeners], tracers
                    )
                    summary = work(rig, bus, writer.folder, before)
                if marks is not None:
                    # The run has recorded how it found the rig: the old marker is not needed.
                    marks.put_on_record()
            except BaseException as error:
                # A person refused to make it safe: something may be in the way of its drives.
                if not isinstance(error, LeftAsItStandsError):
                    note_unsafe(error, rig.make_safe())
                with noted_on(error, "closing the rig"):
                    rig.close()
                raise
            rig.make_safe()
            with collecting(errors):
                rig.close()
        # First: an error while closing the rig came after it.
        if summary.error is not None:
            errors.insert(0, summary.error)
        # From here on the rig is free for others; the folder stays locked until it is sealed.
        end = (summary.outcome, summary.reason, summary.passed_over)
        finished = finish(
            planned,
            writer,
            end,
            partners,
            errors,
            progress=progress,
            to_be_resumed=summary.resumable
            and isinstance(summary.error, DeviceError)
            and planned.tape is None,
        )
        station_listeners.send(
            RunFinished,
            outcome=finished.outcome,
            reason=finished.reason,
            verdict=str((finished.result and finished.result.verdict) or ""),
            report=str(finished.report or ""),
        )
        return replace(finished, unsafe=summary.unsafe)


def _run_fields(planned: Planned, folder: Path, inputs: Mapping[str, str]) -> dict[str, Any]:
    """Return the fields of the event for the listeners of the station before a run."""
    register = planned.station.register
    return {
        "run_id": folder.name,
        "folder": str(folder.absolute()),
        "station": planned.station.model.id,
        "procedure": planned.procedure.model.id,
        "title": planned.procedure.model.title,
        "inputs": dict(inputs),
        "due": {entry.name: str(entry.due) for entry in register.values() if entry.due},
    }


@contextmanager
def open_log(folder: Path) -> Iterator[list[RunLog]]:
    """Yield the log as a sink; none if it is not writable: the journal has everything."""
    try:
        log = RunLog(folder / "run.log")
    except OSError:
        yield []
        return
    with log:
        yield [log]


def guarded(planned: Planned, marks: RigMarks | None) -> AbstractContextManager[Guardian | None]:
    """Start a guardian for the rig of a planned run while it is held."""
    station, patience = planned.station, patience_of(planned.station)
    what = planned.procedure.model.id
    return guarding(station, planned.registry, marks, patience, what, messages=planned.messages)


def rig_of(planned: Planned, marks: RigMarks | None = None, pulse: Pulse | None = None) -> Rig:
    """Return the rig of a planned run with the rules of the station; not connected."""
    safety = planned.station.model.safety
    rules = DriveRules(safety.drives, safety.combinations)
    patience = patience_of(planned.station)
    rig = Rig(
        planned.devices, planned.clock, patience, safety.order, rules, marks=marks, pulse=pulse
    )
    rig.messages = planned.messages
    return rig


@contextmanager
def new_folder(  # noqa: PLR0917  (what a header is made of)
    planned: Planned,
    runs: Path,
    inputs: Mapping[str, str],
    people: Mapping[str, str],
    identified: Mapping[str, Identity],
    partners: Mapping[str, Path],
) -> Iterator[RunWriter]:
    """Create a folder and yield its writer, while no other process may write there."""
    procedure, started = planned.procedure, planned.clock.utc()
    specimen, mark = inputs.get("specimen", ""), mark_of(planned.tape)
    folder = create_run_folder(runs, started, procedure.model.id, specimen, mark)
    fields: dict[str, Any] = {
        "people": people,
        "provenance": software(planned.registry) | identities(identified) | from_tape(planned.tape),
        "files": _files(planned, partners),
    }
    # The header is not kept, since its texts may be long.
    with (
        run_lock(folder),
        RunWriter(
            folder,
            replace(header_of(planned, folder.name, inputs), **fields),
            sync_measurements=syncs_measurements(planned),
        ) as writer,
    ):
        yield writer


def syncs_measurements(planned: Planned) -> bool:
    """Return whether the station wants each measured value on the disk at once."""
    return planned.station.model.durability.sync == "each_measurement"


def header_of(planned: Planned, run_id: str, inputs: Mapping[str, str]) -> RunHeader:
    """Return the header of a run from its plan, at the time of its clock."""
    procedure, station = planned.procedure, planned.station
    return RunHeader(
        run_id=run_id,
        started_utc=utc_text(planned.clock.utc()),
        procedure_id=procedure.model.id,
        procedure_revision=procedure.model.revision,
        procedure_title=procedure.model.title,
        station_id=station.model.id,
        procedure_text=procedure.text,
        station_text=station.text,
        plan_text=LongText(plan_text(planned.plan)),
        called_texts=procedure.called_texts,
        inputs=inputs,
        approval=planned.approval.texts(),
    )


def _files(planned: Planned, partners: Mapping[str, Path]) -> dict[str, str]:
    """Return the origin of the files, for resuming the run.

    A partner run that does not exist yet has no path.
    """
    paths: dict[str, str | Path] = {
        "procedure": planned.procedure.document.name,
        "station": planned.station.document.name,
        **dict.fromkeys(later_partners(planned), ""),
        **partners,
    }
    return {name: str(Path(path).absolute()) if path else "" for name, path in paths.items()}
