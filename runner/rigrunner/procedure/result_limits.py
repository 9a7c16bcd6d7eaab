"""What a result may be, of any quantity: which one, where, and who says so."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api.measurand import CONDITIONS, NATURES, Condition, MeasurandKind, Nature
from rigrunner.api.places import CoordinateKey, Places, places_text
from rigrunner.api.settings import AnyQuantity, Force, Settings, YesNo
from rigrunner.api.units import unit
from rigrunner.api.verdict import Limits
from rigrunner.yamlfile.names import Name, Text

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.quantity import Quantity

LOAD_TOLERANCE = 0.01
"""How far a load may be from that of the limit, as a part of it."""
UNLOADED_N = 10.0
"""What a load cell may show of a bearing without load."""


class LimitMeasurand(Settings):
    """Which torque a limit is for; it says nothing of any other."""

    nature: Literal["load_induced", "total", "no_load"]
    """What the load adds, all under load, or all without load."""
    condition: Literal["at_reversal", "from_rest", "under_way"]
    """At the reversals of a swing, at the first movement after a rest, or as a mean on the way."""
    load: Force | None = None
    """The load at which it holds; left out, at any."""

    @property
    def kind(self) -> MeasurandKind:
        """Nature and condition."""
        return MeasurandKind(Nature(self.nature), Condition(self.condition))

    def __str__(self) -> str:
        """Return it in words: 'load-induced torque at the reversals of a swing under 1000 N'."""
        return str(self.kind) if self.load is None else f"{self.kind} under {self.load:g} N"

    def objection(self, found: MeasurandKind, loads_n: Iterable[float]) -> str:
        """Return why this is not the torque that was found under those loads; '' if it is."""
        loads = sorted(loads_n)
        unloaded = bool(loads) and loads[-1] <= UNLOADED_N
        natures = {found.nature}
        if found.nature is Nature.TOTAL and (unloaded or not loads):
            natures.add(Nature.NO_LOAD)
        fits = self.kind.nature in natures and self.kind.condition is found.condition
        if fits and (self.load is None or all(self._is_at(load) for load in loads)):
            return ""
        return f"the limit is for the {self}, and the result is the {_words(found, loads)}"

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it; read back, it is the same."""
        written: dict[str, object] = {"nature": self.nature, "condition": self.condition}
        return written if self.load is None else {**written, "load": f"{self.load!r} N"}

    def _is_at(self, load_n: float) -> bool:
        assert self.load is not None  # noqa: S101  (asked only where there is one)
        return abs(load_n - self.load) <= (LOAD_TOLERANCE * self.load or UNLOADED_N)


class Limit(Settings):
    """What a result of an analysis may be, by its name, and who says so."""

    of: Name
    """The name of the result, as the analysis gives it."""
    where: Places = Field(default_factory=dict)
    """Only the results there, such as {load.current: 2 A}, or at several, [1 A, 2 A]; left out,
    all."""
    except_: Annotated[Places, Field(alias="except")] = Field(default_factory=dict)
    """Not the results there, such as those that have a limit of their own."""
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
    measurand: LimitMeasurand | None = None
    """Of a torque, and needed there: which one it is a limit of; it is refused for any other."""
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
        return self.written.dimension

    @property
    def written(self) -> Quantity:
        """One of the limits as the procedure writes it."""
        written = self.max or self.min
        assert written is not None  # noqa: S101  (one of them is needed)
        return written

    def limits_in(self, symbol: str) -> Limits:
        """Return the limits as numbers in a unit of the same kind."""
        return Limits.between(_number(self.min, symbol), _number(self.max, symbol), symbol)

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it, with units; read back, it is the same."""
        given: dict[str, object] = {"of": self.of}
        for name, places in (("where", self.where), ("except", self.except_)):
            if places:
                written = {at: [str(each) for each in values] for at, values in places.items()}
                given[name] = {at: v if len(v) > 1 else v[0] for at, v in written.items()}
        if self.each is not None:
            given["each"] = self.each
        given |= {name: True for name in ("mean", "worst") if getattr(self, name)}
        ends = {"max": self.max, "min": self.min}
        given |= {name: str(each) for name, each in ends.items() if each is not None}
        if self.measurand is not None:
            given["measurand"] = self.measurand.as_written()
        return given | {"source": self.source}

    @property
    def scope(self) -> str:
        """What it limits, in words that are equal for equal scopes."""
        where = places_text(self.where)
        without = places_text(self.except_)
        how = "mean" if self.mean else "worst" if self.worst else "each"
        return (
            f"{self.of}{f' at {where}' if where else ''}"
            f"{f' except at {without}' if without else ''} ({how})"
        )


def _number(value: Quantity | None, symbol: str) -> float | None:
    if value is None:
        return None
    if value.unit.symbol == symbol:
        return value.number
    known = unit(symbol)
    return float(f"{(value.si - known.offset) / known.factor:.15g}")


def _words(found: MeasurandKind, loads_n: list[float]) -> str:
    nature, condition = NATURES[found.nature], CONDITIONS[found.condition]
    if not loads_n:
        return f"{nature} {condition}"
    low, high = loads_n[0], loads_n[-1]
    span = f"{low:.0f} N" if high - low <= LOAD_TOLERANCE * high else f"{low:.0f} N to {high:.0f} N"
    return f"{nature} {condition} under {span}"
