"""Records each exchange; a failure of the tape must not cost a measurement."""

from __future__ import annotations

import os
import threading
import time
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api.errors import DeviceTimeoutError
from rigrunner.tape.file import entry_line

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

_T = TypeVar("_T")


class Trouble:
    """Why a tape cannot be written; from the first problem on nothing more is written.

    All files of a tape then end at the same event, without gaps.
    """

    def __init__(self) -> None:
        self.text = ""

    def note(self, text: str) -> None:
        """Keep the first."""
        self.text = self.text or text


class RecordingWire:
    """A Wire that records exchanges to a file; raises only exceptions of the exchange."""

    def __init__(self, path: Path, trouble: Trouble) -> None:
        self._path = path
        self._trouble = trouble
        self._lock = threading.Lock()
        self._descriptor: int | None = None
        self._thread = threading.local()
        self._next = 0
        self._pending: dict[int, tuple[str, float]] = {}

    def exchange(self, request: str, perform: Callable[[], _T]) -> _T:
        """Return the result of `perform` and record it.

        Exchanges inside `perform` are not recorded, since a replay does not call it.
        """
        if getattr(self._thread, "performs", False):
            return perform()
        self._thread.performs = True
        try:
            return self._exchange(request, perform)
        finally:
            self._thread.performs = False

    def _exchange(self, request: str, perform: Callable[[], _T]) -> _T:
        # Numbered at the request: a replay has the same order of requests, not of answers.
        with self._lock:
            seq, self._next = self._next, self._next + 1
            self._pending[seq] = (request, time.monotonic())
        try:
            answer = perform()
        except BaseException as error:
            self._save(seq, error)
            raise
        self._save(seq, answer)
        return answer

    def close(self) -> None:
        """Record pending exchanges as unanswered, and close the file; idempotent."""
        for seq, (request, _) in sorted(self._pending.items()):
            self._save(seq, DeviceTimeoutError(f"{request}: it was never answered"))
        with self._lock:
            if self._descriptor is not None:
                os.close(self._descriptor)
            self._descriptor = None
            # A separate one: a closed wire is no trouble of the tape.
            self._trouble = Trouble()
            self._trouble.note("closed")

    def _save(self, seq: int, answer: Any) -> None:
        with self._lock:
            request, began_s = self._pending.pop(seq, ("", 0.0))
            if self._trouble.text or not request:
                return
            try:
                self._append(entry_line(seq, request, answer, time.monotonic() - began_s))
            except OSError as error:
                self._trouble.note(f"{self._path} cannot be written: {error.strerror or error}")
            except (TypeError, ValueError) as error:
                self._trouble.note(f"{self._path}: the answer to '{request}': {error}")

    def _append(self, line: bytes) -> None:
        if self._descriptor is None:
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | getattr(os, "O_BINARY", 0)
            self._descriptor = os.open(self._path, flags, 0o666)
        written = os.write(self._descriptor, line)
        if written < len(line):  # the disk is full: the next call would say so
            os.write(self._descriptor, line[written:])
