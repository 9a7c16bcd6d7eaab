"""Ask the person at the terminal how to continue a paused run."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError
from rigrunner.api.texts import name_of, refused_character
from rigrunner.cli.keyboard import wait_for_line
from rigrunner.cli.output import message, prompt
from rigrunner.engine.pausing import Choice, Decision

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.cli.progress import ProgressSink
    from rigrunner.cli.stopping import SignalStop
    from rigrunner.engine.pausing import Paused

_LOOK_EVERY_S = 0.5
_HELP = {
    Choice.RESUME: "continue; settling and the interrupted step are repeated",
    Choice.OVERRIDE: "continue despite the interlock, with a reason",
    Choice.REPEAT: "repeat {point} from its start; what was recorded is kept",
    Choice.SKIP: "skip the rest of {point}, with a reason",
    Choice.NOTE: "record a remark",
    Choice.ABORT: "end the run: teardown, and the rig is made safe",
}
_WITH_REASON = (Choice.OVERRIDE, Choice.SKIP, Choice.NOTE)


class TerminalPauses:
    """Asks on stderr what to do, and reads the answer from stdin."""

    def __init__(self, stop: SignalStop, progress: ProgressSink, by: str) -> None:
        self._stop = stop
        self._progress = progress
        self._by = by

    def requested_by(self) -> str:
        """Return 'keyboard' after Ctrl-C."""
        return self._stop.pause_requested()

    def decide(self, paused: Paused, watch: Callable[[], None]) -> Decision:
        """Ask until the answer is one of the choices, with its reason if one is needed."""
        self._stop.paused()
        with self._progress.paused():
            message(f"Paused at {paused.step}: {paused.reason}.")
            for text in paused.moving:
                message(f"  {text}")
            for name in paused.choices:
                message(f"  {name:9} {_HELP[name].format(point=paused.point)}")
            choice = self._choice(paused, watch)
            reason = self._reason(choice, watch) if choice in _WITH_REASON else ""
            if choice is not Choice.NOTE:
                self._stop.resumed()  # before progress is shown again: then Ctrl-C pauses
        return Decision(choice, self._by, reason)

    def _choice(self, paused: Paused, watch: Callable[[], None]) -> Choice:
        names = "/".join(paused.choices)
        while True:
            answer = self._answer(f"What now? [{names}] ", watch).lower()
            matches = [choice for choice in paused.choices if answer and choice.startswith(answer)]
            if len(matches) == 1:
                return matches[0]
            message(f"Please answer with one of: {', '.join(paused.choices)}.")

    def _reason(self, choice: Choice, watch: Callable[[], None]) -> str:
        question = "Your note: " if choice is Choice.NOTE else "Why? "
        while True:
            reason = self._answer(question, watch)
            refused = refused_character(reason)
            if refused:
                message(f"Please type it again, without the character {name_of(refused[0])}.")
            elif reason:
                return reason
            else:
                message("Please enter a text: it is recorded.")

    def _answer(self, question: str, watch: Callable[[], None]) -> str:
        prompt(question)
        with self._stop.while_asking():
            while not wait_for_line(_LOOK_EVERY_S):
                watch()
            line = sys.stdin.readline()
        if not line:
            raise AbortedError("paused, and no answer: the input has ended")
        return line.strip()
