from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from rigrunner.api.measurand import Condition, MeasurandKind, Nature
from rigrunner.procedure import Acceptance, AnalysisSpec, LimitMeasurand

AT_REVERSAL = {"nature": "load_induced", "condition": "at_reversal"}
STARTING = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)


def limit(**changes):
    return {"max": "1 N·m", "source": "a test", "measurand": AT_REVERSAL} | changes


def accept(*limits, **changes):
    return Acceptance.model_validate({"limits": list(limits), **changes})


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"limit": limit(), "limits": [limit()]}, "one of 'limit' and 'limits' is needed"),
        ({}, "one of 'limit' and 'limits' is needed"),
        (
            {"limit": limit(), "rule": {"guard_band_fraction": {"fraction": 1}}, "fraction": 0.5},
            "'fraction' belongs to the other settings of the rule",
        ),
        ({"limits": [limit(), limit(max="2 N·m")]}, "there are two limits of mean"),
        ({"limit": limit(at=["5 Hz"])}, "frequencies under 'at' need 'of: each_frequency'"),
        (
            {"limits": [limit(of="each_frequency", at=hz) for hz in (["5 Hz"], ["9 Hz", "5 Hz"])]},
            "there are two limits of 5 Hz",
        ),
    ],
)
def test_what_does_not_fit_together_is_refused(given, words):
    with pytest.raises(ValidationError, match=words):
        Acceptance.model_validate(given)


def test_a_frequency_is_judged_by_the_limit_that_names_it():
    chosen = accept(
        limit(of="each_frequency", max="1 N·m"),
        limit(of="each_frequency", max="2 N·m", at=["5 Hz", "7 Hz"]),
    )
    assert [chosen.limit_at(hz).max for hz in (5.0, 6.0, 7.0)] == [2, 1, 2]
    assert chosen.mean_limit is None
    assert accept(limit()).limit_at(5.0) is None


def test_a_named_frequency_that_was_not_set_is_missing():
    (only,) = accept(limit(of="each_frequency", at=["5 Hz", "7 Hz"])).torque_limits
    assert only.missing([7.0, 8.0]) == [5.0]


def test_of_starts_from_rest_no_method_gives_the_torque_at_a_reversal():
    assert AnalysisSpec.model_validate({"starts": {}}).measured(STARTING) == MeasurandKind(
        Nature.LOAD_INDUCED, Condition.FROM_REST
    )
    assert AnalysisSpec().measured(STARTING) == STARTING


def test_every_other_nature_and_condition_is_another_torque():
    for nature in Nature:
        for condition in Condition:
            wanted = LimitMeasurand(nature=str(nature), condition=str(condition))
            same = wanted.kind == STARTING
            assert (wanted.objection(STARTING, [1000.0]) == "") is same


torques = st.floats(1e-6, 1e3).map(lambda value: f"{value!r} N·m")


@given(
    torques,
    st.none() | torques,
    st.lists(st.integers(1, 60), unique=True, max_size=3),
    st.none() | st.floats(0.1, 1e5),
    st.sampled_from(
        ["simple", "guard_band_u", "guard_band_fraction", {"lab_s_own": {"share": 0.5}}]
    ),
)
def test_it_reads_back_as_it_was_written(most, marginal, frequencies, load, rule):
    measurand = AT_REVERSAL if load is None else AT_REVERSAL | {"load": f"{load!r} N"}
    named = [limit(of="each_frequency", at=[f"{hz} Hz"], max=most) for hz in frequencies]
    chosen = Acceptance.model_validate(
        {
            "limits": [limit(max=most, measurand=measurand), *named],
            "rule": rule,
            "fraction": 0.3 if rule == "guard_band_fraction" else None,
            "marginal": marginal,
        }
        if marginal
        else {
            "limit": limit(max=most, measurand=measurand),
            "rule": rule,
            "fraction": 0.3 if rule == "guard_band_fraction" else None,
        }
    )
    assert Acceptance.model_validate(chosen.as_written()) == chosen
