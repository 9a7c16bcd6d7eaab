"""How a signal stops a run: through the stop token, so that the rig is made safe first."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)
)


class SignalStop:
    """A stop token that SIGTERM and SIGHUP set."""

    def __init__(self) -> None:
        self._event = threading.Event()
        self._asking = False

    def is_set(self) -> bool:
        """Return True once a signal has come."""
        return self._event.is_set()

    @contextmanager
    def while_asking(self) -> Iterator[None]:
        """Let a signal break off the wait for a person's answer, which looks at no token."""
        self._asking = True
        try:
            yield
        finally:
            self._asking = False

    def handle(self, number: int, _frame: FrameType | None) -> None:
        """Take a signal: set the token; while a person is asked, raise AbortedError."""
        self._event.set()
        if self._asking:
            raise AbortedError(f"stopped by {signal.Signals(number).name}")


@contextmanager
def stop_on_signals() -> Iterator[SignalStop]:
    """Give a stop token that signals set, and put the former handlers back afterwards."""
    stop = SignalStop()
    former = {number: signal.signal(number, stop.handle) for number in _SIGNALS}
    try:
        yield stop
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)
