"""The files of the queues, one per station; each change rewrites the file."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING
from urllib.parse import quote

from filelock import FileLock, Timeout
from pydantic import ValidationError

from rigrunner.api.errors import DataError, InvalidFileError, Problem, UsageError
from rigrunner.api.events import RunStarted
from rigrunner.clock import utc_text
from rigrunner.queue.entries import OPEN, Entry, Stored
from rigrunner.queue.tested import tested_before
from rigrunner.run.runs import listed_run
from rigrunner.runfile import NEVER_ENDED
from rigrunner.runfile.durable import reading, write_whole, writing

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.events import Event, EventSink
    from rigrunner.queue.entries import Draft, State, Status

FILES = "queue-*.json"
COMMON_FILE = "queue.json"
"""File of earlier versions with the entries of all stations."""
MOST_ENTRIES = 5000
"""The file of a queue is read and written whole."""
PATIENCE_S = 5.0
_MOVABLE = ("proposed", "waiting", "held")


@dataclass(frozen=True)
class Shown:
    """An entry with its status and, once its run is over, its outcome."""

    entry: Entry
    status: Status
    outcome: str = ""


class Queue:
    """The queues of a folder of runs, one per station.

    Any process can open them; each change is atomic and synced. A number is used for one entry
    only, over all stations.
    """

    def __init__(self, runs: Path) -> None:
        self._runs = runs
        self._outcomes: dict[str, str] = {}
        """Outcomes of sealed runs, which do not change."""

    def path(self, station: str) -> Path:
        """Return the file of the queue of a station."""
        return self._runs / f"queue-{quote(station, safe='')}.json"

    def changed_ns(self, station: str) -> int:
        """Return the time of the last change of a file, in ns; 0 if it does not exist."""
        try:
            return self.path(station).stat().st_mtime_ns
        except OSError:
            return 0

    def stations(self) -> list[str]:
        """Return the stations with entries; raise DataError for an unreadable file."""
        return list(dict.fromkeys(entry.station for entry in self.entries()))

    def entries(self, station: str = "") -> tuple[Entry, ...]:
        """Return the entries in order, by station; raise DataError for an unreadable file."""
        self._split_common_file()
        if station:
            return _read(self.path(station)).entries
        return tuple(entry for stored in self._all() for entry in stored.entries)

    def shown(self, station: str = "") -> list[Shown]:
        """Return the entries in order, each with its status; of one station, if given."""
        return [self._show(entry) for entry in self.entries(station)]

    def get(self, number: int) -> Entry:
        """Return one entry; raise UsageError, or DataError for an unreadable file."""
        self._split_common_file()
        unread: DataError | None = None
        for path in self._files():
            try:
                entries = [entry for entry in _read(path).entries if entry.id == number]
            except DataError as error:  # the other stations need not care
                unread = error
                continue
            if entries:
                return entries[0]
        raise unread or _unknown_entry_error(number)

    def next(self, station: str = "") -> Entry | None:
        """Return the first waiting entry; None for none.

        Raises UsageError while an interrupted entry needs a decision, and if entries of several
        stations wait and no station is given.
        """
        all_shown = self.shown(station)
        for shown in all_shown:
            if shown.status == "interrupted":
                raise _interrupted_error(shown.entry)
        waiting = [shown.entry for shown in all_shown if shown.status == "waiting"]
        stations = list(dict.fromkeys(shown.station for shown in waiting))
        if len(stations) > 1:
            message = f"entries of {len(stations)} stations wait: {', '.join(stations)}"
            raise UsageError(message, hint="name one of them: --station")
        return waiting[0] if waiting else None

    def add(
        self,
        drafts: Sequence[Draft],
        by: str,
        now: datetime,
        *,
        procedure_id: str = "",
        proposed: bool = False,
        invalid: Sequence[Problem] = (),
    ) -> list[Entry]:
        """Add entries to the end of a queue, all or none; proposed ones wait for release.

        Raises InvalidFileError with all problems: those of the lines that are `invalid`, each
        specimen that is already in a queue for the same procedure, and each that a run of
        `procedure_id` has tested. The last ones are of the field `again`, which a draft gives.
        """
        if invalid and not drafts:
            raise InvalidFileError(invalid)
        (station,) = {draft.station for draft in drafts}
        specimens = {draft.specimen for draft in drafts} if procedure_id else ()
        tested = tested_before(self._runs, procedure_id, specimens)
        added: list[Entry] = []

        def change(stored: Stored) -> Stored:
            if len(stored.entries) + len(drafts) > MOST_ENTRIES:
                raise UsageError(
                    f"the queue has room for {MOST_ENTRIES} entries",
                    hint="clear finished entries first",
                )
            all_stored = self._all()
            next_id = max((stored.next for stored in all_stored), default=1)
            queued = [entry for stored in all_stored for entry in stored.entries]
            problems = list(invalid)
            for draft in drafts:
                if self._same_test(added, draft) is not None:
                    problems.append(Problem(f"{draft.specimen} is in the list twice"))
                    continue
                same = self._same_test(queued, draft)
                problem = _problem(draft, same, tested.get(draft.specimen, ""))
                if problem is not None and not (draft.again and problem.field):
                    problems.append(problem)
                fields = set(type(draft).model_fields) - {"again"}
                again = draft.again if problem is not None else ""
                entry = Entry(
                    **draft.model_dump(include=fields),
                    again=again,
                    id=next_id + len(added),
                    state="proposed" if proposed else "waiting",
                    by=by,
                    added_utc=utc_text(now),
                    repeated_by=by if again else "",
                )
                added.append(entry)
            if problems:
                raise InvalidFileError(problems)
            return Stored(next=next_id + len(added), entries=(*stored.entries, *added))

        self._change(station, change)
        return added

    def move(self, number: int, before: int | None) -> None:
        """Move an entry that has not started before another one of its station, or to the end."""

        def change(stored: Stored) -> Stored:
            entry = self._entry_in(stored, number, *_MOVABLE)
            others = [entry for entry in stored.entries if entry.id != number]
            if before is not None and before != number:
                at = others.index(_entry(stored.entries, before))
            else:
                at = len(others) if before is None else stored.entries.index(entry)
            return stored.model_copy(update={"entries": (*others[:at], entry, *others[at:])})

        self._change(self.get(number).station, change)

    def hold(self, number: int, by: str, reason: str = "") -> None:
        """Hold an entry until it is released."""
        self._set(number, "held", by, reason, "waiting", "proposed")

    def release(self, number: int, by: str) -> None:
        """Release an entry that was proposed or held."""
        self._set(number, "waiting", by, "", "proposed", "held")

    def skip(self, number: int, by: str, reason: str) -> None:
        """Skip an entry, or close one whose run was interrupted."""
        entry = self.get(number)
        state: State = "closed" if entry.state == "started" else "skipped"
        self._set(number, state, by, reason, *_MOVABLE, "interrupted")

    def repeat(self, number: int, by: str, reason: str, now: datetime) -> Entry:
        """Return a new entry for the same test, placed right after the one it repeats."""
        added: list[Entry] = []

        def change(stored: Stored) -> Stored:
            old = self._entry_in(stored, number, "done", "interrupted", "skipped", "closed")
            repeats = [entry for entry in stored.entries if entry.repeats == number]
            if any(self._show(repeat).status in OPEN for repeat in repeats):
                raise UsageError(f"entry {number} was already repeated: entry {repeats[-1].id}")
            next_id = max(stored.next for stored in self._all())
            new = old.model_copy(
                update={
                    "id": next_id, "state": "waiting", "by": by, "added_utc": utc_text(now),
                    "reason": reason, "again": reason, "repeats": number, "repeated_by": by,
                    "run": "",
                }
            )  # fmt: skip
            added.append(new)
            if self._show(old).status == "interrupted":
                old = old.model_copy(update={"state": "closed", "by": by, "reason": reason})
            at = [entry.id for entry in stored.entries].index(number)
            entries = (*stored.entries[:at], old, new, *stored.entries[at + 1 :])
            return Stored(next=next_id + 1, entries=entries)

        self._change(self.get(number).station, change)
        return added[0]

    def clear(self, station: str = "") -> int:
        """Remove finished entries, and return their number; their runs stay."""
        removed = 0

        def change(stored: Stored) -> Stored:
            nonlocal removed
            left = tuple(each for each in stored.entries if self._show(each).status in OPEN)
            removed += len(stored.entries) - len(left)
            return stored.model_copy(update={"entries": left})

        for name in [station] if station else self.stations():
            self._change(name, change)
        return removed

    @contextmanager
    def started(self, number: int, by: str) -> Iterator[Entry]:
        """Mark a waiting entry as started, and hold its lock while its run lasts.

        The mark is on the disk before this returns: a marked entry without a finished run is
        'interrupted' later, and never runs again unless a person says so. Raises UsageError for an
        entry that is not waiting.
        """
        entry = self.get(number)
        if self._show(entry).status == "interrupted":  # once locked below, it would be 'running'
            raise _interrupted_error(entry)
        lock = self._entry_lock(number)
        with writing(self._runs):
            try:
                with self._probe_lock():
                    lock.acquire(timeout=0)
            except Timeout as error:
                raise UsageError(f"entry {number} is already running") from error
        try:
            self._set(number, "started", by, entry.reason, "waiting")
            yield self.get(number)
        finally:
            with suppress(OSError):  # on Windows a file that is open cannot be removed
                self._lock_file(number).unlink()
            lock.release()

    def began(self, number: int) -> EventSink:
        """Return a listener that stores the id of the run as soon as it has begun."""

        def note(event: Event) -> None:
            if isinstance(event, RunStarted):
                self._replace(number, run=event.run_id)

        return note

    def give_back(self, number: int, reason: str, run: str = "") -> None:
        """Hold an entry whose run could not begin, with the reason; nothing has moved.

        `run` is the id of its run if that has begun, which its listener may have failed to store.
        """
        # Once it has a run, that says how it ended.
        if not self.get(number).run:
            fields = {"run": run} if run else {"state": "held", "reason": reason}
            self._replace(number, **fields)

    def _show(self, entry: Entry) -> Shown:
        if entry.state != "started":
            return Shown(entry, entry.state)
        if entry.run in self._outcomes:
            return Shown(entry, "done", self._outcomes[entry.run])
        if self._is_locked(entry.id):
            return Shown(entry, "running")
        if entry.run:
            run = listed_run(self._runs, entry.run)
            if run.is_in_progress:
                return Shown(entry, "running")
            if run.info is not None and run.info.reason != NEVER_ENDED:
                if run.info.sealed:  # any other run can still be resumed
                    self._outcomes[entry.run] = run.info.outcome
                return Shown(entry, "done", run.info.outcome)
        return Shown(entry, "interrupted")

    def _same_test(self, entries: Iterable[Entry], draft: Draft) -> Shown | None:
        for entry in entries:
            if entry.state not in ("skipped", "closed") and entry.is_same_test(draft):
                return self._show(entry)
        return None

    def _set(self, number: int, state: State, by: str, reason: str, *allowed: str) -> None:
        def change(stored: Stored) -> Stored:
            entry = self._entry_in(stored, number, *allowed)
            new = entry.model_copy(update={"state": state, "by": by, "reason": reason})
            return _with(stored, new)

        self._change(self.get(number).station, change)

    def _replace(self, number: int, **fields: str) -> None:
        self._change(
            self.get(number).station,
            lambda stored: _with(
                stored, _entry(stored.entries, number).model_copy(update=dict(fields))
            ),
        )

    def _entry_in(self, stored: Stored, number: int, *allowed: str) -> Entry:
        entry = _entry(stored.entries, number)
        status = self._show(entry).status
        if status not in allowed:
            expected = " or ".join(allowed)
            raise UsageError(f"entry {number} is {status}, expected {expected}")
        return entry

    def _files(self) -> list[Path]:
        return sorted(self._runs.glob(FILES))

    def _all(self) -> list[Stored]:
        return [_read(path) for path in self._files()]

    def _split_common_file(self) -> None:
        """Split a file with the entries of all stations into one per station."""
        common_file = self._runs / COMMON_FILE
        with reading(self._runs):
            if not common_file.exists():
                return
        with self._locked():
            # Empty if another process has split it meanwhile.
            common = _read(common_file)
            for station in dict.fromkeys(entry.station for entry in common.entries):
                path = self.path(station)
                stored = _read(path)
                # What a split wrote before it was interrupted is not written twice, nor undone.
                numbers = {entry.id for entry in stored.entries}
                moved = [
                    entry
                    for entry in common.entries
                    if entry.station == station and entry.id not in numbers
                ]
                entries = (*moved, *stored.entries)
                _write(path, Stored(next=max(common.next, stored.next), entries=entries))
            with writing(common_file):
                common_file.unlink(missing_ok=True)

    def _change(self, station: str, change: Callable[[Stored], Stored]) -> None:
        self._split_common_file()
        with self._locked():
            path = self.path(station)
            before = _read(path)
            after = change(before)
            if after != before:
                _write(path, after)

    @contextmanager
    def _locked(self) -> Iterator[None]:
        """Lock all queues of the folder, since specimens are searched in all of them."""
        lock = FileLock(self._runs / ".queue.lock", timeout=PATIENCE_S)
        with writing(self._runs):
            self._runs.mkdir(parents=True, exist_ok=True)
            try:
                lock.acquire()
            except Timeout as error:  # it is an OSError as well
                since = f"for longer than {PATIENCE_S:g} s"
                message = f"another process has had {self._runs} open {since}"
                raise DataError(message, hint="try again") from error
        try:
            yield
        finally:
            lock.release()

    def _lock_file(self, number: int) -> Path:
        return self._runs / f".queue-{number}.lock"

    def _entry_lock(self, number: int) -> FileLock:
        return FileLock(self._lock_file(number), thread_local=False)

    def _probe_lock(self) -> FileLock:
        """Return the lock for testing the lock of an entry: two such tests are no run."""
        return FileLock(self._runs / ".queue.look.lock", timeout=PATIENCE_S)

    def _is_locked(self, number: int) -> bool:
        # FileLock would create it.
        if not self._lock_file(number).exists():
            return False
        try:
            with self._probe_lock(), self._entry_lock(number).acquire(timeout=0):
                return False
        except Timeout:
            return True
        except OSError:
            return False


def _entry(entries: Sequence[Entry], number: int) -> Entry:
    for entry in entries:
        if entry.id == number:
            return entry
    raise _unknown_entry_error(number)


def _unknown_entry_error(number: int) -> UsageError:
    return UsageError(f"the queue has no entry {number}")


def _with(stored: Stored, new: Entry) -> Stored:
    entries = tuple(new if entry.id == new.id else entry for entry in stored.entries)
    return stored.model_copy(update={"entries": entries})


def _problem(draft: Draft, same: Shown | None, tested: str) -> Problem | None:
    """Return why a draft needs a reason (field `again`), or cannot be added at all."""
    hint = "give a reason to test it again"
    if tested and (same is None or same.status == "done"):
        return Problem(tested, field="again", hint=hint)
    if same is None:
        return None
    entry, status = same.entry, same.status
    number, queue = f"entry {entry.id}, {status}", entry.station
    message = f"{entry.specimen} is already in the queue: {number}"
    if queue != draft.station:
        message = f"{entry.specimen} is already in the queue of {queue}: {number}"
    return Problem(message, field="again", hint=hint) if status == "done" else Problem(message)


def _interrupted_error(entry: Entry) -> UsageError:
    number = entry.id
    options = [f"continue it: 'rigrunner resume {entry.run}'"] if entry.run else []
    options += [
        f"test it again: 'rigrunner queue repeat {number} --reason TEXT'",
        f"or close the entry: 'rigrunner queue skip {number} --reason TEXT'",
    ]
    return UsageError(
        f"the run of entry {number} ({entry.specimen or entry.procedure}) was interrupted",
        hint="; ".join(options),
    )


def _read(path: Path) -> Stored:
    with reading(path):
        try:
            content = path.read_bytes()
        except FileNotFoundError:
            return Stored()
    try:
        return Stored.model_validate_json(content)
    except ValidationError as error:
        detail = error.errors(include_url=False)[0]
        where = ": ".join((".".join(map(str, detail["loc"])), detail["msg"])).removeprefix(": ")
        raise DataError(
            f"{path} is not a queue of this version: {where}",
            hint="correct the file, or move it away to start a new queue",
        ) from error


def _write(path: Path, stored: Stored) -> None:
    write_whole(path, f"{stored.model_dump_json(indent=1)}\n".encode())
