"""A limit of another torque than the one that is measured is refused before the run."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, edited, only_problem, place_of
from helpers_measurand import Hardness
from rigrunner.api.findings import ResultDefinition
from rigrunner.procedure.result_limits import Limit
from rigrunner_bearings.api.measurand import Condition, MeasurandKind, Nature
from unit.rigrunner_bearings.torque.helpers_planning import check

TOTAL = MeasurandKind(Nature.TOTAL, Condition.AT_REVERSAL)
NO_LOAD = ("nature: load_induced", "nature: no_load")


@pytest.mark.parametrize("with_plan", [True, False])
def test_a_limit_of_what_is_measured_is_accepted(with_plan):
    check(with_plan=with_plan)


def test_a_no_load_limit_is_refused_at_its_place_with_the_reason():
    problem = only_problem(lambda: check(NO_LOAD, with_plan=False))
    assert problem.field == "acceptance.limits[0].measurand"
    assert problem.message == (
        "the limit is for the no-load torque at the reversals of a swing, and the result is the "
        "load-induced torque at the reversals of a swing"
    )
    assert str(problem.location) == f"p.yaml:{place_of(edited(PROCEDURE, NO_LOAD), '{nature')}"


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


def test_the_hint_names_keys_of_the_procedure_s_own_analyses_alone():
    """Bearings are installed here, and play no part in a procedure of hardness."""
    limit = Limit.model_validate({"of": "h", "max": "3 V", "source": "x"})
    hardness = ResultDefinition(name="h", unit="V", measurand=Hardness("HRC"))
    message, hint = limit.objection_to(hardness, ["readings"])
    assert (message, hint) == ("'h' is the hardness HRC, and the key 'measurand' is missing", "")
    _, hint = limit.objection_to(hardness, ["swing_torque"])
    assert hint == "state it by the keys nature, condition"


def test_a_method_that_does_not_say_what_it_yields_has_no_limits():
    problem = only_problem(lambda: check(kind=None))
    assert problem.message == (
        "'torque' does not say whether it is the load-induced torque at the reversals of a swing"
    )


def test_a_limit_that_does_not_say_of_which_torque_it_is_is_told_how():
    problem = only_problem(
        lambda: check(("measurand: {nature: load_induced, condition: at_reversal}", ""))
    )
    assert problem.message == (
        "'torque' is the load-induced torque at the reversals of a swing, and the key 'measurand' "
        "is missing"
    )
    assert problem.hint == "state it by the keys nature, condition"


def test_an_unknown_method_is_left_to_the_check_of_plugins():
    check(NO_LOAD, ("- template", "- unknown"), ("primary: template", "primary: unknown"))


def test_a_named_frequency_must_be_recorded():
    named = ("mean: yes", "where: {frequency: [2 Hz, 9 Hz]}\n      each: frequency")
    problem = only_problem(lambda: check(named))
    assert problem.field == "acceptance.limits[0].where.frequency"
    assert (problem.message, problem.hint) == (
        "nothing is recorded at 9 Hz",
        "recorded: 2 Hz, 10 Hz",
    )
    check((named[0], named[1].replace("9 Hz", "10 Hz")))
