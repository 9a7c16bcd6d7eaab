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
from rigrunner.runfile.durable import write_whole, writing

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
        return list(dict.fromkeys(each.station for each in self.entries()))

    def entries(self, station: str = "") -> tuple[Entry, ...]:
        """Return the entries in order, by station; raise DataError for an unreadable file."""
        self._part_common_file()
        if station:
            return _read(self.path(station)).entries
        return tuple(each for stored in self._all() for each in stored.entries)

    def shown(self, station: str = "") -> list[Shown]:
        """Return the entries in order, each with its status; of one station, if given."""
        return [self._shown(each) for each in self.entries(station)]

    def get(self, number: int) -> Entry:
        """Return one entry; raise UsageError, or DataError for an unreadable file."""
        self._part_common_file()
        unread: DataError | None = None
        for path in self._files():
            try:
                found = [each for each in _read(path).entries if each.id == number]
            except DataError as error:  # the other stations need not care
                unread = error
                continue
            if found:
                return found[0]
        raise unread or _unknown(number)

    def next(self, station: str = "") -> Entry | None:
        """Return the first waiting entry; None for none.

        Raises UsageError while an interrupted entry needs a decision, and if entries of several
        stations wait and no station is given.
        """
        shown = self.shown(station)
        for each in shown:
            if each.status == "interrupted":
                raise _unanswered(each.entry)
        waiting = [each.entry for each in shown if each.status == "waiting"]
        stations = list(dict.fromkeys(each.station for each in waiting))
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
        (station,) = {each.station for each in drafts}
        specimens = {each.specimen for each in drafts} if procedure_id else ()
        tested = tested_before(self._runs, procedure_id, specimens)
        made: list[Entry] = []

        def change(stored: Stored) -> Stored:
            if len(stored.entries) + len(drafts) > MOST_ENTRIES:
                raise UsageError(
                    f"the queue has room for {MOST_ENTRIES} entries",
                    hint="clear finished entries first",
                )
            everywhere = self._all()
            free = max((each.next for each in everywhere), default=1)
            known = [entry for each in everywhere for entry in each.entries]
            problems = list(invalid)
            for draft in drafts:
                if self._same_test(made, draft) is not None:
                    problems.append(Problem(f"{draft.specimen} is in the list twice"))
                    continue
                same = self._same_test(known, draft)
                problem = _problem(draft, same, tested.get(draft.specimen, ""))
                if problem is not None and not (draft.again and problem.field):
                    problems.append(problem)
                asked = set(type(draft).model_fields) - {"again"}
                again = draft.again if problem is not None else ""
                entry = Entry(
                    **draft.model_dump(include=asked),
                    again=again,
                    id=free + len(made),
                    state="proposed" if proposed else "waiting",
                    by=by,
                    added_utc=utc_text(now),
                    repeated_by=by if again else "",
                )
                made.append(entry)
            if problems:
                raise InvalidFileError(problems)
            return Stored(next=free + len(made), entries=(*stored.entries, *made))

        self._change(station, change)
        return made

    def move(self, number: int, before: int | None) -> None:
        """Move an entry that has not started before another one of its station, or to the end."""

        def change(stored: Stored) -> Stored:
            entry = self._in(stored, number, *_MOVABLE)
            rest = [each for each in stored.entries if each.id != number]
            if before is not None and before != number:
                at = rest.index(_found(stored.entries, before))
            else:
                at = len(rest) if before is None else stored.entries.index(entry)
            return stored.model_copy(update={"entries": (*rest[:at], entry, *rest[at:])})

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
        made: list[Entry] = []

        def change(stored: Stored) -> Stored:
            old = self._in(stored, number, "done", "interrupted", "skipped", "closed")
            again = [each for each in stored.entries if each.repeats == number]
            if any(self._shown(each).status in OPEN for each in again):
                raise UsageError(f"entry {number} was already repeated: entry {again[-1].id}")
            free = max(each.next for each in self._all())
            new = old.model_copy(
                update={
                    "id": free, "state": "waiting", "by": by, "added_utc": utc_text(now),
                    "reason": reason, "again": reason, "repeats": number, "repeated_by": by,
                    "run": "",
                }
            )  # fmt: skip
            made.append(new)
            if self._shown(old).status == "interrupted":
                old = old.model_copy(update={"state": "closed", "by": by, "reason": reason})
            at = [each.id for each in stored.entries].index(number)
            entries = (*stored.entries[:at], old, new, *stored.entries[at + 1 :])
            return Stored(next=free + 1, entries=entries)

        self._change(self.get(number).station, change)
        return made[0]

    def clear(self, station: str = "") -> int:
        """Remove finished entries, and return their number; their runs stay."""
        removed = 0

        def change(stored: Stored) -> Stored:
            nonlocal removed
            left = tuple(each for each in stored.entries if self._shown(each).status in OPEN)
            removed += len(stored.entries) - len(left)
            return stored.model_copy(update={"entries": left})

        for each in [station] if station else self.stations():
            self._change(each, change)
        return removed

    @contextmanager
    def started(self, number: int, by: str) -> Iterator[Entry]:
        """Mark a waiting entry as started, and hold its lock while its run lasts.

        The mark is on the disk before this returns: a marked entry without a finished run is
        'interrupted' later, and never runs again unless a person says so. Raises UsageError for an
        entry that is not waiting.
        """
        entry = self.get(number)
        if self._shown(entry).status == "interrupted":  # held below, it would be 'running'
            raise _unanswered(entry)
        lock = self._entry_lock(number)
        try:
            with self._looking():
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

    def give_back(self, number: int, reason: str) -> None:
        """Hold an entry whose run could not begin, with the reason; nothing has moved."""
        # Once it has a run, that says how it ended.
        if not self.get(number).run:
            self._replace(number, state="held", reason=reason)

    def _shown(self, entry: Entry) -> Shown:
        if entry.state != "started":
            return Shown(entry, entry.state)
        if entry.run in self._outcomes:
            return Shown(entry, "done", self._outcomes[entry.run])
        if self._is_held(entry.id):
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
        for each in entries:
            if each.state not in ("skipped", "closed") and each.is_same_test(draft):
                return self._shown(each)
        return None

    def _set(self, number: int, state: State, by: str, reason: str, *allowed: str) -> None:
        def change(stored: Stored) -> Stored:
            entry = self._in(stored, number, *allowed)
            new = entry.model_copy(update={"state": state, "by": by, "reason": reason})
            return _with(stored, new)

        self._change(self.get(number).station, change)

    def _replace(self, number: int, **fields: str) -> None:
        self._change(
            self.get(number).station,
            lambda stored: _with(
                stored, _found(stored.entries, number).model_copy(update=dict(fields))
            ),
        )

    def _in(self, stored: Stored, number: int, *allowed: str) -> Entry:
        entry = _found(stored.entries, number)
        status = self._shown(entry).status
        if status not in allowed:
            expected = " or ".join(allowed)
            raise UsageError(f"entry {number} is {status}, expected {expected}")
        return entry

    def _files(self) -> list[Path]:
        return sorted(self._runs.glob(FILES))

    def _all(self) -> list[Stored]:
        return [_read(path) for path in self._files()]

    def _part_common_file(self) -> None:
        """Split a file with the entries of all stations into one per station."""
        common = self._runs / COMMON_FILE
        if not common.exists():
            return
        with self._locked():
            # Empty if another process has parted it meanwhile.
            before = _read(common)
            for station in dict.fromkeys(each.station for each in before.entries):
                path = self.path(station)
                known = _read(path)
                # What a parting wrote before it was interrupted is not written twice, nor undone.
                numbers = {each.id for each in known.entries}
                more = [
                    each
                    for each in before.entries
                    if each.station == station and each.id not in numbers
                ]
                entries = (*more, *known.entries)
                _write(path, Stored(next=max(before.next, known.next), entries=entries))
            with writing(common):
                common.unlink(missing_ok=True)

    def _change(self, station: str, change: Callable[[Stored], Stored]) -> None:
        self._part_common_file()
        with self._locked():
            path = self.path(station)
            before = _read(path)
            after = change(before)
            if after != before:
                _write(path, after)

    @contextmanager
    def _locked(self) -> Iterator[None]:
        """Lock all queues of the folder, since specimens are searched in all of them."""
        with writing(self._runs):
            self._runs.mkdir(parents=True, exist_ok=True)
        lock = FileLock(self._runs / ".queue.lock", timeout=PATIENCE_S)
        try:
            lock.acquire()
        except Timeout as error:
            message = f"another process has had {self._runs} open for longer than {PATIENCE_S:g} s"
            raise DataError(message, hint="try again") from error
        try:
            yield
        finally:
            lock.release()

    def _lock_file(self, number: int) -> Path:
        return self._runs / f".queue-{number}.lock"

    def _entry_lock(self, number: int) -> FileLock:
        return FileLock(self._lock_file(number), thread_local=False)

    def _looking(self) -> FileLock:
        """Return the lock of who looks at the lock of an entry: two who look are no run."""
        return FileLock(self._runs / ".queue.look.lock", timeout=PATIENCE_S)

    def _is_held(self, number: int) -> bool:
        # FileLock would create it.
        if not self._lock_file(number).exists():
            return False
        try:
            with self._looking(), self._entry_lock(number).acquire(timeout=0):
                return False
        except Timeout:
            return True
        except OSError:
            return False


def _found(entries: Sequence[Entry], number: int) -> Entry:
    for each in entries:
        if each.id == number:
            return each
    raise _unknown(number)


def _unknown(number: int) -> UsageError:
    return UsageError(f"the queue has no entry {number}")


def _with(stored: Stored, new: Entry) -> Stored:
    entries = tuple(new if each.id == new.id else each for each in stored.entries)
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


def _unanswered(entry: Entry) -> UsageError:
    number = entry.id
    ways = [f"continue it: 'rigrunner resume {entry.run}'"] if entry.run else []
    ways += [
        f"test it again: 'rigrunner queue repeat {number} --reason TEXT'",
        f"or close the entry: 'rigrunner queue skip {number} --reason TEXT'",
    ]
    return UsageError(
        f"the run of entry {number} ({entry.specimen or entry.procedure}) was interrupted",
        hint="; ".join(ways),
    )


def _read(path: Path) -> Stored:
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return Stored()
    except OSError as error:
        raise DataError(f"cannot read {path}: {error.strerror or error}") from error
    try:
        return Stored.model_validate_json(content)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise DataError(
            f"{path} is not a queue of this version: {where}: {first['msg']}",
            hint="correct the file, or move it away to start a new queue",
        ) from error


def _write(path: Path, stored: Stored) -> None:
    write_whole(path, f"{stored.model_dump_json(indent=1)}\n".encode())
