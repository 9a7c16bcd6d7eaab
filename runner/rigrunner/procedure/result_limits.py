"""What a result may be, of any quantity: which one, where, and who says so."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api.errors import DataError
from rigrunner.api.measurand import CONDITIONS, NATURES, Condition, MeasurandKind, Nature
from rigrunner.api.names import Name, Text
from rigrunner.api.places import CoordinateKey, Places, is_in, places_text
from rigrunner.api.quantity import Quantity
from rigrunner.api.settings import Force, Settings, YesNo
from rigrunner.api.units import unit
from rigrunner.api.verdict import Limits
from rigrunner.procedure.following import End, Line, Table

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rigrunner.api.coordinates import CoordinateValue

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
    """The worst of them by the rule must be within it: one verdict over all, with its place."""
    max: End | None = None
    """The highest that is allowed; one that follows a coordinate is a mapping."""
    min: End | None = None
    """The lowest that is allowed; one that follows a coordinate is a mapping."""
    plus_minus: End | None = None
    """In place of both: how far from zero a difference may be, such as a deviation."""
    measurand: LimitMeasurand | None = None
    """Of a torque, and needed there: which one it is a limit of; it is refused for any other."""
    source: Text
    """Who says so: a standard with its edition, a drawing, an agreement."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if not self.ends:
            raise ValueError("a limit needs max, min, or both, or plus_minus")
        if self.plus_minus is not None and len(self.ends) > 1:
            raise ValueError("'plus_minus' stands in place of min and max")
        kinds = {name: end.dimension for name, end in self._written.items()}
        if len(set(kinds.values())) > 1:
            raise ValueError(f"min is a {kinds['min']}, max a {kinds['max']}")
        ends = self.min, self.max
        if all(isinstance(each, Quantity) for each in ends) and self.min.si >= self.max.si:  # type: ignore[union-attr]  # quantities
            raise ValueError(f"min ({self.min}) must be below max ({self.max})")
        if self.plus_minus is not None:
            self._require_difference()
        if self.mean and (self.worst or self.each is not None):
            raise ValueError("'mean' stands alone; 'each' and 'worst' may stand together")
        if self.mean and self.follows:
            raise ValueError("a limit that follows a coordinate is none of a mean")
        return self

    def _require_difference(self) -> None:
        written = self._written["plus_minus"]
        if written.unit.offset:
            raise ValueError(f"got '{written}', a temperature; write a difference in K")
        if written.si <= 0:
            raise ValueError(f"got '{written}', expected more than 0")

    @property
    def ends(self) -> dict[str, Quantity | Line | Table]:
        """The limits by their keys."""
        found = {"min": self.min, "max": self.max, "plus_minus": self.plus_minus}
        return {name: each for name, each in found.items() if each is not None}

    @property
    def _written(self) -> dict[str, Quantity]:
        return {
            name: each if isinstance(each, Quantity) else each.written
            for name, each in self.ends.items()
        }

    @property
    def follows(self) -> set[str]:
        """The coordinates that it follows."""
        return {each.over for each in self.ends.values() if not isinstance(each, Quantity)}

    def of_result(self) -> Iterator[tuple[tuple[str | int, ...], Quantity]]:
        """Yield each value of the result that it names, and where it stands in the limit."""
        for name, end in self.ends.items():
            if isinstance(end, Quantity):
                yield (name,), end
            else:
                for place, value in end.of_result():
                    yield (name, *place), value

    def of_coordinates(self) -> Iterator[tuple[tuple[str | int, ...], str, Quantity]]:
        """Yield each value of a coordinate: where it stands in the limit, of which one, and it."""
        for key, places in (("where", self.where), ("except", self.except_)):
            for name, values in places.items():
                yield from (((key, name), name, v) for v in values if isinstance(v, Quantity))
        for key, end in self.ends.items():
            if not isinstance(end, Quantity):
                place, value = end.of_coordinate()
                yield (key, *place), end.over, value

    @property
    def highest(self) -> Quantity | None:
        """The upper limit, where it is one quantity."""
        return self.max if isinstance(self.max, Quantity) else None

    @property
    def dimension(self) -> str:
        """The kind of quantity that it limits."""
        return self.written.dimension

    @property
    def written(self) -> Quantity:
        """One of the limits as the procedure writes it."""
        return next(iter(self._written.values()))

    def is_of(self, coordinates: Mapping[str, CoordinateValue]) -> bool:
        """Say whether it limits results at that place."""
        excepted = self.except_ and is_in(self.except_, coordinates)
        return is_in(self.where, coordinates) and not excepted

    def limits_at(self, coordinates: Mapping[str, CoordinateValue], symbol: str) -> Limits:
        """Return the limits at a place as numbers in a unit of the same kind.

        Raises DataError where a limit that follows a coordinate has none there.
        """
        if self.plus_minus is not None:
            half = _number(self.plus_minus, coordinates, symbol, is_difference=True)
            return Limits.between(-half, half, symbol)
        low, high = (
            None if end is None else _number(end, coordinates, symbol)
            for end in (self.min, self.max)
        )
        if low is not None and high is not None and low >= high:
            raise DataError(f"the lower limit, {low:g} {symbol}, is not below the upper one there")
        return Limits.between(low, high, symbol)

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
        given |= {
            name: str(each) if isinstance(each, Quantity) else each.as_written()
            for name, each in self.ends.items()
        }
        if self.measurand is not None:
            given["measurand"] = self.measurand.as_written()
        return given | {"source": self.source}

    @property
    def scope(self) -> str:
        """What it limits, in words that are equal for equal scopes."""
        where = places_text(self.where)
        without = places_text(self.except_)
        how = "mean" if self.mean else "each" if self.each or not self.worst else "worst"
        return (
            f"{self.of}{f' at {where}' if where else ''}"
            f"{f' except at {without}' if without else ''} ({how})"
        )


def _number(
    end: Quantity | Line | Table,
    coordinates: Mapping[str, CoordinateValue],
    symbol: str,
    *,
    is_difference: bool = False,
) -> float:
    known = unit(symbol)
    if isinstance(end, Quantity):
        if end.unit.symbol == symbol:
            return end.number
        si = end.si
    else:
        si = end.si_at(coordinates)
    offset = 0.0 if is_difference else known.offset
    return float(f"{(si - offset) / known.factor:.15g}")


def _words(found: MeasurandKind, loads_n: list[float]) -> str:
    nature, condition = NATURES[found.nature], CONDITIONS[found.condition]
    if not loads_n:
        return f"{nature} {condition}"
    low, high = loads_n[0], loads_n[-1]
    span = f"{low:.0f} N" if high - low <= LOAD_TOLERANCE * high else f"{low:.0f} N to {high:.0f} N"
    return f"{nature} {condition} under {span}"
