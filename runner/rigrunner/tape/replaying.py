"""Replays exchanges from tape in strict order, up to the first difference."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, TypeVar, cast

from rigrunner.rig import NoRigError

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api.errors import Location
    from rigrunner.tape.file import Entry, TapeFile

_T = TypeVar("_T")
_SHOWN_REQUESTS = 3


class Replay:
    """State shared by all tapes of a replay: whether it still agrees with them."""

    def __init__(self) -> None:
        self.hint = ""
        """What can explain a difference."""
        self.difference = ""
        """The first one, as text."""
        self.over = threading.Event()
        """Set once no one waits for answers any more."""
        self._place = ""
        self._reported = False

    def differ(self, place: object, text: str) -> None:
        """Note a difference; only the first one counts."""
        if not self.difference:
            self._place, self.difference = str(place), text

    def error(self) -> NoRigError:
        """Return the error for the difference: the first time with details."""
        if self._reported:
            return NoRigError(f"the replay ended at {self._place}")
        self._reported = True
        return NoRigError(self.difference, hint=self.hint)


class ReplayWire:
    """A Wire that answers from a tape, without exchanges.

    An exchange that exceeded `patience_s` takes as long again, so that the time-out recurs.
    """

    def __init__(self, tape: TapeFile, replay: Replay, patience_s: float) -> None:
        self._tape = tape
        self._replay = replay
        self._patience_s = patience_s
        self._lock = threading.Lock()
        self._next = 0
        self._before: list[str] = []

    def exchange(self, request: str, perform: Callable[[], _T]) -> _T:  # noqa: ARG002  (the Protocol's)
        """Return the recorded answer; raise NoRigError from the first difference on."""
        entry = self._next_entry(request)
        if entry is None:
            raise self._replay.error()
        if entry.took_s > self._patience_s:
            self._replay.over.wait(entry.took_s)
        return cast("_T", entry.outcome())

    def reading(self, request: str) -> object:
        """Return the answer for a caller that cannot handle a difference; then None."""
        entry = self._next_entry(request)
        return None if entry is None else entry.answer

    def _next_entry(self, request: str) -> Entry | None:
        """Return the next exchange; None from the first difference on."""
        with self._lock:
            if self._replay.difference:
                return None
            entry = self._tape.entry(self._next)
            if entry is None or entry.request != request:
                line = self._tape.line_of(self._next) if entry is None else entry.line
                place = self._tape.place(line)
                self._replay.differ(place, self._words(place, request, entry))
                return None
            self._next += 1
            self._before = [*self._before[1 - _SHOWN_REQUESTS :], request]
            return entry

    def is_next(self, request: str) -> bool:
        """Return whether this is the next exchange on the tape."""
        with self._lock:
            entry = None if self._replay.difference else self._tape.entry(self._next)
            return entry is not None and entry.request == request

    def unrequested(self) -> str:
        """Return what was not requested from the tape, as text; '' for nothing."""
        remaining = len(self._tape) - self._next
        if remaining <= 0:
            return ""
        line = self._tape.line_of(self._next)
        subject = f"{remaining} exchanges are" if remaining > 1 else "one exchange is"
        return f"{self._tape.place(line)}: {subject} left on the tape that were not asked for"

    def _words(self, place: Location, request: str, entry: Entry | None) -> str:
        before = ", ".join(f"'{earlier}'" for earlier in self._before)
        position = f"after {before}" if before else "the very first"
        if entry is None:
            return f"the tape is over at {place}, the replay asked for '{request}', {position}"
        return (
            f"the replay differs from the tape: {place} has '{entry.request}',"
            f" the replay asked for '{request}', {position}"
        )
