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
from rigrunner_plugins.analyses.sources import error_line, line_name

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Array, RunData
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.findings import ResultPlace
    from rigrunner_plugins.analyses.curve.settings import CurveSettings


_Point = tuple[MeasurementResult, *tuple[MeasurementResult | None, ...]]
"""The result that is y, and those that are x; None for an x that is a set-point of y."""


def sources_of_results(
    run: RunData, settings: CurveSettings, results: Sequence[ResultPlace]
) -> Iterator[Source]:
    """Yield the points of each curve; raise DataError if there are none.

    `results` are the results of other analyses, also those without a value somewhere.
    """
    result_at = {(result.name, _key(result)): result for result in results}
    groups: dict[tuple[CoordinateValue, ...], list[_Point]] = {}
    missing: dict[tuple[CoordinateValue, ...], list[str]] = {}
    for y in results:
        if y.name != settings.of or not is_at(settings.where, y.coordinates):
            continue
        place = tuple(y.coordinates[name].usual for name in settings.per)
        x = {name: result_at.get((name, _key(y))) for name in settings.x_results}
        x_values = {
            name: result for name, result in x.items() if isinstance(result, MeasurementResult)
        }
        if isinstance(y, MeasurementResult) and len(x_values) == len(x):
            groups.setdefault(place, []).append((y, *map(x_values.get, settings.over.values())))
        else:
            missing.setdefault(place, []).append(y.place)
    if not groups:
        where = ", ".join(f"{name} = {value}" for name, value in settings.where.items())
        raise DataError(
            f"there is no value of {' and '.join((settings.of, *settings.x_results))}"
            f"{f' at {where}' if where else ''}",
            hint="the curve needs them at the same places",
        )
    for place, points in groups.items():
        yield _source(run, settings, points, tuple(missing.get(place, ())))


def _key(result: ResultPlace) -> frozenset[tuple[str, CoordinateValue]]:
    return frozenset((name, coordinate.usual) for name, coordinate in result.coordinates.items())


def _source(
    run: RunData, settings: CurveSettings, points: Sequence[_Point], left_out: tuple[str, ...]
) -> Source:
    first, names = points[0], tuple(settings.over.values())
    symbols = [
        first[0].coordinates[name].unit or "1" if x is None else x.of.unit
        for name, x in zip(names, first[1:], strict=True)
    ]
    columns = [[_x(point, i, name) for point in points] for i, name in enumerate(names, 1)]
    x, y_unit = np.array(columns, np.float64).T, first[0].of.unit
    units = tuple(si_symbol(unit(symbol).dimension) for symbol in symbols)
    origin = origin_of(settings, units)
    lines, u_y, dof, u_x = shared_lines(
        [
            [*_of_result(point[0]), *_of_x(run, point[1:], names, units, row)]
            for point, row in zip(points, x, strict=True)
        ]
    )
    values = Values(
        x - origin,
        np.array([_si(point[0].estimate.value, y_unit) for point in points]),
        u_y if (u_y > 0).all() else None,
        dof,
        np.array([result.y.si for result in settings.results.x_at if result.y is not None]),
        origin,
        tuple(settings.over),
        units,
        si_symbol(unit(y_unit).dimension),
        settings.of,
        tuple(symbols),
        y_unit,
        is_set=not settings.x_results,
        u_x=u_x if len(names) == 1 else None,
    )
    return Source(
        place={name: first[0].coordinates[name] for name in settings.per},
        values=values,
        places=tuple(point[0].coordinates for point in points),
        counts=(0,) * len(values.requested_y),
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
    unit_ = unit(symbol)
    return value * unit_.factor + unit_.offset


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
                error_line(error, line_name(error), value if error.acts == "gain" else 1.0, symbol)
                for error in run.reading_errors(name, abs(value))
            ]
        else:
            yield ()


def _of_result(result: MeasurementResult) -> Iterator[Sequence[Component]]:
    factor = unit(result.of.unit).factor
    yield [replace(line, u=line.u * factor) for line in result.components]
