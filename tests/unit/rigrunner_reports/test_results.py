"""The budgets in the section of results."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rigrunner.api import Component, Estimate, MeasurementResult, ResultDefinition
from rigrunner_reports.numbers import MINUS, TIMES
from rigrunner_reports.view.results import result_views


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
