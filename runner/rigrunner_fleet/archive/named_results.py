"""The named results of a run, as rows of an archive: values, coordinates, verdict."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.coordinates import place_text
from rigrunner.api.units import find_unit, si_symbol
from rigrunner.api.verdict import WORST_FIRST
from rigrunner.run.set_points import coordinates_in, named_place
from rigrunner_fleet.archive.documents import at, degrees_of_freedom, key, number, rows, text, whole

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner_fleet.archive.result_facts import Row


def named_results(document: object, decision: object) -> list[Row]:
    """Return a row for each named result, in the unit in which it is stated.

    `decision`: the one in force; its limits on single results are shown with them.
    """
    judged: dict[str, list[Row]] = {}
    for part in rows(at(decision, "parts")):
        if coordinates_in(part):
            of = named_place({"name": part.get("named"), "coordinates": part["coordinates"]})
        else:  # older documents have only a text
            of = str(part.get("of")).removeprefix("worst ")
        judged.setdefault(of, []).append(part)
    return [_result(order, each, judged) for order, each in _numbered(document)]


def coordinates(document: object) -> list[Row]:
    """Return a row for each coordinate of each named result, in units that make runs comparable."""
    found = []
    for order, each in _numbered(document):
        for name, as_written in coordinates_in(each).items():
            usual = as_written.usual
            is_number = not isinstance(usual.value, str)
            row = {
                "number": order,
                "name": key(name),
                "short": key(name.rpartition(".")[2]),
                "value": number(usual.value),
                "unit": text(usual.unit) if is_number else None,
                "text": text(str(usual)),
            }
            found.append(row)
    return found


def _numbered(document: object) -> Iterator[tuple[int, Row]]:
    return enumerate(rows(at(document, "results")), 1)


def _result(order: int, each: Row, judged: dict[str, list[Row]]) -> Row:
    found = at(each, "estimate")
    value, symbol = number(at(found, "value")), at(found, "unit")
    parts = judged.get(named_place(each), ())
    lower = [number(at(part, "lower_limit", "value")) for part in parts]
    upper = [number(at(part, "upper_limit", "value")) for part in parts]
    return {
        "number": order,
        "name": key(each.get("name")),
        "symbol": text(each.get("symbol")),
        "measurand": text(each.get("text")),
        "place": text(place_text({n: at.usual for n, at in coordinates_in(each).items()})),
        "value": value,
        "u": number(at(found, "standard_uncertainty")),
        "expanded": number(at(found, "expanded_uncertainty_95")),
        "dof": degrees_of_freedom(at(found, "degrees_of_freedom")),
        "unit": text(symbol),
        "readings": whole(each.get("readings")),
        # A result may have several limits: a minimum of a standard, a maximum of a drawing.
        "lower": max((each for each in lower if each is not None), default=None),
        "upper": min((each for each in upper if each is not None), default=None),
        "verdict": text(at(min(parts, key=_badness, default=None), "verdict")),
        **_si(value, symbol),
    }


def _si(value: float | None, symbol: object) -> Row:
    known = find_unit(str(symbol))
    if known is None:  # written by a program that knows more units
        return {"si_value": None, "si_unit": None}
    si_value = None if value is None else value * known.factor + known.offset
    return {"si_value": si_value, "si_unit": si_symbol(known.dimension)}


def _badness(part: Row) -> int:
    verdict = part.get("verdict")
    return WORST_FIRST.index(verdict) if verdict in WORST_FIRST else len(WORST_FIRST)
