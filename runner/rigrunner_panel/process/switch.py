"""Aborts or stops a run from the panel, at any time."""

from __future__ import annotations

import _thread
import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError
from rigrunner.api.events import Event, RunEnded
from rigrunner.ending import ENDING, SUSPENDING, signal_name, take_signals
from rigrunner.engine import StopNow

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType


class Switch:
    """A stop token for the run in the main thread, set by the thread that receives commands.

    Abort sets the token: the run ends at the next block, with its teardown. Stop also interrupts
    the main thread, as Ctrl-C does in a terminal, so it does not wait for a device or an answer. It
    interrupts only within `interruptible`, and not after the end of the run, when the rig is safe.
    """

    def __init__(self) -> None:
        self._event = threading.Event()
        self._reason: AbortedError | None = None
        self._stop: StopNow | None = None
        self._armed = self._is_safe = self._may_interrupt = False
        self._lock = threading.Lock()

    def install(self) -> None:
        """Let only this switch interrupt the process; call in the main thread.

        A signal that would suspend the process ends the run, because it could not be continued.
        """
        signal.signal(signal.SIGINT, self._on_interrupt)
        take_signals((*ENDING, *SUSPENDING), self._on_termination)

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Let Stop raise StopNow in this block of the main thread; an earlier one raises now."""
        self._may_interrupt = True
        try:
            with self._lock:
                stop, self._armed = self._stop, False
            if stop is not None:
                raise stop
            yield
        finally:
            self._may_interrupt = False

    def __call__(self, event: Event) -> None:
        """Receive the end of the run; an event sink."""
        if isinstance(event, RunEnded):
            self.stop_interrupting()

    def stop_interrupting(self) -> None:
        """Disable interrupts: the rig is being made safe."""
        with self._lock:
            self._is_safe, self._armed = True, False

    def is_set(self) -> bool:
        """Return True once the run is to end."""
        return self._event.is_set()

    def reason(self) -> AbortedError:
        """Return why the run ends."""
        return self._reason or AbortedError("stopped on request")

    def abort(self, by: str, reason: str) -> None:
        """Abort the run."""
        text = f"aborted at the panel{f': {reason}' if reason else ''}"
        self._reason = self._reason or AbortedError(text, by=by)
        self._event.set()

    def stop(self, by: str, reason: str) -> None:
        """Make the rig safe at once; a second call changes nothing."""
        text = f"stopped at the panel{f': {reason}' if reason else ''}"
        with self._lock:
            if self._stop is not None:
                return
            self._stop = StopNow(text, by)
            self._reason = self._reason or AbortedError(text, by=by)
            self._event.set()
            if self._is_safe:
                return
            self._armed = True
        _interrupt_main_thread()

    def _on_interrupt(self, _number: int, _frame: FrameType | None) -> None:
        """Handle the signal; ignore one that the panel did not send, such as that of a terminal."""
        if not self._may_interrupt:
            return
        armed, self._armed = self._armed, False
        if armed and self._stop is not None:
            raise self._stop

    def _on_termination(self, number: int, _frame: FrameType | None) -> None:
        self.abort("signal", signal_name(number))


def _interrupt_main_thread() -> None:
    """Interrupt system calls of the main thread too, where the system can."""
    if hasattr(signal, "pthread_kill"):
        main = threading.main_thread().ident
        assert main is not None  # noqa: S101  (it runs)
        signal.pthread_kill(main, signal.SIGINT)
    else:
        _thread.interrupt_main()
