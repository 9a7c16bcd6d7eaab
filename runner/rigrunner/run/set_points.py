"""Results of a result document with their places; a sweep may repeat one."""

from __future__ import annotations

from collections import Counter
from contextlib import suppress
from functools import cache
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api.coordinates import CoordinateValue, place_text
from rigrunner.api.summaries import GROUP

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rigrunner.api.summaries import SummaryParts

_T = TypeVar("_T")


def with_unique_names(named: Iterable[tuple[str, _T]]) -> Iterator[tuple[str, _T]]:
    """Yield the names, the second of equal ones as 'name (2)'."""
    seen = Counter[str]()
    for name, item in named:
        seen[name] += 1
        yield f"{name} ({seen[name]})".strip() if seen[name] > 1 else name, item


def coordinates_in(result: Mapping[str, Any]) -> dict[str, CoordinateValue]:
    """Return the place of a named result of a document."""
    coordinates = result.get("coordinates")
    items = coordinates.items() if isinstance(coordinates, dict) else ()
    return {str(name): CoordinateValue.stored(value) for name, value in items}


def named_place(result: Mapping[str, Any]) -> str:
    """Return the name of a named result of a document with its place."""
    place = place_text(coordinates_in(result))
    return f"{result.get('name')} at {place}" if place else str(result.get("name"))


def other_results(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the named results of a document, except the one of its headline."""
    headline = (document.get("headline") or {}).get("name")
    return [result for result in document.get("results") or () if result["name"] != headline]


def results_in(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the named results of a document; of one of 0.1.0, also those in keys of packages."""
    results = list(document.get("results") or ())
    if (document.get("headline") or {}).get("name"):
        return results
    extra = (result for result in _of_packages(document) if "note" not in result["estimate"])
    return [*(result for result in extra if result["coordinates"]), *results]


def estimates_of_packages(document: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the estimates in keys of packages, by their places, such as 'at 5 Hz'; '' for none."""
    for name, result in with_unique_names(
        (_at(result), result) for result in _of_packages(document)
    ):
        yield name, result["estimate"]


def unread(document: Mapping[str, Any]) -> list[str]:
    """Return the keys of packages that have values, and that no installed package reads."""
    from rigrunner.analysis.document import ALWAYS  # noqa: PLC0415  (numpy)

    read_keys = {"headline", *(key for reader in _readers() for key in reader.reads)}
    keys = (key for key, empty in ALWAYS.items() if document.get(key, empty) != empty)
    return [key for key in keys if key not in read_keys]


def _of_packages(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [result for reader in _readers() for result in reader.results(document)]


def _at(result: Mapping[str, Any]) -> str:
    places = ", ".join(str(value) for value in coordinates_in(result).values())
    return f"at {places}" if places else ""


@cache
def _readers() -> tuple[SummaryParts, ...]:
    """Return what installed packages read; the keys of one that cannot be imported are unread."""
    readers = []
    for entry in entry_points(group=GROUP):
        with suppress(Exception):  # a package may raise anything
            readers.append(entry.load())
    return tuple(readers)
