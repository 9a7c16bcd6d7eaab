"""Whether a limit can be applied to its result where that is measured; checked before the run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rigrunner.api.errors import DataError
from rigrunner.api.places import matches
from rigrunner.api.units import unit, with_article

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.findings import ResultDefinition
    from rigrunner.procedure import Limit


class Place(Protocol):
    """Where a recording or row will be made."""

    @property
    def coordinate_units(self) -> Mapping[str, str]:
        """Of its set-points and coordinates; '' of one that has none."""
        ...

    @property
    def place(self) -> Mapping[str, CoordinateValue]:
        """The values of these, as far as they are known beforehand."""
        ...


Objection = tuple[tuple[str | int, ...], str, str]
"""Where it stands in the limit, a message and a hint."""


def objections_to_limit(
    limit: Limit, of: ResultDefinition, places: Sequence[Place]
) -> Iterator[Objection]:
    """Yield why a limit cannot be applied to its result at the places where that is measured."""
    fits = True
    for key, name, bound in limit.of_coordinates():
        symbol = next((each.coordinate_units[name] for each in places
                       if name in each.coordinate_units), None)  # fmt: skip
        if symbol is None or name not in of.per:
            return  # reported by the check of the coordinates
        kind = unit(symbol or "1").dimension
        if bound.dimension != kind:
            message = f"got '{bound}', {with_article(bound.dimension)}"
            yield key, f"{message}; {name} is {with_article(kind)}", f"write it in {symbol}"
            fits = False
    if fits:
        yield from _of_places(limit, of, [place.place for place in places])


def _of_places(
    limit: Limit, of: ResultDefinition, places: Sequence[Mapping[str, CoordinateValue]]
) -> Iterator[Objection]:
    """Yield where it names a place at which nothing is measured, or has no value at one that is."""
    for name, values in limit.where.items():
        measured = [place[name] for place in places if name in place]
        missing = [value for value in values if not any(matches(value, at) for at in measured)]
        # Where its value is not known beforehand, it may be any of them.
        if missing and len(measured) == len(places):
            hint = f"there are: {', '.join(dict.fromkeys(map(str, measured)))}"
            message = f"{of.name} is not measured at {', '.join(map(str, missing))}"
            yield ("where", name), message, hint
    for at in places:
        if limit.follows <= at.keys() and set(of.per) <= at.keys() and limit.is_of(at):
            try:
                limit.limits_at(at, of.unit)
            except DataError as error:
                ends = [key for key, end in limit.ends.items() if hasattr(end, "over")]
                yield tuple(ends[:1]), error.message, error.hint
                return
