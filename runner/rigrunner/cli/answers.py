"""Ask a person at the terminal."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError
from rigrunner.cli.output import message, prompt, yes_or_no
from rigrunner.procedure.answers import AnswerError

if TYPE_CHECKING:
    from rigrunner.cli.progress import ProgressSink
    from rigrunner.cli.stopping import SignalStop
    from rigrunner.engine.answers import Ask, Confirm


class TerminalAnswers:
    """Asks on stderr and reads the answer from stdin."""

    by = "operator"

    def __init__(self, stop: SignalStop, progress: ProgressSink) -> None:
        self._stop = stop
        self._progress = progress

    def confirm(self, step: str, question: Confirm) -> bool:  # noqa: ARG002  (the engine's signature)
        """Ask until the answer is yes or no; there is no default."""
        _show(question.picture)
        return yes_or_no(self._answer, question.text)

    def ask(self, step: str, question: Ask) -> str:  # noqa: ARG002  (the engine's signature)
        """Ask until the answer is accepted.

        The unattended answer is not accepted from a person.
        """
        _show(question.picture)
        allowed = f" [{question.expected.words}]" if question.expected.words else ""
        while True:
            answer = self._answer(f"{question.text}{allowed}: ")
            if not answer:
                message("Please give an answer.")
                continue
            try:
                return question.expected.accept(answer)
            except AnswerError as error:
                message(f"Please answer again: {error}.")

    def _answer(self, question: str) -> str:
        with self._progress.paused(), self._stop.while_asking():
            prompt(question)
            line = sys.stdin.readline()
        if not line:
            message("")
            raise AbortedError(
                "no answer: the input has ended",
                hint="--unattended uses the answers in the procedure",
            )
        return line.strip()


def _show(picture: str) -> None:
    if picture:
        message(f"See the picture {picture}")
