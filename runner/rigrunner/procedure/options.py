"""Under which terms a step counts as done: in time, tried again, with values within limits."""

from __future__ import annotations

from typing import Annotated, Literal, Self

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
from rigrunner.api.units import with_article

Timeout = Annotated[
    PositiveDuration | None,
    Field(description="Longest duration of the step; a longer one is a failure."),
]
Retries = Annotated[
    int,
    Field(
        ge=0,
        le=100,
        description="Number of further attempts after a failure. A value out of its limits is a"
        " result, not a failure: it is not read again.",
    ),
]
Repeatable = Annotated[
    YesNo,
    Field(
        description="Whether the step may be executed twice; if not, a pause within it aborts"
        " the run."
    ),
]
OnFail = Annotated[
    Literal["stop", "continue"],
    Field(
        description="Action after a value out of its limits, or after the last failure: end the"
        " run, or continue with the next step."
    ),
]


SampleStatistic = Literal["mean", "minimum", "maximum", "peak_to_peak", "rms"]
Cycles = Annotated[int, Field(ge=1, le=1_000_000)]
Channels = Annotated[ListOf[Member], Field(min_length=1)]


class Bounds(Settings):
    """A lowest and a highest value, and the distance from them within which a value is marginal."""

    min: AnyQuantity | None = None
    """Lower limit."""
    max: AnyQuantity | None = None
    """Upper limit."""
    marginal: Difference | None = None
    """A value inside a limit by less than this is recorded as marginal."""

    def _refuse_no_range(self) -> None:
        if self.min is None and self.max is None:
            raise ValueError("a limit needs max, min, or both")
        bounds = [bound for bound in (self.min, self.max, self.marginal) if bound is not None]
        kinds = [with_article(bound.dimension) for bound in bounds]
        if len(set(kinds)) > 1:
            raise ValueError(f"'{bounds[0]}' is {kinds[0]}, but '{bounds[-1]}' is {kinds[-1]}")
        if self.min is None or self.max is None:
            return
        if self.min.si >= self.max.si:
            raise ValueError(f"min ({self.min}) must be below max ({self.max})")
        if self.marginal is not None and 2 * self.marginal.si >= self.max.si - self.min.si:
            raise ValueError(
                f"marginal ({self.marginal}) leaves nothing between {self.min} and {self.max}"
            )


class Band(Bounds):
    """Limits of a value, and the distance from them within which it is marginal."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        self._refuse_no_range()
        return self


class DifferenceBand(Band):
    """Limits of a difference of two values."""

    min: Difference | None = None
    """Lower limit."""
    max: Difference | None = None
    """Upper limit."""


class ValueBand(Bounds):
    """Limits of a value: `min` and `max` of a number, `equals` or `one_of` of any other."""

    equals: bool | str | None = None
    """Required text, or yes or no."""
    one_of: Annotated[ListOf[bool | str], Field(max_length=100)] = ()
    """Accepted texts, or yes and no."""

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
            self._refuse_no_range()
        return self


class RecordedBand(Bounds):
    """Limits of a recorded channel: of every sample, and of statistics of all samples.

    For a channel that is read beside the recording, they are limits of its value.
    """

    min: AnyQuantity | None = None
    """Lower limit of every sample."""
    max: AnyQuantity | None = None
    """Upper limit of every sample."""
    marginal: Difference | None = None
    """A value inside `min` or `max` by less than this is recorded as marginal."""
    mean: Band | None = None
    """Limits of the mean of all samples."""
    minimum: Band | None = None
    """Limits of the lowest sample."""
    maximum: Band | None = None
    """Limits of the highest sample."""
    peak_to_peak: DifferenceBand | None = None
    """Limits of the difference between the highest and the lowest sample."""
    rms: Band | None = None
    """Limits of the root mean square of all samples."""

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        of_samples = self.min is not None or self.max is not None
        if of_samples or self.marginal is not None or not self.statistics:
            self._refuse_no_range()
        for key, statistic in (("min", "minimum"), ("max", "maximum")):
            if getattr(self, key) is not None and statistic in self.statistics:
                raise ValueError(
                    f"'{key}' and '{statistic}' limit the same value: give one of them"
                )
        return self

    @property
    def statistics(self) -> dict[str, Band | DifferenceBand]:
        """The statistics that have limits, by their names."""
        bands = {name: getattr(self, name) for name in STATISTICS}
        return {name: band for name, band in bands.items() if band is not None}

    @property
    def of_samples(self) -> dict[str, tuple[AnyQuantity | None, AnyQuantity | None]]:
        """What `min` and `max` say of the extremes, by their names: lowest and highest allowed."""
        extremes = {"minimum": (self.min, None), "maximum": (None, self.max)}
        return {name: ends for name, ends in extremes.items() if ends != (None, None)}


RecordedLimits = Annotated[
    dict[Member, RecordedBand],
    Field(
        description="Limits of its values, by role.name; a value out of limits is kept, and the"
        " verdict on the run is fail."
    ),
]
Limits = Annotated[
    dict[Member, ValueBand],
    Field(
        description="Limits of its values, by role.name; a value out of limits is kept, and the"
        " verdict on the run is fail."
    ),
]
