"""The signals that end a program besides Ctrl-C, and words to a terminal that was closed."""

from __future__ import annotations

import os
import signal


def _known(*names: str) -> tuple[signal.Signals, ...]:
    """Return those signals that this system has."""
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


HANGUPS = _known("SIGHUP", "SIGBREAK")
"""The terminal was closed, or the connection to it is gone; SIGBREAK is what Windows has of it."""

ENDING = (*_known("SIGTERM"), *HANGUPS)


class Consoles:
    """The terminals that this program writes to."""

    def __init__(self) -> None:
        self._open = [one for one in (1, 2) if os.isatty(one)]

    def silence_closed(self) -> None:
        """Let nobody be told where the terminal was closed: each word to it would be an error."""
        for one in self._open:
            if not os.isatty(one):
                os.dup2(os.open(os.devnull, os.O_WRONLY), one)
