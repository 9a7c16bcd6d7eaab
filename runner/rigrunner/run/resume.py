"""Resumes an interrupted run on the same rig, with the same files and software."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from itertools import zip_longest
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.events import Outcome
from rigrunner.api.progress import unseen
from rigrunner.engine import find_resume_point, passed_over
from rigrunner.plan import plan_text
from rigrunner.run.finish import finish, stoppable
from rigrunner.run.interrupted import has_ended, may_be_resumed, used_partners
from rigrunner.run.left_energised import NOBODY
from rigrunner.run.overrides import require_still_allowed
from rigrunner.run.partners import later_partners, partners_after_for, partners_for
from rigrunner.run.provenance import identities, software
from rigrunner.run.record import carry_out, syncs_measurements
from rigrunner.runfile import RunWriter
from rigrunner.runfile.compressed import LongText
from rigrunner.station import load_station

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner.api.devices import Identity, StopToken
    from rigrunner.api.events import EventSink
    from rigrunner.api.progress import Progress
    from rigrunner.engine import AnswerSource, Pauses, ResumePoint
    from rigrunner.run.finish import FinishedRun
    from rigrunner.run.left_energised import Person
    from rigrunner.run.prepare import Planned
    from rigrunner.runfile import RunHeader, StoredRun


@dataclass(frozen=True, eq=False)
class ResumableRun:
    """An interrupted run that can be resumed, checked in every way that needs no rig."""

    folder: Path
    stored: StoredRun
    planned: Planned
    partners: Mapping[str, Path]
    """By name; including those after it, if the procedure requires any and the run had ended."""
    resume_at: ResumePoint | None
    """None if the run had ended, and only its file is missing."""


def run_files(stored: StoredRun, procedure: Path | None, station: Path | None) -> tuple[Path, Path]:
    """Return the procedure and the station of a run: as given, or as at its start.

    Raises UsageError if one is missing, and if the station brings plugins: a folder of files from
    elsewhere must not choose the code that runs. An import cannot be resumed: another program
    controlled its rig.
    """
    if stored.header.imported:
        raise UsageError(
            f"{stored.header.run_id} is an interrupted import, which cannot be resumed",
            hint="remove the folder, and import again: the original recordings are unchanged",
        )
    files = procedure or _file(stored, "procedure"), station or _file(stored, "station")
    if station is None and load_station(files[1]).model.plugins is not None:
        raise UsageError(
            f"the station {files[1]} has plugins of its own",
            hint=f"say that you trust them: --station {files[1]}",
        )
    return files


def prepare_resume(
    folder: Path,
    stored: StoredRun,
    planned: Planned,
    by: str,
    named: Mapping[str, str] = MappingProxyType({}),
) -> ResumableRun:
    """Check that a run can be resumed and find where; raise DataError with all differences.

    `named` are partner runs named by a person, by folder or name. A run that waits for one after it
    gets the first that fits.
    """
    _refuse_changes(stored.header, _differences(stored.header, planned))
    resume_at = None
    started = datetime.fromisoformat(stored.header.started_utc)
    if may_be_resumed(stored):
        require_still_allowed(planned, started)
        names, rows = stored.info.recording_names, len(stored.measurements)
        recorded = [f"recordings made before: {', '.join(names)}"] if names else []
        recorded += [f"rows measured before: {rows}"] if rows else []
        subject = "; ".join((how_it_ended(stored), *(recorded or ["nothing recorded before"])))
        events = tuple(stored.events)  # several passes
        resume_at = find_resume_point(planned.plan.steps, events, by, subject)
    later, ended = later_partners(planned), None if resume_at is not None else started
    used = {name: str(path) for name, path in used_partners(stored.header).items()} | dict(named)
    before = {name: path for name, path in used.items() if name not in later}
    chosen = partners_for(planned, folder.parent, before, ended)
    if ended is not None and stored.info.outcome == Outcome.COMPLETED:
        after = {name: path for name, path in named.items() if name in later}
        chosen |= partners_after_for(planned, folder.parent, after, ended)
    return ResumableRun(folder, stored, planned, chosen, resume_at)


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
    another instrument answers; the rig is always made safe.
    """
    if run.resume_at is None:
        return _finish(run, stoppable(progress, stop))

    @contextmanager
    def open_folder(identified: Mapping[str, Identity]) -> Iterator[RunWriter]:
        check_same_instruments(run.stored.header, identified)
        at_once = syncs_measurements(run.planned)
        with RunWriter(run.folder, sync_measurements=at_once) as writer:
            yield writer

    return carry_out(
        run.planned,
        open_folder,
        inputs=run.stored.header.inputs,
        partners=run.partners,
        answers=answers,
        stop=stop,
        listeners=listeners,
        pauses=pauses,
        progress=progress,
        resume_at=run.resume_at,
        person=person,
    )


def how_it_ended(stored: StoredRun) -> str:
    """Return when and why a run was interrupted or ended, as text."""
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
    end = outcome, info.reason, tuple(passed_over(run.stored.outline))
    with RunWriter(run.folder) as writer:
        return finish(run.planned, writer, end, run.partners, errors, progress=progress)


def _file(stored: StoredRun, what: str) -> Path:
    file = stored.header.files.get(what, "")
    if file and Path(file).is_file():
        return Path(file)
    lost = f"its {what}, {file}, no longer exists" if file else f"it names no {what}"
    raise UsageError(f"{stored.header.run_id}: {lost}", hint=f"give it: --{what} FILE")


DEVICE = "device "
"""Prefix of instruments in the provenance of a run."""
_SHOWN = 60


def check_same_instruments(header: RunHeader, identified: Mapping[str, Identity]) -> None:
    """Raise DataError if other instruments answer than at the start."""
    before = {name: text for name, text in header.provenance.items() if name.startswith(DEVICE)}
    _refuse_changes(header, _changed(before, identities(identified)))


def _refuse_changes(header: RunHeader, differences: Iterable[str]) -> None:
    changes = list(differences)
    if changes:
        raise DataError(
            f"{header.run_id} cannot be resumed, as something has changed: {'; '.join(changes)}",
            hint="undo the change, or close the run as it is: 'rigrunner recover'",
        )


def _differences(header: RunHeader, planned: Planned) -> Iterator[str]:
    """Yield everything that changed since the start, except the instruments."""
    procedure, station = planned.procedure, planned.station
    yield from _text_change("the procedure", header.procedure_text, procedure.text)
    called = procedure.called_texts
    for name in sorted({*header.called_texts, *called}):
        before = header.called_texts.get(name, "")
        yield from _text_change(f"the called {name}", before, called.get(name, ""))
    yield from _text_change("the station", header.station_text, station.text)
    software_before = {
        name: text for name, text in header.provenance.items() if not name.startswith(DEVICE)
    }
    changes = list(_changed(software_before, software(planned.registry)))
    yield from changes
    same_texts = (header.procedure_text, header.station_text) == (procedure.text, station.text)
    if same_texts and not changes and header.plan_text != LongText(plan_text(planned.plan)):
        yield "the same files give another plan: a plugin of the station was changed"


def _text_change(what: str, before: str, now: str) -> Iterator[str]:
    """Yield the first difference of a text, if there is one."""
    lines = zip_longest(before.splitlines(), now.splitlines(), fillvalue="")
    for number, (old, new) in enumerate(lines, start=1):
        if old != new:
            yield f"{what} in line {number} was '{_short(old)}', is '{_short(new)}'"
            return
    if before != now:
        yield f"{what} has other line ends"


def _changed(before: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    for name in sorted({*before, *now}):
        old, new = before.get(name, "none"), now.get(name, "none")
        if old != new:
            yield f"{name} was {old}, is {new}"


def _short(line: str) -> str:
    text = line.strip()
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
