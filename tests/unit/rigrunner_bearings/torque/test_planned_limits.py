"""A limit for another torque than the measured one is refused before the run."""

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
def test_limit_for_measured_torque_is_accepted(with_plan):
    check(with_plan=with_plan)


def test_no_load_limit_is_refused_with_location_and_reason():
    problem = only_problem(lambda: check(NO_LOAD, with_plan=False))
    assert problem.field == "acceptance.limits[0].measurand"
    assert problem.message == (
        "the limit is for the no-load torque at the reversals of a swing, and the result is the "
        "load-induced torque at the reversals of a swing"
    )
    assert str(problem.location) == f"p.yaml:{place_of(edited(PROCEDURE, NO_LOAD), '{nature')}"


def test_total_torque_without_load_counts_as_no_load_torque():
    unloaded = ("load: 1000 N", "load: 0 N")
    check(NO_LOAD, unloaded, kind=TOTAL)
    problem = only_problem(lambda: check(NO_LOAD, kind=TOTAL))
    assert "the result is the total torque at the reversals of a swing under 1000 N" in (
        problem.message
    )


def test_limit_at_another_load_is_refused():
    problem = only_problem(
        lambda: check(("condition: at_reversal}", "condition: at_reversal, load: 500 N}"))
    )
    assert "under 500 N, and the result is" in problem.message


def test_limit_for_another_condition_is_refused():
    problem = only_problem(lambda: check(("condition: at_reversal", "condition: from_rest")))
    assert "the limit is for the load-induced torque from rest" in problem.message


def test_hint_names_only_keys_of_used_analyses():
    """The bearings plugin is installed but not used by a procedure of hardness."""
    limit = Limit.model_validate({"of": "h", "max": "3 V", "source": "x"})
    hardness = ResultDefinition(name="h", unit="V", measurand=Hardness("HRC"))
    message, hint = limit.objection_to(hardness, ["readings"])
    assert (message, hint) == ("'h' is the hardness HRC, and the key 'measurand' is missing", "")
    _, hint = limit.objection_to(hardness, ["swing_torque"])
    assert hint == "state it by the keys nature, condition"


def test_method_without_stated_measurand_cannot_have_limits():
    problem = only_problem(lambda: check(kind=None))
    assert problem.message == (
        "'torque' does not say whether it is the load-induced torque at the reversals of a swing"
    )


def test_missing_measurand_is_refused_with_its_keys():
    problem = only_problem(
        lambda: check(("measurand: {nature: load_induced, condition: at_reversal}", ""))
    )
    assert problem.message == (
        "'torque' is the load-induced torque at the reversals of a swing, and the key 'measurand' "
        "is missing"
    )
    assert problem.hint == "state it by the keys nature, condition"


def test_unknown_method_is_left_to_plugin_check():
    check(NO_LOAD, ("- template", "- unknown"), ("primary: template", "primary: unknown"))


def test_selected_frequency_must_be_recorded():
    selection = ("mean: yes", "where: {frequency: [2 Hz, 9 Hz]}\n      each: frequency")
    problem = only_problem(lambda: check(selection))
    assert problem.field == "acceptance.limits[0].where.frequency"
    assert (problem.message, problem.hint) == (
        "nothing is recorded at 9 Hz",
        "recorded: 2 Hz, 10 Hz",
    )
    check((selection[0], selection[1].replace("9 Hz", "10 Hz")))
