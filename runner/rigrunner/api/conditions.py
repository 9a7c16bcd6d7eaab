"""Conditions of steps in a procedure: a value or an answer, without computation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from rigrunner.api.member import NAME, Member
from rigrunner.api.quantity import Quantity  # noqa: TC001  (pydantic reads it)
from rigrunner.api.settings import AnyQuantity, ListOf, Settings
from rigrunner.api.texts import plain

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator


def _as_list(value: Any) -> Any:
    if isinstance(value, bool | int | float):
        raise ValueError(f"got {value}, expected a text; put it in quotes")  # noqa: TRY004  (pydantic places it)
    return [value] if isinstance(value, str) else value


Answers = Annotated[
    ListOf[Annotated[str, Field(min_length=1), AfterValidator(plain)]], BeforeValidator(_as_list)
]


class When(Settings):
    """A step is executed or skipped, depending on the answer to a question."""

    input: Annotated[str, Field(min_length=1)]
    """The input of the run: asked at the start, or by an earlier step."""
    is_: Annotated[Answers, Field(alias="is")] = ()
    """The answer, or a list of answers, for which the step is executed."""
    is_not: Answers = ()
    """The answer, or a list of answers, for which it is skipped."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if bool(self.is_) == bool(self.is_not):
            raise ValueError("expected one of: is, is_not")
        return self


class Until(Settings):
    """A repetition ends when a value, read after each pass, is above or below a bound."""

    channel: Member | None = None
    """Role and channel, such as tester.temperature; read once."""
    result: Annotated[str, Field(pattern=f"^{NAME}$")] | None = None
    """Name of a result of an analysis, calculated from the data so far.

    Of several, the one of the place that was measured last.
    """
    above: AnyQuantity | None = None
    """End above this value."""
    below: AnyQuantity | None = None
    """End below this value."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.channel is None) == (self.result is None):
            raise ValueError("expected one of: channel, result")
        if (self.above is None) == (self.below is None):
            raise ValueError("expected one of: above, below")
        return self

    @property
    def bound(self) -> tuple[str, Quantity]:
        """The key, 'above' or 'below', and the value."""
        if self.above is not None:
            return "above", self.above
        assert self.below is not None  # noqa: S101  (one of two)
        return "below", self.below


def each_until(
    ends: Iterable[Until], written: object
) -> Iterator[tuple[tuple[str | int, ...], Until]]:
    """Yield each condition with its key, of a list or a single one."""
    for number, until in enumerate(ends):
        yield (("until", number) if isinstance(written, list) else ("until",)), until
