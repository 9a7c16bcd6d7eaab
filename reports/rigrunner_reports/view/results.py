"""The named results of analyses by their coordinates, with their limits, ready to print."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import isinf, isnan
from typing import TYPE_CHECKING

from rigrunner.api import find_unit
from rigrunner.api.quantity import usual_and_prefixed
from rigrunner.signal.uncertainty import share_percent
from rigrunner_reports.mathematics import equation
from rigrunner_reports.numbers import TIMES, fixed, significant, stated
from rigrunner_reports.section import Section
from rigrunner_reports.view.decision import LimitView

if TYPE_CHECKING:
    from collections.abc import Sequence

    from markupsafe import Markup

    from rigrunner.api import Component, MeasurementResult, ResultDefinition
    from rigrunner.api.findings import MissingResult, Table
    from rigrunner.api.results import Result
    from rigrunner.api.unit_tables import Unit
    from rigrunner.api.verdict import LimitDecision
    from rigrunner_reports.numbers import Stated

TABLE_DIGITS = 8
"""Most significant digits in a table; result.json has all."""
MOST_DIGITS = 12
"""Those of a number that has no more of them."""
_TRAILING_ZEROS = re.compile(r"(?:(\.\d*[1-9])|\.)0+(?!\d)")
MOST_ROWS = 200
"""The most results of one name, those out of limits first; result.json has all."""


@dataclass(frozen=True)
class ResultRow:
    """One result, with its own limit; without a value, a place where there is none."""

    coordinates: tuple[str, ...]
    shown: Stated | None
    readings: int | None
    limit: LimitView | None


@dataclass(frozen=True)
class BudgetLine:
    """A line of an uncertainty budget."""

    name: str
    distribution: str
    dof: str
    u: str
    unit: str
    sensitivity: str
    contribution: str
    share: str


@dataclass(frozen=True)
class BudgetView:
    """The budget of one result."""

    of: str
    lines: tuple[BudgetLine, ...]
    u: str
    dof: str


@dataclass(frozen=True)
class TableView:
    """A table of a result."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    of_texts: tuple[bool, ...]
    """For each column, whether it holds text only."""


@dataclass(frozen=True)
class ResultView:
    """All results of one name."""

    name: str
    text: str
    symbol: str
    unit: str
    coordinates: tuple[str, ...]
    rows: tuple[ResultRow, ...]
    left_out: int
    limits: tuple[LimitView, ...]
    """Limits of their mean, or of the worst of them."""
    budget: BudgetView | None
    formulas: tuple[Markup, ...]
    """The equations of the results, as MathML."""
    tables: tuple[TableView, ...]


def result_views(result: Result) -> tuple[ResultView, ...]:
    """Return the results by name, in the order of the procedure."""
    every = (*result.other_results, *result.missing)
    return tuple(_view(result, item.of) for item in {item.name: item for item in every}.values())


def _view(result: Result, definition: ResultDefinition) -> ResultView:
    results = [named for named in result.other_results if named.name == definition.name]
    missing = [item for item in result.missing if item.name == definition.name]
    parts = [
        part
        for part in (result.decision.parts if result.decision else ())
        if part.named == definition.name
    ]
    part_of = {id(part.result): part for part in parts if part.result is not None}
    rows = [
        _row(named, part_of.get(id(named.estimate)), stated(named.estimate), named.readings)
        for named in results
    ]
    rows += [
        _row(item, next((part for part in parts if _has_row(part, [item])), None))
        for item in missing
    ]
    if len(rows) > MOST_ROWS:
        rows.sort(key=lambda row: row.limit is None or row.limit.decision.passes)
    judged = {id(named.estimate) for named in results}
    worst = min(parts, key=lambda part: part.badness, default=None)
    first = results[0] if results else None
    budgeted = next((named for named in results if worst and named.estimate is worst.result), first)
    return ResultView(
        name=definition.name,
        text=definition.words,
        symbol=definition.symbol,
        unit=definition.unit,
        coordinates=definition.per,
        rows=tuple(rows[:MOST_ROWS]),
        left_out=max(0, len(rows) - MOST_ROWS),
        limits=tuple(
            LimitView(part)
            for part in parts
            if not (id(part.result) in judged or _has_row(part, missing))
            or part.of.startswith("worst ")
        ),
        budget=None if budgeted is None else _budget(budgeted),
        formulas=tuple(map(equation, (f for f in result.formulas if f.of == definition.name))),
        tables=tuple(table_view(table) for table in result.tables if table.of == definition.name),
    )


def table_view(table: Table) -> TableView:
    """Return a table, ready to print."""
    return TableView(
        title=table.title,
        columns=table.columns,
        rows=tuple(tuple(map(_cell, row)) for row in table.rows),
        of_texts=tuple(
            all(isinstance(row[place], str) for row in table.rows)
            for place in range(len(table.columns))
        ),
    )


def _cell(value: float | str) -> str:
    if isinstance(value, str):
        return value
    # A rounded number stays as it is, such as 10000001.24 Hz with u = 0.35 Hz.
    digits = MOST_DIGITS if float(f"{value:.{MOST_DIGITS - 1}e}") == value else TABLE_DIGITS
    return _TRAILING_ZEROS.sub(r"\1", significant(value, digits))


def _row(
    item: MeasurementResult | MissingResult,
    part: LimitDecision | None,
    shown: Stated | None = None,
    readings: int | None = None,
) -> ResultRow:
    coordinates = tuple(map(str, item.coordinates.values()))
    return ResultRow(coordinates, shown, readings, None if part is None else LimitView(part))


def _has_row(part: LimitDecision, missing: Sequence[MissingResult]) -> bool:
    """Return whether a limit is for one of the places without a value."""
    places = [item.coordinates for item in missing]
    return part.result is None and bool(part.coordinates) and part.coordinates in places


def _budget(named: MeasurementResult) -> BudgetView | None:
    if not named.components:
        return None
    shares = share_percent(named.components)
    lines = tuple(
        _line(component, share, named.of.unit)
        for component, share in zip(named.components, shares, strict=True)
    )
    dof = named.estimate.dof
    return BudgetView(
        of=named.place,
        lines=lines,
        u=significant(named.estimate.u, 3),
        dof="∞" if isinf(dof) else "unknown" if isnan(dof) else significant(dof, 3),
    )


def _line(component: Component, share: float, result_unit: str) -> BudgetLine:
    unit, ratio = _unit_of_line(component, result_unit)
    return BudgetLine(
        name=component.name,
        distribution=component.distribution,
        dof="∞" if isinf(component.dof) else significant(component.dof, 3),
        u=significant(component.input_u * ratio, 3),
        unit=unit,
        sensitivity=significant(component.sensitivity / ratio, 3),
        contribution=significant(component.u, 3),
        share="" if isnan(share) else f"{fixed(share, 1)} %",
    )


def _unit_of_line(component: Component, result_unit: str) -> tuple[str, float]:
    """Return the unit in which the input of a line is shown, and by what its numbers multiply.

    The result's unit for an input of its kind; else one in which u and sensitivity need few powers
    of ten.
    """
    input_unit, output_unit = find_unit(component.unit), find_unit(result_unit)
    if input_unit is None or output_unit is None:  # of a plugin that states no unit
        return component.unit, 1.0

    def powers(unit: Unit) -> int:
        ratio = input_unit.factor / unit.factor
        numbers = (component.input_u * ratio, component.sensitivity / ratio)
        return sum(TIMES in significant(number, 3) for number in numbers)

    units = [input_unit, *usual_and_prefixed(input_unit.symbol)]
    if input_unit.dimension == output_unit.dimension:
        units = [output_unit]
    best = min((unit for unit in units if not unit.offset), key=powers, default=input_unit)
    return best.symbol, input_unit.factor / best.factor


SECTIONS = (
    Section("results", "Results", 5, lambda report, _: result_views(report.result), unbroken=True),
)
