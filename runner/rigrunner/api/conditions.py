"""Conditions of steps, as a procedure states them: a value or an answer, and nothing to compute."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from rigrunner.api.member import Member
from rigrunner.api.settings import AnyQuantity, ListOf, Settings
from rigrunner.api.texts import plain


def _as_list(value: Any) -> Any:
    if isinstance(value, bool | int | float):
        raise ValueError(f"got {value}, expected a text: an answer is one; put it in quotes")  # noqa: TRY004  (pydantic places it)
    return [value] if isinstance(value, str) else value


Answers = Annotated[
    ListOf[Annotated[str, Field(min_length=1), AfterValidator(plain)]], BeforeValidator(_as_list)
]


class When(Settings):
    """A step is done, or left out, by the answer to a question."""

    input: Annotated[str, Field(min_length=1)]
    """The input of the run: asked at the start, or by a step before."""
    is_: Annotated[Answers, Field(alias="is")] = ()
    """The answer, or a list of answers, with which the step is done."""
    is_not: Answers = ()
    """The answer, or a list of answers, with which it is left out."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if bool(self.is_) == bool(self.is_not):
            raise ValueError("expected one of: is, is_not")
        return self


class Until(Settings):
    """A repetition ends once a channel, read at the end of each pass, is beyond a value."""

    channel: Member
    """Role and channel, such as tester.temperature; read once."""
    above: AnyQuantity | None = None
    """It ends above this."""
    below: AnyQuantity | None = None
    """It ends below this."""

    @model_validator(mode="before")
    @classmethod
    def _no_result(cls, value: object) -> object:
        if isinstance(value, dict) and "of" in value:
            raise ValueError(
                "a repetition cannot wait for a result yet: results are computed after the run;"
                " name a channel that is read: 'channel: role.name'"
            )
        return value

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.above is None) == (self.below is None):
            raise ValueError("expected one of: above, below")
        return self
