"""Results of other analyses as inputs of a model, and the places where they apply."""

from __future__ import annotations

from math import isclose
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Check, DataError
from rigrunner.api.places import is_at
from rigrunner_plugins.analyses.sources import Group

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.findings import ResultPlace
    from rigrunner_plugins.analyses.equation.settings import EquationSettings

_SAME = 1e-9


def missing_results(results: Sequence[ResultPlace], settings: EquationSettings) -> Check | None:
    """Return a failed check if another analysis did not give a result that the model needs."""
    present = {result.name for result in results}
    missing = [source.of for source in settings.from_results.values() if source.of not in present]
    if not missing:
        return None
    names = " and ".join(result.name for result in settings.all_results)
    return Check(
        f"inputs of {names}",
        ok=False,
        text=f"there is no result {missing[0]}, of which {names} is made",
        advice=f"see why there is no {missing[0]}",
        decisive=True,
    )


def groups_of_results(results: Sequence[ResultPlace], settings: EquationSettings) -> list[Group]:
    """Return the places where the results apply, for a model that reads no channels.

    Raises DataError if they have no place in common.
    """
    input_names = {source.of for source in settings.from_results.values()}
    places: dict[tuple[CoordinateValue, ...], Group] = {}
    for result in results:
        coordinates = result.coordinates
        has_place = all(name in coordinates for name in settings.per)
        fits = is_at({k: v for k, v in settings.where.items() if k in coordinates}, coordinates)
        if result.name in input_names and has_place and fits:
            place = {name: coordinates[name] for name in settings.per}
            group = Group(place, {}, {}, np.zeros(0), in_a_row=False, step_s=0.0)
            places.setdefault(tuple(place.values()), group)
    if not places:
        raise DataError(f"{' and '.join(sorted(input_names))} hold at none of the places asked for")
    return list(places.values())


def results_at(
    results: Sequence[ResultPlace],
    settings: EquationSettings,
    place: Mapping[str, CoordinateValue],
) -> dict[str, ResultPlace]:
    """Return the results at a place, by their symbols in the model; raise DataError for none."""
    return {
        name: _result_at(results, settings, source.of, place)
        for name, source in settings.from_results.items()
    }


def _result_at(
    results: Sequence[ResultPlace],
    settings: EquationSettings,
    name: str,
    place: Mapping[str, CoordinateValue],
) -> ResultPlace:
    hits = [
       result
        for result in results
        if result.name == name
        and all(_is_same(value, place[key]) for key, value in result.coordinates.items()
                if key in place)
        and is_at({k: v for k, v in settings.where.items() if k in result.coordinates},
                  result.coordinates)
    ]  # fmt: skip
    if len(hits) != 1:
        at = ", ".join(f"{key} = {value}" for key, value in place.items())
        raise DataError(f"got {len(hits)} results {name}{f' at {at}' if at else ''}, expected one")
    return hits[0]


def _is_same(one: CoordinateValue, other: CoordinateValue) -> bool:
    if isinstance(one.value, str) or isinstance(other.value, str):
        return one == other
    return one.unit == other.unit and isclose(one.value, other.value, rel_tol=_SAME)
