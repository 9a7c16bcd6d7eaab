"""The measurand of a limit: parsed, compared with that of the result, and written."""

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
def test_invalid_key_is_reported_at_its_location(case):
    old, new, anchor, field, message, hint = case
    text = edited(PROCEDURE, (old, new))
    path = f"acceptance.limits[0].measurand{field}"
    (problem,) = (
        problem for problem in problems_of(parse_procedure, text, "p.yaml") if problem.field == path
    )
    assert message in problem.message
    assert hint in problem.hint
    assert str(problem.location) == f"p.yaml:{place_of(text, anchor)}"


def test_limit_applies_only_to_same_nature_and_condition():
    for nature in Nature:
        for condition in Condition:
            measurand = LimitMeasurand(nature=str(nature), condition=str(condition))
            same = measurand.kind == STARTING
            assert (measurand.objection(STARTING, [1000.0]) == "") is same


def test_torque_limit_does_not_apply_to_hardness():
    assert BREAKAWAY.objection(Hardness("HRC")) == (
        "the limit is for the no-load torque from rest, and the result is the hardness HRC"
    )


@given(st.sampled_from(Nature), st.sampled_from(Condition), st.none() | st.floats(0.1, 1e5))
def test_measurand_round_trips(nature, condition, load):
    measurand = LimitMeasurand(
        nature=str(nature), condition=str(condition), load=None if load is None else f"{load!r} N"
    )
    limit = {"of": "torque", "mean": True, "max": "1 N·m", "source": "a test"}
    limits = Acceptance.model_validate(
        {"limits": [limit | {"measurand": measurand.as_written()}]}
    ).limits
    assert limits[0].measurand == measurand


def details(kind, *loads):
    return TorqueDetails(
        primary="template_inverse",
        kind=kind,
        loaded=tuple(SimpleNamespace(load_n=load_n) for load_n in loads),
    )


def test_total_torque_without_load_counts_as_no_load_torque():
    assert details(TOTAL, 0.0, 2.0).objection(BREAKAWAY) == ""
    assert details(TOTAL, 0.0, 500.0).objection(BREAKAWAY) == (
        "The limit is for the no-load torque from rest, and the result is the total torque from "
        "rest under 0 N to 500 N: conformity cannot be stated."
    )


def test_limit_applies_only_at_its_load():
    at_load = LimitMeasurand(**AT_REVERSAL, load="1000 N")
    assert details(STARTING, 1009.0, 992.0).objection(at_load) == ""
    assert "under 1000 N, and the result is" in details(STARTING, 1009.0, 985.0).objection(at_load)


def test_missing_measurand_of_limit_or_result_is_reported():
    assert details(STARTING, 1000.0).objection(None) == (
        "The limit does not say of which torque it is: it needs a 'measurand'."
    )
    assert (
        details(None, 1000.0)
        .objection(BREAKAWAY)
        .startswith("template_inverse does not say which torque it yields")
    )


def decide(**load):
    part = LimitDecision(
        verdict=Verdict.PASS,
        reason="a test",
        limits=Limits.between(None, 0.95),
        source="a test",
        measurand=LimitMeasurand(**AT_REVERSAL, **load),
    )
    return Decision(rule="simple: a test", parts=(part,))


def test_documents_state_measurand_and_load():
    words = "load-induced torque at the reversals of a swing"
    assert decision_document(decide(load="1 kN"))["measurand"] == {
        **AT_REVERSAL,
        "load": {"value": 1000.0, "unit": "N"},
        "text": words,
    }
    assert decision_document(decide())["measurand"] == {**AT_REVERSAL, "load": None, "text": words}
    (statement,) = conformity_of(decide(load="1 kN"), ()).statements
    assert (statement.measurand, statement.load_n) == (words, 1000.0)
    (statement,) = conformity_of(decide(), ()).statements
    assert (statement.measurand, statement.load_n) == (words, None)


def test_load_n_still_works_with_deprecation_warning():
    with pytest.warns(DeprecationWarning, match="import load_of from"):
        assert decide(load="1 kN").parts[0].load_n == 1000.0
    with pytest.warns(DeprecationWarning, match="import load_of from"):
        assert decide().parts[0].load_n is None
