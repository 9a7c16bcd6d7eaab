"""Under which terms a step counts as done: in time, tried again, with values within limits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Protocol, Self

from pydantic import Field, model_validator

from rigrunner.api.limits import STATISTICS
from rigrunner.api.member import Member
from rigrunner.api.settings import (
    AnyQuantity,
    Difference,
    ListOf,
    PositiveDuration,
    Settings,
    YesNo,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

Timeout = Annotated[
    PositiveDuration | None, Field(description="How long it may take; longer is a failure.")
]
Retries = Annotated[
    int,
    Field(
        ge=0,
        le=100,
        description="How often it is tried again after a failure. A value out of its limits is a"
        " result, not a failure: it is not read again.",
    ),
]
Repeatable = Annotated[
    YesNo,
    Field(description="Whether it may be done twice; a pause inside one that may not aborts."),
]
OnFail = Annotated[
    Literal["stop", "continue"],
    Field(
        description="What follows a value out of its limits, or the last failure: the end of the"
        " run, or the next step."
    ),
]


SampleStatistic = Literal["mean", "minimum", "maximum", "peak_to_peak", "rms"]
Cycles = Annotated[int, Field(ge=1, le=1_000_000)]
Channels = Annotated[ListOf[Member], Field(min_length=1)]


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
        for message in objections(self):
            raise ValueError(message)
        return self


class ValueBand(Settings):
    """What a value may be: a number `min` and `max`, a text or a yes or no `equals` or `one_of`."""

    min: AnyQuantity | None = None
    """The lowest that is allowed."""
    max: AnyQuantity | None = None
    """The highest that is allowed."""
    marginal: Difference | None = None
    """A value nearer than this to a limit, and within it, is put on record."""
    equals: bool | str | None = None
    """What a text, or a yes or no, has to be."""
    one_of: Annotated[ListOf[bool | str], Field(max_length=100)] = ()
    """What it has to be one of."""

    @property
    def texts(self) -> tuple[bool | str, ...]:
        """What a reading that is not a number may be; empty for a number."""
        return self.one_of if self.equals is None else (self.equals,)

    @model_validator(mode="after")
    def _is_of_one_kind(self) -> Self:
        bounded = (self.min, self.max, self.marginal) != (None, None, None)
        if bounded and self.texts:
            raise ValueError("a number has min and max, a text equals or one_of: not both")
        if self.equals is not None and self.one_of:
            raise ValueError("got both, expected one of: equals, one_of")
        if not self.texts:
            for message in objections(self):
                raise ValueError(message)
        return self


class Bounds(Protocol):
    """A lowest and a highest value, and how near to them a value is marginal."""

    @property
    def min(self) -> AnyQuantity | None:
        """The lowest that is allowed."""

    @property
    def max(self) -> AnyQuantity | None:
        """The highest that is allowed."""

    @property
    def marginal(self) -> Difference | None:
        """How near to a limit a value is marginal."""


def objections(band: Bounds) -> Iterator[str]:
    """Yield why these bounds are no range, in words."""
    if band.min is None and band.max is None:
        yield "a limit needs max, min, or both"
    given = [each for each in (band.min, band.max, band.marginal) if each is not None]
    kinds = list(dict.fromkeys(each.dimension for each in given))
    if len(kinds) > 1:
        yield f"'{given[0]}' is a {kinds[0]}, but '{given[-1]}' is a {given[-1].dimension}"
    if band.min is None or band.max is None:
        return
    if band.min.si >= band.max.si:
        yield f"min ({band.min}) must be below max ({band.max})"
    if band.marginal is not None and 2 * band.marginal.si >= band.max.si - band.min.si:
        yield f"marginal ({band.marginal}) leaves nothing between {band.min} and {band.max}"


class DifferenceBand(Settings):
    """What a difference of two values may be."""

    min: Difference | None = None
    """The lowest that is allowed."""
    max: Difference | None = None
    """The highest that is allowed."""
    marginal: Difference | None = None
    """A value nearer than this to a limit, and within it, is put on record."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        for message in objections(self):
            raise ValueError(message)
        return self


class RecordedBand(Settings):
    """What a recorded channel may be: every sample of it, and statistics of all its samples.

    Of a channel that is read beside the recording, the value.
    """

    min: AnyQuantity | None = None
    """The lowest that any sample may be."""
    max: AnyQuantity | None = None
    """The highest that any sample may be."""
    marginal: Difference | None = None
    """A value nearer than this to `min` or `max`, and within it, is put on record."""
    mean: Band | None = None
    """What the mean of all samples may be."""
    minimum: Band | None = None
    """What the lowest sample may be."""
    maximum: Band | None = None
    """What the highest sample may be."""
    peak_to_peak: DifferenceBand | None = None
    """What the difference of the highest and the lowest sample may be."""
    rms: Band | None = None
    """What the root mean square of all samples may be."""

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        of_samples = self.min is not None or self.max is not None
        if of_samples or self.marginal is not None or not self.statistics:
            for message in objections(self):
                raise ValueError(message)
        for one, statistic in (("min", "minimum"), ("max", "maximum")):
            if getattr(self, one) is not None and statistic in self.statistics:
                raise ValueError(
                    f"'{one}' and '{statistic}' limit the same value: give one of them"
                )
        return self

    @property
    def statistics(self) -> dict[str, Band | DifferenceBand]:
        """The statistics that have limits, by their names."""
        given = {name: getattr(self, name) for name in STATISTICS}
        return {name: band for name, band in given.items() if band is not None}

    @property
    def of_samples(self) -> dict[str, tuple[AnyQuantity | None, AnyQuantity | None]]:
        """What `min` and `max` say of the extremes, by their names: lowest and highest allowed."""
        found = {"minimum": (self.min, None), "maximum": (None, self.max)}
        return {name: ends for name, ends in found.items() if ends != (None, None)}


RecordedLimits = Annotated[
    dict[Member, RecordedBand],
    Field(
        description="What its values may be, by role.name; a value out of limits is kept, and the"
        " verdict on the run is fail."
    ),
]
Limits = Annotated[
    dict[Member, ValueBand],
    Field(
        description="What its values may be, by role.name; a value out of limits is kept, and the"
        " verdict on the run is fail."
    ),
]
