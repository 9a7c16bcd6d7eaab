"""Where answers come from: a person, or the procedure itself when nobody is there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from rigrunner.plan.actions import Ask, Confirm


class AnswerSource(Protocol):
    """Answers what a procedure asks while it runs."""

    @property
    def by(self) -> str:
        """Who answers, for the record: 'operator', 'unattended answer of the procedure'."""
        ...

    def confirm(self, step: str, question: Confirm) -> bool:
        """Return whether it is so; `step` names the place of the question in the procedure."""
        ...

    def ask(self, step: str, question: Ask) -> str:
        """Return the answer, one that `question.expected` accepts."""
        ...


class UnattendedAnswers:
    """Gives the unattended answers of the procedure; raises UsageError where there is none."""

    by = "unattended answer of the procedure"

    def confirm(self, step: str, question: Confirm) -> bool:
        """Return the unattended answer."""
        if question.unattended is None:
            raise _nobody(step, question.text)
        return question.unattended

    def ask(self, step: str, question: Ask) -> str:
        """Return the unattended answer."""
        if question.unattended is None:
            raise _nobody(step, question.text)
        return question.unattended


def _nobody(step: str, text: str) -> UsageError:
    return UsageError(
        f"{step}: nobody is there to answer '{text}'",
        hint="run attended, or give the step an 'unattended' answer",
    )
