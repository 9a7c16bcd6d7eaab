"""Report a rig that was left energised to the person at the terminal."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError
from rigrunner.cli.output import message, prompt, warning_label, yes_or_no
from rigrunner.rig_state import read_marker, read_markers

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.rig_state import Marker


class TerminalPerson:
    """Sees warnings on stderr and, if `attended`, is asked whether the rig may be made safe."""

    def __init__(self, *, attended: bool) -> None:
        self._attended = attended

    @property
    def by(self) -> str:
        """Who decided that the rig may be made safe."""
        return "operator" if self._attended else "nobody was asked"

    def warn(self, text: str) -> None:
        """Print it on stderr."""
        message(f"{warning_label()} {text}")

    def agrees(self, question: str) -> bool:
        """Ask until the answer is yes or no; unattended it is yes."""
        return not self._attended or yes_or_no(_answer, question)


def _answer(question: str) -> str:
    prompt(question)
    line = sys.stdin.readline()
    if not line:
        message("")
        raise AbortedError(
            "no answer: the input has ended, and the rig is as it was found",
            hint="--unattended makes it safe without asking",
        )
    return line.strip()


def show_left(station: str) -> None:
    """Report how the rig of a station was left, if it was left energised."""
    marker = read_marker(station)
    _show([marker] if marker is not None else [])


def show_all_left() -> None:
    """Report the rigs of this machine that were left energised."""
    _show(read_markers())


def _show(markers: Iterable[Marker]) -> None:
    for marker in markers:
        message(f"{warning_label()} {marker.text}")
        if not marker.is_in_use and not marker.safe_by:
            message("  'rigrunner devices STATION' makes it safe, and says what it read")
