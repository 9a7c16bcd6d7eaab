"""Buffers what an instrument sends: the newest line, the recorded ones, and unreadable ones."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api import DeviceError, DeviceLostError, DeviceRejectedError, DeviceTimeoutError
from rigrunner_plugins.devices.text.numbers import excerpt
from rigrunner_plugins.devices.text.termination import decode, termination_name

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import Clock
    from rigrunner_plugins.devices.serial_ascii.settings import SerialAsciiSettings

_MOST_LINES = 100_000
"""How many are kept for a recording that does not fetch them."""
_LONGEST_LINE = 4096
"""Bytes that are kept of what has no end yet: far more than the line of any instrument."""


@dataclass(frozen=True)
class Line:
    """A line, and when its end came."""

    text: str
    at_s: float


class LineBuffer:
    """Bytes go in from one thread, lines come out to another one."""

    def __init__(self, settings: SerialAsciiSettings, clock: Clock) -> None:
        self._settings = settings
        self._clock = clock
        self._ending = settings.termination.encode()
        self._changed = threading.Condition()
        self._tail = b""
        self._begins_within_a_line = True
        self._last: Line | None = None
        self._newest: Line | None = None
        self._recorded: list[Line] | None = None
        self._is_answer: Callable[[str], bool] | None = None
        self._answer: str | None = None
        self._unsolicited = b""
        self._rubbish = 0
        self._problem: DeviceError | None = None

    def feed(self, data: bytes) -> None:
        """Take bytes as they come."""
        with self._changed:
            if self._is_answer is None:
                self._unsolicited = (self._unsolicited + data)[-_LONGEST_LINE:]
            *lines, tail = (self._tail + data).split(self._ending)
            self._tail = tail[-_LONGEST_LINE:]
            # The rest of a line that was begun before could pass for a whole one, with a smaller
            # number.
            if lines and self._begins_within_a_line:
                self._begins_within_a_line = False
                lines = lines[1:]
            for line in lines:
                self._add(Line(decode(line), self._clock.monotonic_s()))
            self._changed.notify_all()

    def fail(self, error: Exception) -> None:
        """Note that nothing more will come."""
        with self._changed:
            self._problem = DeviceLostError(
                f"{self._settings.port}: {error}", hint="is the cable still plugged in?"
            )
            self._changed.notify_all()

    def newest(self) -> str:
        """Return the newest line that is understood and not stale; raise a DeviceError."""
        stale_s = self._settings.stale
        with self._changed:
            self._wait(lambda: self._age_s(self._newest) <= stale_s, stale_s)
            assert self._newest is not None  # noqa: S101  (it has an age)
            return self._newest.text

    def answer(
        self, send: Callable[[], None], is_answer: Callable[[str], bool], within_s: float
    ) -> str:
        """Return the first line after sending that is an answer; raise a DeviceError."""
        with self._changed:
            self._is_answer, self._answer, self._tail = is_answer, None, b""
            self._begins_within_a_line = False  # nothing is sent before a request
        send()
        with self._changed:
            try:
                self._wait(lambda: self._answer is not None, within_s)
                assert self._answer is not None  # noqa: S101  (waited for)
                return self._answer
            finally:
                self._is_answer, self._unsolicited = None, b""

    def unsolicited(self) -> str:
        """Return what has come since the last answer."""
        with self._changed:
            unsolicited, self._unsolicited = self._unsolicited, b""
            return decode(unsolicited)

    def record(self) -> None:
        """Keep every line from now on."""
        with self._changed:
            self._rubbish, self._recorded = 0, []

    def recorded(self) -> list[Line]:
        """Return the lines that came since the last call, at least one; raise a DeviceError."""
        with self._changed:
            self._wait(lambda: bool(self._recorded), self._settings.stale)
            lines, self._recorded = self._recorded or [], []
            return lines

    def stop_recording(self) -> None:
        """Keep no more than the newest line."""
        with self._changed:
            self._recorded = None

    def _add(self, line: Line) -> None:
        self._last = line
        if self._is_answer is not None and self._answer is None:
            if self._is_answer(line.text):
                self._answer = line.text
            if not self._settings.request:
                return  # what came before the answer may have begun before we listened
        if self._settings.is_ignored(line.text):
            return
        try:
            self._settings.values_in(line.text)
        except DeviceRejectedError as error:
            self._take_rubbish(error)
        else:
            self._take_measurement(line)

    def _take_rubbish(self, error: DeviceRejectedError) -> None:
        self._rubbish += 1
        if self._recorded is not None:
            self._problem = error
        # With `request`, the caller reads the line, and fails by it.
        elif self._rubbish >= self._settings.rubbish and not self._settings.request:
            self._problem = DeviceRejectedError(
                f"{self._rubbish} lines in a row could not be read; the last: {error.message}",
                hint=error.hint,
            )

    def _take_measurement(self, line: Line) -> None:
        self._rubbish, self._newest = 0, line
        if self._recorded is None:
            self._problem = None
        elif len(self._recorded) < _MOST_LINES:
            self._recorded.append(line)
        else:
            self._problem = DeviceLostError(f"{_MOST_LINES} lines arrived that were not read")

    def _wait(self, ready: Callable[[], bool], within_s: float) -> None:
        done = self._changed.wait_for(lambda: self._problem is not None or ready(), within_s)
        if self._problem is not None:
            # Reported once: later lines may be good again.
            problem, self._problem, self._rubbish = self._problem, None, 0
            raise problem
        if not done:
            raise self._silence(within_s)

    def _age_s(self, line: Line | None) -> float:
        return float("inf") if line is None else self._clock.monotonic_s() - line.at_s

    def _silence(self, within_s: float) -> DeviceTimeoutError:
        port, ending_name = self._settings.port, termination_name(self._settings.termination)
        if self._last is not None:
            return DeviceTimeoutError(
                f"{port}: no valid line within {within_s:g} s; the last one,"
                f" {excerpt(self._last.text)}, came {self._age_s(self._last):.3g} s ago",
                hint="is the instrument still switched on, and set to send?",
            )
        if self._tail:
            return DeviceTimeoutError(
                f"{port}: characters come, {excerpt(decode(self._tail))}, but no {ending_name}",
                hint="is `termination` right? do baud rate, data bits and parity match?",
            )
        return DeviceTimeoutError(
            f"{port}: nothing came within {within_s:g} s",
            hint="is it the right port, is the instrument switched on and set to send, or does"
            " it need a `start` or a `request`?",
        )
