"""Under which terms a step counts as done: in time, tried again, with values within limits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api.settings import AnyQuantity, Difference, PositiveDuration, Settings, YesNo
from rigrunner.yamlfile.names import Member

if TYPE_CHECKING:
    from collections.abc import Iterator

Timeout = Annotated[
    PositiveDuration | None, Field(description="How long it may take; longer is a failure.")
]
Retries = Annotated[
    int, Field(ge=0, le=100, description="How often it is tried again after a failure.")
]
Repeatable = Annotated[
    YesNo,
    Field(description="Whether it may be done twice; a pause inside one that may not aborts."),
]
OnFail = Annotated[
    Literal["stop", "continue"],
    Field(description="What follows its last failure: the end of the run, or the next step."),
]


class Band(Settings):
    """What a value may be, and how near to its limits it is put on record as marginal."""

    min: AnyQuantity | None = None
    """The lowest that is allowed."""
    max: AnyQuantity | None = None
    """The highest that is allowed."""
    marginal: Difference | None = None
    """A value nearer than this to a limit, and within it, is put on record."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        for message in self._objections():
            raise ValueError(message)
        return self

    def _objections(self) -> Iterator[str]:
        if self.min is None and self.max is None:
            yield "a limit needs max, min, or both"
        given = [each for each in (self.min, self.max, self.marginal) if each is not None]
        kinds = list(dict.fromkeys(each.dimension for each in given))
        if len(kinds) > 1:
            yield f"'{given[0]}' is a {kinds[0]}, but '{given[-1]}' is a {given[-1].dimension}"
        if self.min is None or self.max is None:
            return
        if self.min.si >= self.max.si:
            yield f"min ({self.min}) must be below max ({self.max})"
        if self.marginal is not None and 2 * self.marginal.si >= self.max.si - self.min.si:
            yield f"marginal ({self.marginal}) leaves nothing between {self.min} and {self.max}"


Limits = Annotated[
    dict[Member, Band],
    Field(description="What its values may be, by role.name; beyond it the step has failed."),
]
