"""The low-pass filter between transducer and converter, as stated in the register."""

from __future__ import annotations

import itertools
from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from rigrunner.api.settings import Angle, Frequency, ListOf, PlainText, Settings


class LowPass(Settings):
    """An analogue filter with a named characteristic."""

    type: Literal["butterworth", "bessel", "chebyshev"] = "butterworth"
    """Characteristic of the filter."""
    order: Annotated[int, Field(ge=1, le=8)] = 2
    """Order of the filter."""
    corner: Annotated[Frequency, Field(gt=0)]
    """Frequency of -3 dB."""
    ripple_db: Annotated[float | None, Field(gt=0, le=3)] = None
    """Ripple of a Chebyshev filter (type I) in its pass band, in dB."""

    @model_validator(mode="after")
    def _ripples(self) -> Self:
        if (self.type == "chebyshev") != (self.ripple_db is not None):
            raise ValueError("ripple_db belongs to chebyshev, and chebyshev needs it")
        return self

    @property
    def described(self) -> str:
        """The filter as text."""
        ripple = "" if self.ripple_db is None else f", {self.ripple_db:g} dB ripple"
        return f"{self.type}, order {self.order}, {self.corner:g} Hz{ripple}"

    def scaled(self, factor: float) -> LowPass:
        """Return the same filter, scaled up in frequency by a factor."""
        return self.model_copy(update={"corner": self.corner * factor})


class Fir(Settings):
    """A digital filter by its taps, with their delay."""

    type: Literal["fir"]
    """Specified by the impulse response."""
    taps: Annotated[ListOf[float], Field(min_length=1, max_length=4096)]
    """One tap per sample; scaled to a gain of 1 at rest."""
    rate: Annotated[Frequency, Field(gt=0)]
    """Rate of the samples that it filters."""

    @model_validator(mode="after")
    def _passes_constant_signals(self) -> Self:
        # Taps are written with few digits: those of a high-pass do not add up to exactly 0.
        if abs(sum(self.taps)) <= 1e-6 * sum(abs(tap) for tap in self.taps):
            raise ValueError("the taps add up to 0: such a filter gives 0 for a constant signal")
        return self

    @property
    def described(self) -> str:
        """The filter as text."""
        return f"FIR of {len(self.taps)} taps at {self.rate:g} Hz"

    def scaled(self, factor: float) -> Fir:
        """Return the same filter, scaled up in frequency by a factor."""
        return self.model_copy(update={"rate": self.rate * factor})


class ResponsePoint(Settings):
    """The response at one frequency, relative to that at rest."""

    frequency: Annotated[Frequency, Field(gt=0)]
    """Frequency of the sine."""
    gain: Annotated[float, Field(gt=0)]
    """Amplitude out over amplitude in, relative to that at rest."""
    phase: Angle
    """Phase of the output relative to the input: negative if it lags."""


class MeasuredResponse(Settings):
    """A filter, or a whole measuring chain, with a measured frequency response."""

    type: Literal["measured"]
    """Specified by a table."""
    response: Annotated[ListOf[ResponsePoint], Field(min_length=2)]
    """Points at ascending frequencies, between which the phase changes by less than half a turn."""
    source: Annotated[PlainText, Field(min_length=1, max_length=80)]
    """Who measured it and when."""

    @model_validator(mode="after")
    def _frequencies_ascend(self) -> Self:
        hertz = [point.frequency for point in self.response]
        if any(after <= before for before, after in itertools.pairwise(hertz)):
            raise ValueError("the frequencies of the response must ascend")
        return self

    @property
    def described(self) -> str:
        """The filter as text."""
        last = self.response[-1].frequency
        return f"measured up to {last:g} Hz ({self.source})"

    def scaled(self, factor: float) -> MeasuredResponse:
        """Return the same filter, scaled up in frequency by a factor."""
        moved = tuple(
            point.model_copy(update={"frequency": point.frequency * factor})
            for point in self.response
        )
        return self.model_copy(update={"response": moved})


def _kind(value: object) -> str:
    kind = value.get("type") if isinstance(value, dict) else getattr(value, "type", None)
    return kind if isinstance(kind, str) and kind in {"fir", "measured"} else "named"


AnyFilter = Annotated[
    Annotated[LowPass, Tag("named")]
    | Annotated[Fir, Tag("fir")]
    | Annotated[MeasuredResponse, Tag("measured")],
    Discriminator(_kind),
]
"""A filter of any kind: `butterworth` unless `type` states another."""
