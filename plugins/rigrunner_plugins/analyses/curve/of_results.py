"""The points of a curve that are results of other analyses."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Component, DataError, MeasurementResult, unit
from rigrunner.api.places import is_at
from rigrunner.api.units import si_symbol
from rigrunner_plugins.analyses.curve.points import Source, Values, origin_of
from rigrunner_plugins.analyses.curve.shared_lines import shared_lines
from rigrunner_plugins.analyses.settings import unit_of_errors

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Array, RunData
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.findings import ResultPlace
    from rigrunner_plugins.analyses.curve.settings import CurveSettings


_Point = tuple[MeasurementResult, *tuple[MeasurementResult | None, ...]]
"""The result that is y, and those that are x; None for an x that is a set-point of y."""


def sources_of_results(
    run: RunData, settings: CurveSettings, known: Sequence[ResultPlace]
) -> Iterator[Source]:
    """Yield the points of each curve; raise DataError if there are none.

    `known` are the results of other analyses, also those without a value somewhere.
    """
    at = {(each.name, _key(each)): each for each in known}
    groups: dict[tuple[CoordinateValue, ...], list[_Point]] = {}
    missing: dict[tuple[CoordinateValue, ...], list[str]] = {}
    for y in known:
        if y.name != settings.of or not is_at(settings.where, y.coordinates):
            continue
        here = tuple(y.coordinates[name].usual for name in settings.per)
        x = {name: at.get((name, _key(y))) for name in settings.x_results}
        valued = {n: each for n, each in x.items() if isinstance(each, MeasurementResult)}
        if isinstance(y, MeasurementResult) and len(valued) == len(x):
            groups.setdefault(here, []).append((y, *map(valued.get, settings.over.values())))
        else:
            missing.setdefault(here, []).append(y.place)
    if not groups:
        where = ", ".join(f"{name} = {value}" for name, value in settings.where.items())
        raise DataError(
            f"there is no value of {' and '.join((settings.of, *settings.x_results))}"
            f"{f' at {where}' if where else ''}",
            hint="the curve needs them at the same places",
        )
    for here, points in groups.items():
        yield _source(run, settings, points, tuple(missing.get(here, ())))


def _key(of: ResultPlace) -> frozenset[tuple[str, CoordinateValue]]:
    return frozenset((name, each.usual) for name, each in of.coordinates.items())


def _source(
    run: RunData, settings: CurveSettings, points: Sequence[_Point], left_out: tuple[str, ...]
) -> Source:
    first, names = points[0], tuple(settings.over.values())
    shown = [
        first[0].coordinates[name].unit or "1" if x is None else x.of.unit
        for name, x in zip(names, first[1:], strict=True)
    ]
    columns = [[_x(each, column, name) for each in points] for column, name in enumerate(names, 1)]
    x, stated = np.array(columns, np.float64).T, first[0].of.unit
    units = tuple(si_symbol(unit(symbol).dimension) for symbol in shown)
    origin = origin_of(settings, units)
    lines, own, dof, own_x = shared_lines(
        [
            [*_of_result(each[0]), *_of_x(run, each[1:], names, units, row)]
            for each, row in zip(points, x, strict=True)
        ]
    )
    values = Values(
        x - origin,
        np.array([_si(each[0].estimate.value, stated) for each in points]),
        own if (own > 0).all() else None,
        dof,
        np.array([each.y.si for each in settings.results.x_at if each.y is not None]),
        origin,
        tuple(settings.over),
        units,
        si_symbol(unit(stated).dimension),
        settings.of,
        tuple(shown),
        stated,
        is_set=not settings.x_results,
        u_x=own_x if len(names) == 1 else None,
    )
    return Source(
        place={name: first[0].coordinates[name] for name in settings.per},
        values=values,
        places=tuple(each[0].coordinates for each in points),
        counts=(0,) * len(values.asked),
        errors={},
        of_zeros=(),
        exact=tuple(name for name in names if "." in name and name not in run.instruments),
        lines=lines,
        left_out=left_out,
    )


def _x(point: _Point, column: int, name: str) -> float:
    """Return an x in its SI unit; raise DataError for a set-point that is a text."""
    x, set_point = point[column], point[0].coordinates.get(name)
    if x is not None:
        return _si(x.estimate.value, x.of.unit)
    if set_point is None or isinstance(set_point.value, str):
        raise DataError(f"'{name}' is no set-point of {point[0].name} that is a number")
    return _si(set_point.value, set_point.unit or "1")


def _si(value: float, symbol: str) -> float:
    known = unit(symbol)
    return value * known.factor + known.offset


def _of_x(
    run: RunData,
    x: Sequence[MeasurementResult | None],
    names: Sequence[str],
    units: Sequence[str],
    si: Array,
) -> Iterator[Sequence[Component]]:
    """Yield the budget of each x in SI; of a set-point, the errors that the register states."""
    for result, name, symbol, value in zip(x, names, units, si.tolist(), strict=True):
        if result is not None:
            yield from _of_result(result)
        elif name in run.instruments:
            yield [
                Component(
                    f"{error.name} ({error.source})" if error.source else error.name,
                    error.at(value), error.dof, error.distribution, common=True, value=0.0,
                    unit="1" if error.acts == "gain" else unit_of_errors(symbol),
                    input_u=error.u, sensitivity=value if error.acts == "gain" else 1.0,
                    shared=error.acts != "each",
                )
                for error in run.reading_errors(name, abs(value))
            ]  # fmt: skip
        else:
            yield ()


def _of_result(result: MeasurementResult) -> Iterator[Sequence[Component]]:
    factor = unit(result.of.unit).factor
    yield [replace(line, u=line.u * factor) for line in result.components]
