"""Sources of answers: a person, or the procedure itself when unattended."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from rigrunner.procedure.answers import Expected


class Confirm(Protocol):
    """A statement to confirm."""

    @property
    def text(self) -> str:
        """The question."""
        ...

    @property
    def picture(self) -> str:
        """The path of a picture to show; empty for none."""
        ...

    @property
    def unattended(self) -> bool | None:
        """The unattended answer; None for none."""
        ...


class Ask(Protocol):
    """A question."""

    @property
    def text(self) -> str:
        """The question."""
        ...

    @property
    def picture(self) -> str:
        """The path of a picture to show; empty for none."""
        ...

    @property
    def unattended(self) -> str | None:
        """The unattended answer; None for none."""
        ...

    @property
    def expected(self) -> Expected:
        """The accepted answers."""
        ...


class AnswerSource(Protocol):
    """Answers the questions of a procedure while it runs."""

    @property
    def by(self) -> str:
        """Who answers, for the record: 'operator', 'unattended answer of the procedure'."""
        ...

    def confirm(self, step: str, question: Confirm) -> bool:
        """Return the answer yes or no; `step` is the place of the question in the procedure."""
        ...

    def ask(self, step: str, question: Ask) -> str:
        """Return an answer that `question.expected` accepts."""
        ...


class UnattendedAnswers:
    """Gives the unattended answers of the procedure; raises UsageError if there is none."""

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
        f"{step}: there is nobody to answer '{text}'",
        hint="run attended, or give the step an 'unattended' answer",
    )
