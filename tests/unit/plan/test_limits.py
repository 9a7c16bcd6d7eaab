"""A limit of another torque than the one that is measured is refused before the run."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, STATION, TESTER, edited, only_problem, place_of
from rigrunner.api.errors import PluginError
from rigrunner.api.measurand import Condition, MeasurandKind, Nature
from rigrunner.plan import check_limits, make_plan
from rigrunner.procedure import parse_procedure
from rigrunner.station import parse_station

STARTING = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)
TOTAL = MeasurandKind(Nature.TOTAL, Condition.AT_REVERSAL)
NO_LOAD = ("nature: load_induced", "nature: no_load")


class Lookup:
    def __init__(self, kind=STARTING):
        self.kind = kind

    def yields(self, compensation):
        if compensation != "template":
            raise PluginError(f"there is no compensation '{compensation}'")
        return self.kind


def check(*changes, kind=STARTING, planned=True):
    procedure = parse_procedure(edited(PROCEDURE, *changes), "p.yaml")
    plan = None
    if planned:
        plan = make_plan(procedure, parse_station(STATION, "s.yaml"), {"tester": TESTER})
    check_limits(procedure, plan, Lookup(kind))


@pytest.mark.parametrize("planned", [True, False])
def test_a_limit_of_what_is_measured_is_accepted(planned):
    check(planned=planned)


def test_a_no_load_limit_is_refused_at_its_place_with_the_reason():
    problem = only_problem(lambda: check(NO_LOAD))
    assert problem.field == "acceptance.limits[0].measurand"
    assert problem.message == (
        "the limit is for the no-load torque at the reversals of a swing, and the result is the "
        "load-induced torque at the reversals of a swing under 1000 N"
    )
    assert str(problem.location) == f"p.yaml:{place_of(edited(PROCEDURE, NO_LOAD), '{nature')}"


def test_it_is_refused_without_a_station_too():
    problem = only_problem(lambda: check(NO_LOAD, planned=False))
    assert problem.message.endswith("load-induced torque at the reversals of a swing")


def test_a_total_torque_is_the_no_load_torque_where_nothing_is_loaded():
    unloaded = ("load: 1000 N", "load: 0 N")
    check(NO_LOAD, unloaded, kind=TOTAL)
    problem = only_problem(lambda: check(NO_LOAD, kind=TOTAL))
    assert "the result is the total torque at the reversals of a swing under 1000 N" in (
        problem.message
    )


def test_another_load_is_refused():
    problem = only_problem(
        lambda: check(("condition: at_reversal}", "condition: at_reversal, load: 500 N}"))
    )
    assert "under 500 N, and the result is" in problem.message


def test_another_condition_is_refused():
    problem = only_problem(lambda: check(("condition: at_reversal", "condition: from_rest")))
    assert "the limit is for the load-induced torque from rest" in problem.message


def test_a_method_that_does_not_say_what_it_yields_has_no_limits():
    problem = only_problem(lambda: check(kind=None))
    assert problem.message == "'template' does not say which torque it yields"


def test_an_unknown_method_is_left_to_the_check_of_plugins():
    check(NO_LOAD, ("primary: template", "primary: energy"))


def test_a_named_frequency_must_be_recorded():
    named = ("mean: yes", "where: {frequency: [2 Hz, 9 Hz]}\n      each: frequency")
    problem = only_problem(lambda: check(named))
    assert problem.field == "acceptance.limits[0].where.frequency"
    assert (problem.message, problem.hint) == (
        "nothing is recorded at 9 Hz",
        "recorded: 2 Hz, 10 Hz",
    )
    check((named[0], named[1].replace("9 Hz", "10 Hz")))
