"""The budgets in the section of results."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rigrunner.api import Component, Estimate, MeasurementResult, ResultDefinition
from rigrunner.api.findings import Table
from rigrunner_reports.numbers import MINUS, TIMES
from rigrunner_reports.view.results import result_views, table_view


def budget_of(unit, *lines):
    """Return (u, unit, sensitivity, contribution) of each line of a result's budget."""
    measurement = MeasurementResult(
        of=ResultDefinition(name="volume", unit=unit),
        estimate=Estimate(9.992, 0.003, unit=unit),
        components=tuple(
            Component("x", u=abs(c * u), dof=9.0, distribution="t", common=True, unit=input_unit,
                      input_u=u, sensitivity=c)
            for u, input_unit, c in lines
        ),
    )  # fmt: skip
    result = SimpleNamespace(
        other_results=(measurement,), missing=(), decision=None, formulas=(), tables=()
    )
    (view,) = result_views(result)
    return [
        tuple(text.replace(TIMES, "x").replace(MINUS, "-") for text in texts)
        for line in view.budget.lines
        for texts in [(line.u, line.unit, line.sensitivity, line.contribution)]
    ]


@pytest.mark.parametrize(
    ("unit", "line", "shown"),
    [
        ("mL", (2.5e-9, "m³", 1e6), ("2.50 x 10⁻³", "mL", "1.00", "2.50 x 10⁻³")),
        ("g/mL", (1.15e-8, "m³", -9.98e4), ("0.0115", "mL", "-0.0998", "1.15 x 10⁻³")),
        ("mL", (5.77e-7, "kg", 1002.0), ("5.77 x 10⁻⁷", "kg", "1002", "5.78 x 10⁻⁴")),
        ("°C", (0.05, "K", 1.0), ("0.0500", "K", "1.00", "0.0500")),
        ("V/W", (2e-6, "widgets", 2.0), ("2.00 x 10⁻⁶", "widgets", "2.00", "4.00 x 10⁻⁶")),
    ],
)
def test_budget_input_has_unit_of_the_result_or_a_readable_one(unit, line, shown):
    assert budget_of(unit, line) == [shown]


@pytest.mark.parametrize(
    ("number", "shown"),
    [
        (10000001.24, "1.000000124 x 10⁷"),  # rounded by its u of 0.353 Hz
        (1 / 30, "0.033333333"),
        (0.1 + 0.2, "0.3"),
        (50000.000838, "50000.000838"),
    ],
)
def test_rounded_number_of_a_table_keeps_its_digits(number, shown):
    view = table_view(Table(of="y", title="", columns=("",), rows=((number,),)))
    assert view.rows[0][0].replace(TIMES, "x") == shown
