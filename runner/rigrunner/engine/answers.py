"""Where answers come from: a person, or the procedure itself when nobody is there."""

from __future__ import annotations

from typing import Protocol

from rigrunner.api.errors import UsageError


class AnswerSource(Protocol):
    """Answers what a procedure asks while it runs."""

    @property
    def by(self) -> str:
        """Who answers, for the record: 'operator', 'unattended answer of the procedure'."""
        ...

    def confirm(self, step: str, text: str, default: bool | None) -> bool:  # noqa: FBT001  (an answer is data, not a switch)
        """Return whether it is so; `default` is the procedure's unattended answer."""
        ...

    def ask(self, step: str, text: str, default: str | None) -> str:
        """Return the answer; `default` is the procedure's unattended answer."""
        ...


class UnattendedAnswers:
    """Gives the unattended answers of the procedure; raises UsageError where there is none."""

    by = "unattended answer of the procedure"

    def confirm(self, step: str, text: str, default: bool | None) -> bool:  # noqa: FBT001  (the Protocol's)
        """Return the unattended answer."""
        if default is None:
            raise _nobody(step, text)
        return default

    def ask(self, step: str, text: str, default: str | None) -> str:
        """Return the unattended answer."""
        if default is None:
            raise _nobody(step, text)
        return default


def _nobody(step: str, text: str) -> UsageError:
    return UsageError(
        f"{step}: nobody is there to answer '{text}'",
        hint="run attended, or give the step an 'unattended' answer",
    )
