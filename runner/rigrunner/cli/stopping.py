"""Stop or pause a run by signals and Ctrl-C, by tokens, so that the rig is made safe first."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError, ExitCode
from rigrunner.api.events import Event, RunEnded, RunStarted
from rigrunner.ending import ENDING, SUSPENDING, Consoles, signal_name, take_signals
from rigrunner.engine.pausing import PauseRequestedError, StopNow
from rigrunner.run.log import with_units

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager
    from types import FrameType

KEYBOARD = "keyboard"
_ABORT, _STOP_NOW = 2, 3
"""The numbers of Ctrl-C with these meanings; the first one pauses, if somebody can continue the
run."""


class InterruptedRunError(AbortedError):
    """Ctrl-C ended the run."""

    exit_code = ExitCode.INTERRUPTED


class SignalStop:
    """A stop token that signals and Ctrl-C set; Ctrl-C may ask for a pause first.

    It listens to the run's events: before a run Ctrl-C ends the program as usual, and after it only
    the third one does, since the run has to be sealed. Ctrl-Z ends the run too; the program is
    suspended once the rig is safe and closed.
    """

    def __init__(self, *, attended: bool = False) -> None:
        self._event = threading.Event()
        self._reason: AbortedError | None = None
        self._attended = attended
        self._running = self._asking = self._is_quiet = self._is_over = False
        self._presses = 0
        self._consoles = Consoles()
        self.suspended_by = ""
        """The signal that suspends the program at the end; empty for none."""
        self.ended = ""
        """How the run ended, as text."""

    def __call__(self, event: Event) -> None:
        """Note whether a run is in progress."""
        if isinstance(event, RunStarted):
            self._running, self._is_quiet, self._is_over = True, False, False
        elif isinstance(event, RunEnded):
            self._running, self._is_over, self._presses = False, True, 0
            read_back = with_units(event.read_back, event.units)
            drives = f" Drives read back: {read_back}." if read_back else ""
            reason = f": {event.reason}" if event.reason else ""
            self.ended = f"The run ended as {event.outcome}{reason}.{drives} "

    def is_set(self) -> bool:
        """Return whether the run is to stop."""
        return self._event.is_set()

    def reason(self) -> AbortedError:
        """Return the reason of the stop."""
        return self._reason or AbortedError("stopped on request")

    def pause_requested(self) -> str:
        """Return who asks for a pause; an empty text for no one."""
        return KEYBOARD if self._presses else ""

    def paused(self) -> None:
        """Note that the run is paused: the next Ctrl-C aborts it."""
        self._presses = 1

    def resumed(self) -> None:
        """Note that the run continues: the next Ctrl-C pauses it."""
        self._presses = 0

    def stop_interrupting(self) -> None:
        """Note that the rig is being made safe: Ctrl-C does not interrupt that."""
        self._is_quiet = True

    @contextmanager
    def while_asking(self) -> Iterator[None]:
        """Let a signal interrupt the wait for a person's answer, which checks no token."""
        self._asking = True
        try:
            yield
        finally:
            self._asking = False

    def handle(self, number: int, _frame: FrameType | None) -> None:
        """Handle a signal: set the token; while a person is asked, raise AbortedError."""
        self._consoles.silence_closed()
        self._stop(AbortedError(f"stopped by {signal_name(number)}", by="signal"))

    def suspend(self, number: int, _frame: FrameType | None) -> None:
        """Handle Ctrl-Z: end the run like SIGTERM; `stop_on_signals` then suspends the program.

        A suspended program monitors no interlock, so the rig must be safe before.
        """
        name = signal_name(number)
        if self.suspended_by:
            _say("The rig is being made safe, then the program is suspended; please wait.")
        else:
            _say(f"{name}: the run is aborted and the rig made safe before this is suspended.")
        self.suspended_by = name
        self._stop(AbortedError(f"aborted by {name}, before it was suspended", by="signal"))

    def interrupt(self, _number: int, _frame: FrameType | None) -> None:
        """Handle a Ctrl-C: pause, then abort, then stop at once. Then the rig is made safe."""
        if self._is_over:
            self._interrupt_end()
            return
        if not self._running:
            raise KeyboardInterrupt
        self._presses += 1
        presses = self._presses if self._attended else self._presses + 1
        if presses > _STOP_NOW or self._is_quiet:
            _say("The rig is being made safe; please wait.")
        elif presses == _STOP_NOW:
            _say("Stopping now: no teardown, the rig is made safe.")
            raise StopNow
        elif presses == _ABORT:
            _say("Aborting: teardown, then the rig is made safe. Ctrl-C stops at once.")
            self._stop(InterruptedRunError("interrupted from the keyboard", by=KEYBOARD))
        else:
            _say("Pausing at the next safe point. Ctrl-C aborts the run.")
            if self._asking:
                raise PauseRequestedError("pause requested", KEYBOARD)

    def _interrupt_end(self) -> None:
        """Handle a Ctrl-C after the run: its analysis ends, and it is still sealed."""
        self._presses += 1
        if self._presses >= _STOP_NOW:
            raise KeyboardInterrupt
        if self._presses == _ABORT:
            _say("Ctrl-C once more ends this now; 'rigrunner recover' seals the run.")
        else:
            _say("The run is over; its folder is being sealed. Please wait.")
        self._stop(InterruptedRunError("interrupted from the keyboard", by=KEYBOARD))

    def _stop(self, reason: AbortedError) -> None:
        self._reason = self._reason or reason
        self._event.set()
        if self._asking:
            raise self.reason()


class BatchStop(SignalStop):
    """The token of a batch: the first Ctrl-C sets it too, the next one ends the program."""

    def interrupt(self, _number: int, _frame: FrameType | None) -> None:
        """Handle a Ctrl-C."""
        if self.is_set():
            raise KeyboardInterrupt
        _say("Stopping; what is done is kept. Ctrl-C ends at once.")
        self._stop(InterruptedRunError("interrupted from the keyboard", by=KEYBOARD))


def stop_on_signals(*, attended: bool = False) -> AbstractContextManager[SignalStop]:
    """Return a context with the stop token of a run that signals set; it restores the handlers.

    `attended`: somebody can decide how a paused run continues.
    """
    return _with_handlers(SignalStop(attended=attended))


@contextmanager
def batch_stop_on_signals() -> Iterator[SignalStop]:
    """Yield the stop token of a batch.

    If the batch ends with an AbortedError, it becomes that of the signal, with its code.
    """
    with _with_handlers(BatchStop()) as stop:
        try:
            yield stop
        except AbortedError as error:
            reason = stop.reason()
            raise type(reason)(f"{reason.message}: {error.message}", hint=error.hint) from error


@dataclass(frozen=True)
class Until:
    """A stop token that is set with another one, or at an instant of the monotonic clock."""

    stop: SignalStop
    end_s: float

    def is_set(self) -> bool:
        """Return whether it is set."""
        return self.stop.is_set() or time.monotonic() >= self.end_s

    def reason(self) -> AbortedError:
        """Return the reason of the stop."""
        return self.stop.reason()


def until(stop: SignalStop, seconds: float | None) -> Until:
    """Return a stop token that is set with that one, or this many seconds from now."""
    return Until(stop, math.inf if seconds is None else time.monotonic() + seconds)


@contextmanager
def _with_handlers(stop: SignalStop) -> Iterator[SignalStop]:
    previous = take_signals(ENDING, stop.handle)
    if not isinstance(stop, BatchStop):  # which has no rig: it may be suspended at once
        previous |= take_signals(SUSPENDING, stop.suspend)
    previous[signal.SIGINT] = signal.signal(signal.SIGINT, stop.interrupt)
    try:
        yield stop
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
        if stop.suspended_by:
            # Without a shell that could continue it, the system ignores this: the program ends.
            _say(
                f"{stop.ended}Suspended: the rig is closed. 'fg' continues the program to its end."
            )
            os.kill(os.getpid(), signal.SIGTSTP)
            ended = stop.ended or "The rig was closed before the program was suspended. "
            _say(f"Continued. {ended}")


def _say(text: str) -> None:
    """Write to stderr past its buffer, which a signal may interrupt in use; errors are ignored."""
    with suppress(OSError):
        os.write(2, f"\n{text}\n".encode())
