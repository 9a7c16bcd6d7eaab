"""The procedure's measurand, and the one analysis that gives it."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, STATION, Lookup, edited, only_problem, place_of
from rigrunner.plan import check_plugins
from rigrunner.procedure import parse_procedure
from rigrunner.station import parse_station

MEASURAND = "measurand: {symbol: Td, name: torque, unit: N·m}\n"


def checked(text):
    check_plugins(parse_procedure(text, "p.yaml"), parse_station(STATION, "s.yaml"), Lookup())


@pytest.mark.parametrize(
    "case",
    [
        ("unit: N·m}", "unit: N}", "N}", "measurand.unit",
         "'N' is a unit of force, not of torque", "units of torque: N·m"),
        (MEASURAND, "", "rigrunner: procedure/2", "measurand", "the key 'measurand' is missing",
         "the analysis of torque names it"),
        ("acceptance:\n", "  - swing_torque: {fits: [inertia]}\nacceptance:\n",
         "{fits", "analysis[1]", "'swing_torque' is a second analysis of torque",
         "a procedure has only one"),
    ],
)  # fmt: skip
def test_torque_analysis_needs_a_matching_measurand(case):
    old, new, finger, field, message, hint = case
    text = edited(PROCEDURE, (old, new))
    problem = only_problem(checked, text)
    assert (problem.message, problem.field) == (message, field)
    assert hint in problem.hint
    line = place_of(text, finger).split(":")[0]
    assert str(problem.location).startswith(f"p.yaml:{line}:")


def test_measurand_unit_is_optional():
    checked(edited(PROCEDURE, (", unit: N·m}", "}")))


def test_any_unit_is_accepted_without_a_torque_analysis():
    begin = PROCEDURE.index("analysis:\n")
    end = PROCEDURE.index("acceptance:\n")
    text = edited(PROCEDURE[:begin] + PROCEDURE[end:], ("unit: N·m}", "unit: N}"))
    checked(text)
