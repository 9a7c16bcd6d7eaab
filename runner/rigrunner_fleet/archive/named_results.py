"""The named results of a run, as rows of an archive: values, coordinates, verdict."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.coordinates import place_text
from rigrunner.api.units import find_unit, si_symbol
from rigrunner.api.verdict import WORST_FIRST
from rigrunner.run.set_points import coordinates_in, named_place
from rigrunner_fleet.archive.documents import at, count, degrees_of_freedom, key, number, rows, text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner_fleet.archive.result_facts import Row


def named_results(document: object, decision: object) -> list[Row]:
    """Return a row for each named result, in the unit in which it is stated.

    `decision`: the one in force; its limits on single results are shown with them.
    """
    parts_by_place: dict[str, list[Row]] = {}
    for part in rows(at(decision, "parts")):
        if coordinates_in(part):
            place = named_place({"name": part.get("named"), "coordinates": part["coordinates"]})
        else:  # older documents have only a text
            place = str(part.get("of")).removeprefix("worst ")
        parts_by_place.setdefault(place, []).append(part)
    return [_result(order, result, parts_by_place) for order, result in _numbered(document)]


def coordinates(document: object) -> list[Row]:
    """Return a row for each coordinate of each named result, in units that make runs comparable.

    The text is as stated, in the unit of the procedure.
    """
    coordinate_rows = []
    for order, result in _numbered(document):
        for name, coordinate in coordinates_in(result).items():
            usual = coordinate.usual
            is_number = not isinstance(usual.value, str)
            row = {
                "number": order,
                "name": key(name),
                "short": key(name.rpartition(".")[2]),
                "value": number(usual.value),
                "unit": text(usual.unit) if is_number else None,
                "text": text(str(coordinate)),
            }
            coordinate_rows.append(row)
    return coordinate_rows


def _numbered(document: object) -> Iterator[tuple[int, Row]]:
    return enumerate(rows(at(document, "results")), 1)


def _result(order: int, result: Row, parts_by_place: dict[str, list[Row]]) -> Row:
    estimate = at(result, "estimate")
    value, unit = number(at(estimate, "value")), at(estimate, "unit")
    parts = parts_by_place.get(named_place(result), ())
    lower = [number(at(part, "lower_limit", "value")) for part in parts]
    upper = [number(at(part, "upper_limit", "value")) for part in parts]
    return {
        "number": order,
        "name": key(result.get("name")),
        "symbol": text(result.get("symbol")),
        "measurand": text(result.get("text")),
        "place": text(place_text(coordinates_in(result))),
        "value": value,
        "u": number(at(estimate, "standard_uncertainty")),
        "expanded": number(at(estimate, "expanded_uncertainty_95")),
        "dof": degrees_of_freedom(at(estimate, "degrees_of_freedom")),
        "unit": text(unit),
        "readings": count(result.get("readings")),
        # A result may have several limits: a minimum of a standard, a maximum of a drawing.
        "lower": max((limit for limit in lower if limit is not None), default=None),
        "upper": min((limit for limit in upper if limit is not None), default=None),
        "verdict": text(at(min(parts, key=_badness, default=None), "verdict")),
        **_si(value, unit),
    }


def _si(value: float | None, unit_symbol: object) -> Row:
    unit = find_unit(str(unit_symbol))
    if unit is None:  # written by a program that knows more units
        return {"si_value": None, "si_unit": None}
    si_value = None if value is None else value * unit.factor + unit.offset
    return {"si_value": si_value, "si_unit": si_symbol(unit.dimension)}


def _badness(part: Row) -> int:
    verdict = part.get("verdict")
    return WORST_FIRST.index(verdict) if verdict in WORST_FIRST else len(WORST_FIRST)
