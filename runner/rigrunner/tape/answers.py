"""What persons answered while a procedure ran, on tape."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigrunner.api.devices import Wire
    from rigrunner.engine import AnswerSource
    from rigrunner.engine.answers import Ask, Confirm


class TapedAnswers:
    """An AnswerSource whose answers go over a wire."""

    def __init__(self, answers: AnswerSource, wire: Wire) -> None:
        self._answers = answers
        self._wire = wire

    @property
    def by(self) -> str:
        """Who answers, for the record."""
        return self._wire.exchange("who answers", lambda: self._answers.by)

    def confirm(self, step: str, question: Confirm) -> bool:
        """Return whether it is so."""
        return self._wire.exchange(f"confirm {step}", lambda: self._answers.confirm(step, question))

    def ask(self, step: str, question: Ask) -> str:
        """Return the answer."""
        return self._wire.exchange(f"ask {step}", lambda: self._answers.ask(step, question))
