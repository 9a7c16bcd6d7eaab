"""What a person is asked or told."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api.names import Text
from rigrunner.api.settings import AnyQuantity, ListOf, Settings, UnitSymbol
from rigrunner.api.units import unit, with_article
from rigrunner.procedure.answers import AnswerError, Expected

if TYPE_CHECKING:
    from collections.abc import Iterator


_MOST_CHOICES = 100


Picture = Annotated[
    Text | None, Field(description="A picture to show: a file beside the procedure.")
]


class Question(Settings):
    """Accepted answers, and the answer of an unattended run."""

    unattended: str | None = None
    """The answer with `--unattended`; without it the question needs a person."""
    choices: Annotated[ListOf[Text], Field(max_length=_MOST_CHOICES)] = ()
    """The answers to choose from; without any, every answer is accepted."""
    unit: UnitSymbol | None = None
    """The answer is a number in this unit or a compatible one."""
    min: AnyQuantity | None = None
    """Lowest accepted number."""
    max: AnyQuantity | None = None
    """Highest accepted number."""

    @property
    def expected(self) -> Expected:
        """What is allowed as an answer."""
        return Expected(self.choices, self.unit or "", self.min, self.max)

    @model_validator(mode="after")
    def _can_be_answered(self) -> Self:
        for message in self._objections():
            raise ValueError(message)
        return self

    def _objections(self) -> Iterator[str]:
        if self.choices and self.unit:
            yield "got both, expected one of: choices, unit"
        if len(self.choices) == 1:
            yield f"'{self.choices[0]}' alone is not a choice; give another, or none"
        # Answers are compared without case.
        if len({choice.casefold() for choice in self.choices}) < len(self.choices):
            yield "a choice is listed twice"
        yield from self._objections_to_limits()
        if self.unattended is not None:
            try:
                self.expected.accept(self.unattended)
            except AnswerError as error:
                yield f"the unattended answer: {error.message}"

    def _objections_to_limits(self) -> Iterator[str]:
        for limit in (self.min, self.max):
            if limit is not None and self.unit is None:
                yield f"the limit '{limit}' needs a unit: 'unit: {limit.unit.symbol}'"
            elif limit is not None and self.unit and limit.dimension != unit(self.unit).dimension:
                kind = with_article(limit.dimension)
                yield f"the limit '{limit}' is {kind}, but the unit is {self.unit}"
        if self.min is not None and self.max is not None and self.min.si >= self.max.si:
            yield f"min ({self.min}) must be below max ({self.max})"


class Input(Question):
    """A question asked at the start; `unattended` is its answer in an unattended run."""

    ask: Text
    """The question to a person."""
