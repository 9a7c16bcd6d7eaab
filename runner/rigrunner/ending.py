"""The signals that end or suspend a program besides Ctrl-C, and a terminal that was closed."""

from __future__ import annotations

import os
import signal
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from types import FrameType

    Handler = Callable[[int, FrameType | None], None]


def _available(*names: str) -> tuple[int, ...]:
    """Return those signals that this system has."""
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


HANGUPS = _available("SIGHUP", "SIGBREAK")
"""The terminal was closed, or the connection to it was lost; on Windows, SIGBREAK."""

_PLAIN = (*_available("SIGTERM"), *HANGUPS)
_TIMERS_AND_USERS = _available(
    "SIGQUIT", "SIGUSR1", "SIGUSR2", "SIGALRM", "SIGVTALRM", "SIGPROF", "SIGXCPU"
)
_OF_LINUX: tuple[int, ...] = ()
if sys.platform == "linux":  # elsewhere these are ignored by default
    _OF_LINUX = (
        *_available("SIGIO", "SIGPWR", "SIGSTKFLT"),
        *range(signal.SIGRTMIN, signal.SIGRTMAX + 1),
    )

ENDING: tuple[int, ...] = (*_PLAIN, *_TIMERS_AND_USERS, *_OF_LINUX)
"""Every signal that ends a program unless it is handled, and that can be handled in Python.

Those of a crash (SIGSEGV, SIGABRT, ...) are not among them: no Python code can run after one.
SIGPIPE and SIGXFSZ are ignored by Python: the write fails instead.
"""

SUSPENDING: tuple[int, ...] = _available("SIGTSTP", "SIGTTIN", "SIGTTOU")
"""Ctrl-Z, and a program in the background that reads from its terminal or writes to it."""


def signal_name(number: int) -> str:
    """Return the name of a signal, such as 'SIGTERM'; 'SIGRTMIN+2' for one that has none."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"SIGRTMIN+{number - signal.SIGRTMIN}"


def take_signals(numbers: Iterable[int], handler: Handler) -> dict[int, Any]:
    """Let the handler have these signals; return the former handler of each that it now has.

    A signal that is ignored stays so, as SIGHUP under nohup. Except for SIGTERM and a closed
    terminal, a signal with another handler, such as that of a profiler, keeps it.
    """
    former = {}
    for number in numbers:
        present = signal.getsignal(number)
        if present == signal.SIG_DFL or (number in _PLAIN and callable(present)):
            former[number] = signal.signal(number, handler)
    return former


class Consoles:
    """The terminals that this program writes to."""

    def __init__(self) -> None:
        self._open = [fd for fd in (1, 2) if os.isatty(fd)]

    def silence_closed(self) -> None:
        """Write nothing to a terminal that was closed: each write would be an error."""
        for fd in self._open:
            if not os.isatty(fd):
                os.dup2(os.open(os.devnull, os.O_WRONLY), fd)
