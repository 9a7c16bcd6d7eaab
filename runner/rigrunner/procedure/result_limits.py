"""What a named result may be, of any quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from pydantic import Field, model_validator

from rigrunner.api.places import CoordinateKey, Place
from rigrunner.api.settings import AnyQuantity, Settings, YesNo
from rigrunner.api.units import unit
from rigrunner.api.verdict import Limits
from rigrunner.yamlfile.names import Name, Text

if TYPE_CHECKING:
    from rigrunner.api.quantity import Quantity


class ResultLimit(Settings):
    """What a result of an analysis may be, by its name, and who says so."""

    of: Name
    """The name of the result, as the analysis gives it."""
    where: Place = Field(default_factory=dict)
    """Only the results there, such as {load.current: 2 A}; left out, all."""
    each: CoordinateKey | None = None
    """Each of the results over this coordinate must be within it."""
    mean: YesNo = False
    """Their mean must be within it."""
    worst: YesNo = False
    """The one that is farthest out, or nearest to the limit, must be within it."""
    max: AnyQuantity | None = None
    """The highest that is allowed."""
    min: AnyQuantity | None = None
    """The lowest that is allowed."""
    source: Text
    """Who says so: a standard with its edition, a drawing, an agreement."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if self.max is None and self.min is None:
            raise ValueError("a limit needs max, min, or both")
        if self.max is not None and self.min is not None:
            if self.max.dimension != self.min.dimension:
                kinds = f"a {self.min.dimension}, max a {self.max.dimension}"
                raise ValueError(f"min is {kinds}")
            if self.min.si >= self.max.si:
                raise ValueError(f"min ({self.min}) must be below max ({self.max})")
        if sum((self.each is not None, self.mean, self.worst)) > 1:
            raise ValueError("one of 'each', 'mean' and 'worst' is allowed, not several")
        return self

    @property
    def dimension(self) -> str:
        """The kind of quantity that it limits."""
        written = self.max or self.min
        assert written is not None  # noqa: S101  (one of them is needed)
        return written.dimension

    def limits_in(self, symbol: str) -> Limits:
        """Return the limits as numbers in a unit of the same kind."""
        return Limits(
            Limits.between(_number(self.min, symbol), None).lower,
            Limits.between(None, _number(self.max, symbol)).upper,
            symbol,
        )

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it, with units; read back, it is the same."""
        given: dict[str, object] = {"of": self.of}
        if self.where:
            given["where"] = {name: str(value) for name, value in self.where.items()}
        if self.each is not None:
            given["each"] = self.each
        given |= {name: True for name in ("mean", "worst") if getattr(self, name)}
        ends = {"max": self.max, "min": self.min}
        given |= {name: str(each) for name, each in ends.items() if each is not None}
        return given | {"source": self.source}

    @property
    def scope(self) -> str:
        """What it limits, in words that are equal for equal scopes."""
        where = ", ".join(f"{name} = {value}" for name, value in sorted(self.where.items()))
        how = "mean" if self.mean else "worst" if self.worst else "each"
        return f"{self.of}{f' at {where}' if where else ''} ({how})"


def _number(value: Quantity | None, symbol: str) -> float | None:
    if value is None:
        return None
    if value.unit.symbol == symbol:
        return value.number
    known = unit(symbol)
    return float(f"{(value.si - known.offset) / known.factor:.15g}")
