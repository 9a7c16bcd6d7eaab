"""Names of the set-points of a result document; a sweep may repeat a frequency."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api.coordinates import CoordinateValue, place_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

_T = TypeVar("_T")


def told_apart(named: Iterable[tuple[str, _T]]) -> Iterator[tuple[str, _T]]:
    """Yield the names, the second of equal ones as 'name (2)'."""
    seen = Counter[str]()
    for name, each in named:
        seen[name] += 1
        yield f"{name} ({seen[name]})".strip() if seen[name] > 1 else name, each


def named_by_frequency(points: Iterable[tuple[float | None, _T]]) -> Iterator[tuple[str, _T]]:
    """Yield each with the name of its set-point, such as 'at 5 Hz'; '' without a frequency."""
    return told_apart(("" if hz is None else f"at {hz:g} Hz", each) for hz, each in points)


def coordinates_in(result: Mapping[str, Any]) -> dict[str, CoordinateValue]:
    """Return the place of a named result of a document."""
    found = result.get("coordinates")
    known = found.items() if isinstance(found, dict) else ()
    return {str(name): CoordinateValue.stored(each) for name, each in known}


def named_place(result: Mapping[str, Any]) -> str:
    """Return the name of a named result of a document with its place."""
    place = place_text(coordinates_in(result))
    return f"{result.get('name')} at {place}" if place else str(result.get("name"))


def other_results(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the named results of a document, without the torque, which is in its points."""
    torque = (document.get("headline") or {}).get("name")
    return [each for each in document.get("results") or () if each["name"] != torque]


def results_in(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the named results of a document; of one of 0.1.0, the torque of its set-points."""
    from rigrunner.analysis.document import primary_points  # noqa: PLC0415  (numpy)

    found = list(document.get("results") or ())
    if (document.get("headline") or {}).get("name"):
        return found
    torque = [
        {
            "name": "torque",
            "coordinates": {"frequency": {"value": each["set_frequency"]["value"], "unit": "Hz"}},
            "estimate": each["torque"],
        }
        for each in primary_points(document)
        if each["set_frequency"]["value"] is not None
    ]
    return [*torque, *found]
