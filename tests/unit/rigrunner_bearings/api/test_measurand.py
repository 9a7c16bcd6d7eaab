"""Which torque a limit is for: read from a procedure, held against what was measured, written."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers_language import PROCEDURE, edited, place_of, problems_of
from helpers_measurand import Hardness
from rigrunner.analysis.verdict.document import decision as decision_document
from rigrunner.api.verdict import Decision, LimitDecision, Limits, Verdict
from rigrunner.certificate.results import conformity_of
from rigrunner.procedure import Acceptance, parse_procedure
from rigrunner_bearings.api.measurand import Condition, LimitMeasurand, MeasurandKind, Nature
from rigrunner_bearings.api.torque import TorqueDetails

AT_REVERSAL = {"nature": "load_induced", "condition": "at_reversal"}
STARTING = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)
TOTAL = MeasurandKind(Nature.TOTAL, Condition.FROM_REST)
BREAKAWAY = LimitMeasurand(nature="no_load", condition="from_rest")


@pytest.mark.parametrize(
    "case",
    [
        ("nature: load_induced", "nature: loaded", "loaded", ".nature",
         "got 'loaded', expected 'load_induced', 'total' or 'no_load'", ""),
        ("nature: load_induced, ", "", "measurand: {c", ".nature",
         "the key 'nature' is missing", ""),
        ("nature: load", "natur: load", "natur:", ".natur", "unknown key 'natur'",
         "did you mean 'nature'? known keys: nature, condition, load"),
        ("at_reversal}", "at_reversal, load: 1000}", "1000}\n", ".load",
         "1000 is not a number with a unit", "write it as '1000 N'"),
        ("{nature: load_induced, condition: at_reversal}", "starting", "starting", "",
         "got 'starting', expected a mapping of names to values", ""),
    ],
)  # fmt: skip
def test_a_spoiled_key_is_refused_at_its_place(case):
    old, new, finger, field, message, hint = case
    text = edited(PROCEDURE, (old, new))
    at = f"acceptance.limits[0].measurand{field}"
    (problem,) = (
        problem for problem in problems_of(parse_procedure, text, "p.yaml") if problem.field == at
    )
    assert message in problem.message
    assert hint in problem.hint
    assert str(problem.location) == f"p.yaml:{place_of(text, finger)}"


def test_every_other_nature_and_condition_is_another_torque():
    for nature in Nature:
        for condition in Condition:
            measurand = LimitMeasurand(nature=str(nature), condition=str(condition))
            same = measurand.kind == STARTING
            assert (measurand.objection(STARTING, [1000.0]) == "") is same


def test_what_is_no_torque_at_all_is_another_quantity():
    assert BREAKAWAY.objection(Hardness("HRC")) == (
        "the limit is for the no-load torque from rest, and the result is the hardness HRC"
    )


@given(st.sampled_from(Nature), st.sampled_from(Condition), st.none() | st.floats(0.1, 1e5))
def test_it_reads_back_as_it_was_written(nature, condition, load):
    stated = LimitMeasurand(
        nature=str(nature), condition=str(condition), load=None if load is None else f"{load!r} N"
    )
    limit = {"of": "torque", "mean": True, "max": "1 N·m", "source": "a test"}
    accepted = Acceptance.model_validate({"limits": [limit | {"measurand": stated.as_written()}]})
    assert accepted.limits[0].measurand == stated


def details(kind, *loads):
    return TorqueDetails(
        primary="template_inverse",
        kind=kind,
        loaded=tuple(SimpleNamespace(load_n=load_n) for load_n in loads),
    )


def test_a_total_torque_without_load_is_the_no_load_torque():
    assert details(TOTAL, 0.0, 2.0).objection(BREAKAWAY) == ""
    assert details(TOTAL, 0.0, 500.0).objection(BREAKAWAY) == (
        "The limit is for the no-load torque from rest, and the result is the total torque from "
        "rest under 0 N to 500 N: conformity cannot be stated."
    )


def test_a_limit_at_one_load_says_nothing_of_another():
    at_load = LimitMeasurand(**AT_REVERSAL, load="1000 N")
    assert details(STARTING, 1009.0, 992.0).objection(at_load) == ""
    assert "under 1000 N, and the result is" in details(STARTING, 1009.0, 985.0).objection(at_load)


def test_what_is_not_known_of_limit_or_result_is_said():
    assert details(STARTING, 1000.0).objection(None) == (
        "The limit does not say of which torque it is: it needs a 'measurand'."
    )
    assert (
        details(None, 1000.0)
        .objection(BREAKAWAY)
        .startswith("template_inverse does not say which torque it yields")
    )


def decided(**load):
    part = LimitDecision(
        verdict=Verdict.PASS,
        reason="a test",
        limits=Limits.between(None, 0.95),
        source="a test",
        measurand=LimitMeasurand(**AT_REVERSAL, **load),
    )
    return Decision(rule="simple: a test", parts=(part,))


def test_documents_have_the_load_beside_the_words():
    words = "load-induced torque at the reversals of a swing"
    assert decision_document(decided(load="1 kN"))["measurand"] == {
        **AT_REVERSAL,
        "load": {"value": 1000.0, "unit": "N"},
        "text": words,
    }
    assert decision_document(decided())["measurand"] == {**AT_REVERSAL, "load": None, "text": words}
    (stated,) = conformity_of(decided(load="1 kN"), ()).statements
    assert (stated.measurand, stated.load_n) == (words, 1000.0)
    (stated,) = conformity_of(decided(), ()).statements
    assert (stated.measurand, stated.load_n) == (words, None)


def test_plugins_made_by_the_first_version_still_find_the_load():
    with pytest.warns(DeprecationWarning, match="import load_of from"):
        assert decided(load="1 kN").parts[0].load_n == 1000.0
    with pytest.warns(DeprecationWarning, match="import load_of from"):
        assert decided().parts[0].load_n is None
