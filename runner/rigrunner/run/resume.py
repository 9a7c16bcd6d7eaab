"""Takes up a run that was interrupted: on the same rig, with the same files and software."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.analysis.progress import unseen
from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.events import Outcome
from rigrunner.engine import find_seam, passed_over
from rigrunner.run.finish import finish, stoppable
from rigrunner.run.interrupted import has_ended, may_go_on, used_no_load
from rigrunner.run.left_energised import NOBODY
from rigrunner.run.noload import NamedNoLoads, no_load_after_for, no_load_for
from rigrunner.run.overrides import require_still_allowed
from rigrunner.run.record import carry_out, syncs_measurements
from rigrunner.run.sameness import check_same, check_same_instruments
from rigrunner.runfile import RunWriter
from rigrunner.station import load_station

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.analysis.progress import Progress
    from rigrunner.api.devices import Identity, StopToken
    from rigrunner.api.events import EventSink
    from rigrunner.engine import AnswerSource, Pauses, Seam
    from rigrunner.run.finish import FinishedRun
    from rigrunner.run.left_energised import Person
    from rigrunner.run.prepare import Planned
    from rigrunner.runfile import StoredRun


@dataclass(frozen=True, eq=False)
class ResumableRun:
    """A run that was interrupted and can be taken up, checked in every way that needs no rig."""

    folder: Path
    stored: StoredRun
    planned: Planned
    no_load: Path | None
    seam: Seam | None
    """None where the run had come to its end, and only its file is to be made."""
    no_load_after: Path | None = None
    """The second no-load run, where the procedure asks for one and the run had come to its end."""


def run_files(stored: StoredRun, procedure: Path | None, station: Path | None) -> tuple[Path, Path]:
    """Return the procedure and the station of a run: as given, or where they were at its start.

    Raises UsageError where one is not there any more, and where the station brings plugins of its
    own: a folder of files that came from elsewhere must not choose what code is run. An import is
    not taken up: another program drove its rig.
    """
    if stored.header.imported:
        raise UsageError(
            f"{stored.header.run_id} is an import that was interrupted: its rig is not Rigrunner's",
            hint="remove the folder, and import again: the recordings are where they were",
        )
    found = procedure or _file(stored, "procedure"), station or _file(stored, "station")
    if station is None and load_station(found[1]).model.plugins is not None:
        raise UsageError(
            f"the station {found[1]} brings plugins of its own",
            hint=f"say that you trust them: --station {found[1]}",
        )
    return found


def prepare_resume(
    folder: Path,
    stored: StoredRun,
    planned: Planned,
    by: str,
    no_loads: NamedNoLoads = NamedNoLoads(),  # noqa: B008  (immutable)
) -> ResumableRun:
    """Check that a run can be taken up and find where; raise DataError with all that differs.

    A run that waits for the no-load run after it is given the first one that fits, or the named.
    """
    check_same(stored.header, planned)
    seam, after = None, None
    started = datetime.fromisoformat(stored.header.started_utc)
    if may_go_on(stored):
        require_still_allowed(planned, started)
        seam = find_seam(planned.plan.steps, stored.events, by, _subject(stored))
    named = no_loads.before or (str(used) if (used := used_no_load(stored)) else None)
    ended = None if seam is not None else started
    chosen = no_load_for(planned, folder.parent, named, ended)
    if ended is not None and stored.info.outcome == Outcome.COMPLETED:
        after = no_load_after_for(planned, folder.parent, no_loads.after, ended)
    return ResumableRun(folder, stored, planned, chosen, seam, after)


def resume(
    run: ResumableRun,
    *,
    answers: AnswerSource,
    stop: StopToken,
    listeners: Sequence[EventSink] = (),
    pauses: Pauses | None = None,
    progress: Progress = unseen,
    person: Person = NOBODY,
) -> FinishedRun:
    """Resume a run whose folder is locked by the caller, and finish it.

    Raises a DeviceError if the rig cannot be connected or another run has it, and DataError if
    another instrument answers; the rig is made safe on every way.
    """
    if run.seam is None:
        return _finish(run, stoppable(progress, stop))

    @contextmanager
    def opened(identified: Mapping[str, Identity]) -> Iterator[RunWriter]:
        check_same_instruments(run.stored.header, identified)
        at_once = syncs_measurements(run.planned)
        with RunWriter(run.folder, sync_measurements=at_once) as writer:
            yield writer

    return carry_out(
        run.planned,
        opened,
        inputs=run.stored.header.inputs,
        no_load=run.no_load,
        answers=answers,
        stop=stop,
        listeners=listeners,
        pauses=pauses,
        progress=progress,
        seam=run.seam,
        person=person,
    )


def how_it_ended(stored: StoredRun) -> str:
    """Return in words when a run was interrupted, or ended, and why."""
    info = stored.info
    if not has_ended(stored):
        return f"interrupted after {info.ended_utc}"
    why = f": {info.reason}" if info.reason else ""
    return f"{info.outcome} at {info.ended_utc}{why}"


def _finish(run: ResumableRun, progress: Progress) -> FinishedRun:
    info = run.stored.info
    outcome = Outcome(info.outcome)
    errors: list[BaseException] = []
    if outcome is Outcome.ERROR:
        errors.append(DataError(f"the run had ended by an error: {info.reason}"))
    end = outcome, info.reason, tuple(passed_over(run.stored.events))
    with RunWriter(run.folder) as writer:
        return finish(
            run.planned,
            writer,
            end,
            run.no_load,
            errors,
            progress=progress,
            no_load_after=run.no_load_after,
        )


def _file(stored: StoredRun, what: str) -> Path:
    named = stored.header.files.get(what, "")
    if named and Path(named).is_file():
        return Path(named)
    lost = f"its {what}, {named}, is not there any more" if named else f"it names no {what}"
    raise UsageError(f"{stored.header.run_id}: {lost}", hint=f"give it: --{what} FILE")


def _subject(stored: StoredRun) -> str:
    names, rows = stored.info.recording_names, len(stored.measurements)
    made = [f"recordings made before: {', '.join(names)}"] if names else []
    made += [f"rows measured before: {rows}"] if rows else []
    return "; ".join((how_it_ended(stored), *(made or ["nothing recorded before"])))
