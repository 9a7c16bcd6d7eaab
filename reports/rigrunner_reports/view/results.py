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
    return tuple(_view(result, each.of) for each in {each.name: each for each in every}.values())


def _view(result: Result, definition: ResultDefinition) -> ResultView:
    found = [each for each in result.other_results if each.name == definition.name]
    missing = [each for each in result.missing if each.name == definition.name]
    parts = [
        part
        for part in (result.decision.parts if result.decision else ())
        if part.named == definition.name
    ]
    own = {id(part.result): part for part in parts if part.result is not None}
    rows = [
        _row(each, own.get(id(each.estimate)), stated(each.estimate), each.readings)
        for each in found
    ]
    rows += [
        _row(each, next((part for part in parts if _has_row(part, [each])), None))
        for each in missing
    ]
    if len(rows) > MOST_ROWS:
        rows.sort(key=lambda row: row.limit is None or row.limit.found.passes)
    judged = {id(each.estimate) for each in found}
    worst = min(parts, key=lambda part: part.badness, default=None)
    first = found[0] if found else None
    budgeted = next((e for e in found if worst and e.estimate is worst.result), first)
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
        formulas=tuple(equation(each) for each in result.formulas if each.of == definition.name),
        tables=tuple(table_view(each) for each in result.tables if each.of == definition.name),
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
    return _TRAILING_ZEROS.sub(r"\1", significant(value, TABLE_DIGITS))


def _row(
    at: MeasurementResult | MissingResult,
    part: LimitDecision | None,
    shown: Stated | None = None,
    readings: int | None = None,
) -> ResultRow:
    coordinates = tuple(map(str, at.coordinates.values()))
    return ResultRow(coordinates, shown, readings, None if part is None else LimitView(part))


def _has_row(part: LimitDecision, missing: Sequence[MissingResult]) -> bool:
    """Return whether a limit is for one of the places without a value."""
    at = part.coordinates
    return part.result is None and bool(at) and any(at == each.coordinates for each in missing)


def _budget(found: MeasurementResult) -> BudgetView | None:
    if not found.components:
        return None
    shares = share_percent(found.components)
    lines = tuple(
        _line(each, share, found.of.unit)
        for each, share in zip(found.components, shares, strict=True)
    )
    dof = found.estimate.dof
    return BudgetView(
        of=found.place,
        lines=lines,
        u=significant(found.estimate.u, 3),
        dof="∞" if isinf(dof) else "unknown" if isnan(dof) else significant(dof, 3),
    )


def _line(found: Component, share: float, result_unit: str) -> BudgetLine:
    shown, ratio = _unit_of_line(found, result_unit)
    return BudgetLine(
        name=found.name,
        distribution=found.distribution,
        dof="∞" if isinf(found.dof) else significant(found.dof, 3),
        u=significant(found.input_u * ratio, 3),
        unit=shown,
        sensitivity=significant(found.sensitivity / ratio, 3),
        contribution=significant(found.u, 3),
        share="" if isnan(share) else f"{fixed(share, 1)} %",
    )


def _unit_of_line(found: Component, result_unit: str) -> tuple[str, float]:
    """Return the unit in which the input of a line is shown, and by what its numbers multiply.

    The result's unit for an input of its kind; else one in which u and sensitivity need few powers
    of ten.
    """
    given, of_result = find_unit(found.unit), find_unit(result_unit)
    if given is None or of_result is None:  # of a plugin that states no unit
        return found.unit, 1.0

    def powers(shown: Unit) -> int:
        ratio = given.factor / shown.factor
        numbers = (found.input_u * ratio, found.sensitivity / ratio)
        return sum(TIMES in significant(each, 3) for each in numbers)

    units = [given, *usual_and_prefixed(given.symbol)]
    if given.dimension == of_result.dimension:
        units = [of_result]
    best = min((each for each in units if not each.offset), key=powers, default=given)
    return best.symbol, given.factor / best.factor


SECTIONS = (
    Section("results", "Results", 5, lambda report, _: result_views(report.result), unbroken=True),
)
