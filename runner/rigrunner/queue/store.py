"""The file of the queue: read, changed and written whole by one process at a time."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout
from pydantic import ValidationError

from rigrunner.api.errors import DataError, InvalidFileError, Problem, UsageError
from rigrunner.api.events import RunStarted
from rigrunner.clock import utc_text
from rigrunner.queue.entries import OPEN, Entry, Stored
from rigrunner.run.runs import listed_run
from rigrunner.runfile import NEVER_ENDED
from rigrunner.runfile.durable import write_whole, writing

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.events import Event, EventSink
    from rigrunner.queue.entries import Draft, State, Status

FILE = "queue.json"
MOST_ENTRIES = 5000
PATIENCE_S = 5.0
_MOVABLE = ("proposed", "waiting", "held")


@dataclass(frozen=True)
class Shown:
    """An entry with its status and, once its run is over, how that ended."""

    entry: Entry
    status: Status
    outcome: str = ""


class Queue:
    """The queue of a folder of runs. Any process may open it; each change is atomic and synced."""

    def __init__(self, runs: Path) -> None:
        self._runs = runs
        self._outcomes: dict[str, str] = {}
        """Of runs that are over, which do not change any more."""
        self.path = runs / FILE

    def changed_ns(self) -> int:
        """Return when the file was changed last, in ns; 0 where there is none."""
        try:
            return self.path.stat().st_mtime_ns
        except OSError:
            return 0

    def entries(self) -> tuple[Entry, ...]:
        """Return all entries in order; raise DataError for a file that cannot be read."""
        return self._read().entries

    def shown(self, station: str = "") -> list[Shown]:
        """Return the entries in order, each with its status; of one station only, if named."""
        return [
            self._shown(each) for each in self.entries() if not station or each.station == station
        ]

    def get(self, number: int) -> Entry:
        """Return one entry; raise UsageError."""
        return _found(self.entries(), number)

    def next(self, station: str = "") -> Entry | None:
        """Return the first entry that waits; None where none does.

        Raises UsageError while an interrupted entry needs an answer first.
        """
        shown = self.shown(station)
        for each in shown:
            if each.status == "interrupted":
                raise _unanswered(each.entry)
        return next((each.entry for each in shown if each.status == "waiting"), None)

    def add(
        self, drafts: Sequence[Draft], by: str, now: datetime, *, proposed: bool = False
    ) -> list[Entry]:
        """Add entries at the end, all or none; those proposed wait for their release.

        Raises InvalidFileError for a specimen that is in the queue for the same procedure already.
        """
        made: list[Entry] = []

        def change(stored: Stored) -> Stored:
            entries = list(stored.entries)
            if len(entries) + len(drafts) > MOST_ENTRIES:
                raise UsageError(
                    f"the queue has room for {MOST_ENTRIES} entries",
                    hint="clear those that are over first",
                )
            problems = []
            for draft in drafts:
                if (twin := self._twin(entries, draft)) is not None:
                    problems.append(_duplicate(twin))
                    continue
                entry = Entry(
                    **draft.model_dump(include=set(type(draft).model_fields)),
                    id=stored.next + len(made),
                    state="proposed" if proposed else "waiting",
                    by=by,
                    added_utc=utc_text(now),
                )
                made.append(entry)
                entries.append(entry)
            if problems:
                raise InvalidFileError(problems)
            return Stored(next=stored.next + len(made), entries=tuple(entries))

        self._change(change)
        return made

    def move(self, number: int, before: int | None) -> None:
        """Put an entry that has not started in front of another one, or last."""

        def change(stored: Stored) -> Stored:
            entry = self._in(stored, number, *_MOVABLE)
            rest = [each for each in stored.entries if each.id != number]
            if before is not None and before != number:
                at = rest.index(_found(stored.entries, before))
            else:
                at = len(rest) if before is None else stored.entries.index(entry)
            return stored.model_copy(update={"entries": (*rest[:at], entry, *rest[at:])})

        self._change(change)

    def hold(self, number: int, by: str, reason: str = "") -> None:
        """Keep an entry back until it is released."""
        self._set(number, "held", by, reason, "waiting", "proposed")

    def release(self, number: int, by: str) -> None:
        """Let an entry that was proposed or held wait for its turn."""
        self._set(number, "waiting", by, "", "proposed", "held")

    def skip(self, number: int, by: str, reason: str) -> None:
        """Do not run an entry, or close one whose run was interrupted."""
        entry = self.get(number)
        state: State = "closed" if entry.state == "started" else "skipped"
        self._set(number, state, by, reason, *_MOVABLE, "interrupted")

    def repeat(self, number: int, by: str, reason: str, now: datetime) -> Entry:
        """Return a new entry for the same test, which waits right behind the one it repeats."""
        made: list[Entry] = []

        def change(stored: Stored) -> Stored:
            old = self._in(stored, number, "done", "interrupted", "skipped", "closed")
            again = [each for each in stored.entries if each.repeats == number]
            if any(self._shown(each).status in OPEN for each in again):
                raise UsageError(f"entry {number} is repeated already: entry {again[-1].id}")
            new = old.model_copy(
                update={
                    "id": stored.next, "state": "waiting", "by": by, "added_utc": utc_text(now),
                    "reason": reason, "repeats": number, "repeated_by": by, "run": "",
                }
            )  # fmt: skip
            made.append(new)
            if self._shown(old).status == "interrupted":
                old = old.model_copy(update={"state": "closed", "by": by, "reason": reason})
            at = [each.id for each in stored.entries].index(number)
            entries = (*stored.entries[:at], old, new, *stored.entries[at + 1 :])
            return Stored(next=stored.next + 1, entries=entries)

        self._change(change)
        return made[0]

    def clear(self, station: str = "") -> int:
        """Remove the entries that are over, and return how many; their runs stay."""
        removed = 0

        def change(stored: Stored) -> Stored:
            nonlocal removed
            left = tuple(
                each
                for each in stored.entries
                if self._shown(each).status in OPEN or (station and each.station != station)
            )
            removed = len(stored.entries) - len(left)
            return stored.model_copy(update={"entries": left})

        self._change(change)
        return removed

    @contextmanager
    def started(self, number: int, by: str) -> Iterator[Entry]:
        """Mark a waiting entry as started, and hold it while its run lasts.

        The mark is on the disk before this returns: an entry that was marked and has no finished
        run afterwards is 'interrupted', and never runs again unless a person says so. Raises
        UsageError for an entry that does not wait.
        """
        lock = self._entry_lock(number)
        try:
            lock.acquire(timeout=0)
        except Timeout as error:
            raise UsageError(f"entry {number} is running already") from error
        try:
            self._set(number, "started", by, self.get(number).reason, "waiting")
            yield self.get(number)
        finally:
            with suppress(OSError):  # on Windows a file that is open cannot be removed
                self._lock_file(number).unlink()
            lock.release()

    def began(self, number: int) -> EventSink:
        """Return a listener that enters the run's id as soon as the run has begun."""

        def note(event: Event) -> None:
            if isinstance(event, RunStarted):
                self._replace(number, run=event.run_id)

        return note

    def give_back(self, number: int, reason: str) -> None:
        """Hold an entry whose run could not begin: nothing has moved, and it says why."""
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
            if run.is_going_on:
                return Shown(entry, "running")
            if run.info is not None and run.info.reason != NEVER_ENDED:
                self._outcomes[entry.run] = run.info.outcome
                return Shown(entry, "done", run.info.outcome)
        return Shown(entry, "interrupted")

    def _twin(self, entries: Sequence[Entry], draft: Draft) -> Shown | None:
        for each in entries:
            if each.state not in ("skipped", "closed") and each.is_same_test(draft):
                return self._shown(each)
        return None

    def _set(self, number: int, state: State, by: str, reason: str, *allowed: str) -> None:
        def change(stored: Stored) -> Stored:
            entry = self._in(stored, number, *allowed)
            new = entry.model_copy(update={"state": state, "by": by, "reason": reason})
            return _with(stored, new)

        self._change(change)

    def _replace(self, number: int, **fields: str) -> None:
        self._change(
            lambda stored: _with(
                stored, _found(stored.entries, number).model_copy(update=dict(fields))
            )
        )

    def _in(self, stored: Stored, number: int, *allowed: str) -> Entry:
        entry = _found(stored.entries, number)
        status = self._shown(entry).status
        if status not in allowed:
            expected = " or ".join(allowed)
            raise UsageError(f"entry {number} is {status}, expected {expected}")
        return entry

    def _read(self) -> Stored:
        try:
            content = self.path.read_bytes()
        except FileNotFoundError:
            return Stored()
        except OSError as error:
            raise DataError(f"cannot read {self.path}: {error.strerror or error}") from error
        try:
            return Stored.model_validate_json(content)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = ".".join(map(str, first["loc"]))
            raise DataError(
                f"{self.path} is not a queue of this version: {where}: {first['msg']}",
                hint="correct the file, or move it away to begin a new queue",
            ) from error

    def _change(self, change: Callable[[Stored], Stored]) -> None:
        with writing(self.path):
            self._runs.mkdir(parents=True, exist_ok=True)
        lock = FileLock(self._runs / ".queue.lock", timeout=PATIENCE_S)
        try:
            lock.acquire()
        except Timeout as error:
            message = f"another process has {self.path} open for longer than {PATIENCE_S:g} s"
            raise DataError(message, hint="try again") from error
        try:
            stored = change(self._read())
            write_whole(self.path, f"{stored.model_dump_json(indent=1)}\n".encode())
        finally:
            lock.release()

    def _lock_file(self, number: int) -> Path:
        return self._runs / f".queue-{number}.lock"

    def _entry_lock(self, number: int) -> FileLock:
        return FileLock(self._lock_file(number), thread_local=False)

    def _is_held(self, number: int) -> bool:
        if not self._lock_file(number).exists():
            return False
        try:
            with self._entry_lock(number).acquire(timeout=0):
                return False
        except Timeout:
            return True
        except OSError:
            return False


def _found(entries: Sequence[Entry], number: int) -> Entry:
    for each in entries:
        if each.id == number:
            return each
    raise UsageError(f"the queue has no entry {number}")


def _with(stored: Stored, new: Entry) -> Stored:
    entries = tuple(new if each.id == new.id else each for each in stored.entries)
    return stored.model_copy(update={"entries": entries})


def _duplicate(twin: Shown) -> Problem:
    entry = twin.entry
    return Problem(
        f"{entry.specimen} is in the queue already: entry {entry.id}, {twin.status}",
        hint="repeat that entry, with a reason, to test it again",
    )


def _unanswered(entry: Entry) -> UsageError:
    return UsageError(
        f"the run of entry {entry.id} ({entry.specimen or entry.procedure}) was interrupted",
        hint="repeat that entry or close it first, with a reason",
    )
