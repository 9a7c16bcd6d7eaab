"""Limits that follow a coordinate of their result: a line over it, or a table."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Discriminator, Field, Tag, model_validator

from rigrunner.api.errors import DataError
from rigrunner.api.places import CoordinateKey
from rigrunner.api.settings import AnyQuantity, Difference, ListOf, Settings
from rigrunner.api.units import unit, with_article

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.quantity import Quantity


class Line(Settings):
    """A limit that increases linearly with the distance of a coordinate from a given value."""

    base: AnyQuantity
    """Limit at `from`."""
    rise: AnyQuantity
    """Increase of the limit for a distance `per` from `from`, to either side."""
    per: Difference
    """Distance of the coordinate for which `rise` is stated."""
    over: CoordinateKey
    """The coordinate of the result, such as chamber.temperature."""
    from_: Annotated[AnyQuantity | None, Field(alias="from")] = None
    """Value of the coordinate with the limit `base`; if omitted, zero, or 0 °C for a
    temperature."""

    @model_validator(mode="after")
    def _is_of_one_kind(self) -> Self:
        if self.rise.dimension != self.base.dimension:
            raise ValueError(
                f"base is {with_article(self.base.dimension)}, rise"
                f" {with_article(self.rise.dimension)}"
            )
        if self.rise.unit.offset:
            raise ValueError(f"got 'rise: {self.rise}', a temperature; write a difference in K")
        if self.from_ is not None and self.from_.dimension != self.per.dimension:
            raise ValueError(
                f"per is {with_article(self.per.dimension)}, from"
                f" {with_article(self.from_.dimension)}"
            )
        return self

    @property
    def written(self) -> Quantity:
        """The limit as it is written, where the coordinate is zero."""
        return self.base

    def of_result(self) -> Iterator[tuple[tuple[str | int, ...], Quantity]]:
        """Yield each value of the result that it names, and where it stands."""
        yield ("base",), self.base

    def of_coordinate(self) -> tuple[tuple[str | int, ...], Quantity]:
        """Return a value of the coordinate that it names, and where it stands."""
        return ("per",), self.per

    def si_at(self, coordinates: Mapping[str, CoordinateValue]) -> float:
        """Return the limit in the SI unit at a place; raise DataError where it has none."""
        origin = self.from_
        zero = unit("°C").offset if self.per.dimension == "temperature" else 0.0
        distance = abs(
            _si(coordinates, self.over, self.per.dimension) - (origin.si if origin else zero)
        )
        return self.base.si + self.rise.si * distance / self.per.si

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it; read back, it is the same."""
        members = {"base": str(self.base), "rise": str(self.rise), "per": str(self.per)}
        start = {} if self.from_ is None else {"from": str(self.from_)}
        return {**members, "over": self.over, **start}


class Table(Settings):
    """A limit given at some values of a coordinate, with linear interpolation between them."""

    over: CoordinateKey
    """The coordinate of the result, such as chamber.temperature."""
    points: Annotated[ListOf[Annotated[ListOf[AnyQuantity], Field(min_length=2, max_length=2)]],
                      Field(min_length=2)]  # fmt: skip
    """Pairs of a value of the coordinate and the limit there: [[0 °C, 100.117 Ω], ...]."""

    @model_validator(mode="after")
    def _is_in_order(self) -> Self:
        for index in (0, 1):
            kinds = {point[index].dimension for point in self.points}
            if len(kinds) > 1:
                raise ValueError(f"the points are of several kinds: {', '.join(sorted(kinds))}")
        for (before, _), (after, _) in pairwise(self.points):
            if after.si <= before.si:
                raise ValueError(f"{after} is after {before}: write the points in ascending order")
        return self

    @property
    def written(self) -> Quantity:
        """The first limit as it is written."""
        return self.points[0][1]

    def of_result(self) -> Iterator[tuple[tuple[str | int, ...], Quantity]]:
        """Yield each value of the result that it names, and where it stands."""
        for number, (_, limit) in enumerate(self.points):
            yield ("points", number, 1), limit

    def of_coordinate(self) -> tuple[tuple[str | int, ...], Quantity]:
        """Return a value of the coordinate that it names, and where it stands."""
        return ("points", 0, 0), self.points[0][0]

    def si_at(self, coordinates: Mapping[str, CoordinateValue]) -> float:
        """Return the limit in the SI unit at a place; raise DataError beyond the table."""
        kind = self.points[0][0].dimension
        x = _si(coordinates, self.over, kind)
        for (before, low), (after, high) in pairwise(self.points):
            # A coordinate at an end of the table may be beyond it by the rounding of units.
            tolerance = 1e-9 * (after.si - before.si)
            if before.si - tolerance <= x <= after.si + tolerance:
                share = (x - before.si) / (after.si - before.si)
                return low.si + share * (high.si - low.si)
        first, last = self.points[0][0], self.points[-1][0]
        at = coordinates[self.over]
        raise DataError(f"the limit is known from {first} to {last}, not at {at}")

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it; read back, it is the same."""
        return {"over": self.over, "points": [[str(x), str(y)] for x, y in self.points]}


def _form(value: Any) -> str:
    if isinstance(value, dict):
        return "table" if "points" in value else "line"
    if isinstance(value, Line):
        return "line"
    return "table" if isinstance(value, Table) else "quantity"


End = Annotated[
    Annotated[AnyQuantity, Tag("quantity")]
    | Annotated[Line, Tag("line")]
    | Annotated[Table, Tag("table")],
    Discriminator(_form),
]
"""A limit: one for all places, or one that follows a coordinate."""


def _si(coordinates: Mapping[str, CoordinateValue], name: str, kind: str) -> float:
    coordinate = coordinates.get(name)
    if coordinate is None or isinstance(coordinate.value, str):
        raise DataError(f"the limit follows '{name}', and the result has no such number")
    unit_ = unit(coordinate.unit or "1")
    if unit_.dimension != kind:
        raise DataError(
            f"the limit follows {with_article(kind)}, and '{name}' is"
            f" {with_article(unit_.dimension)}"
        )
    return unit_.to_si(coordinate.value)
