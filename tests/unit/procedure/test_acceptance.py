from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from rigrunner.api.measurand import Condition, MeasurandKind, Nature
from rigrunner.procedure import Acceptance, LimitMeasurand

AT_REVERSAL = {"nature": "load_induced", "condition": "at_reversal"}
STARTING = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)


def limit(**changes):
    mean = {"of": "torque", "mean": True, "max": "1 N·m", "source": "a test"}
    return mean | {"measurand": AT_REVERSAL} | changes


def each(*, where=(), **changes):
    places = {"where": {"frequency": list(where)}} if where else {}
    return limit(mean=False, each="frequency", **places, **changes)


def accept(*limits, **changes):
    return Acceptance.model_validate({"limits": list(limits), **changes})


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"limits": []}, "at least 1 item"),
        ({}, "Field required"),
        (
            {
                "limits": [limit()],
                "rule": {"lab_s_own": {"fraction": 1}},
                "fraction": 0.5,
            },
            "'fraction' belongs to the other settings of the rule",
        ),
        ({"limits": [limit(), limit(max="2 N·m")]}, "there are two limits of torque .mean."),
        (
            {"limits": [each(where=["5 Hz", "9 Hz"]), each(where=["9 Hz", "5 Hz"])]},
            "there are two limits of torque at frequency = 5 Hz or 9 Hz",
        ),
        ({"limits": [limit(each="frequency")]}, "'mean' stands alone"),
        ({"limits": [limit(where={"frequency": []})]}, "got an empty list"),
        ({"limits": [limit()], "marginal": "0 N·m"}, "more than 0"),
        ({"limits": [limit()], "marginal": "0.1 °C"}, "not a difference of two"),
    ],
)
def test_what_does_not_fit_together_is_refused(given, words):
    with pytest.raises(ValidationError, match=words):
        Acceptance.model_validate(given)


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
    named = [each(where=[f"{hz} Hz"], max=most) for hz in frequencies]
    others = {"except": {"frequency": [f"{hz} Hz" for hz in frequencies]}} if frequencies else {}
    chosen = Acceptance.model_validate(
        {
            "limits": [limit(max=most, measurand=measurand), each(**others), *named],
            "rule": rule,
            "fraction": 0.3 if rule == "guard_band_fraction" else None,
            "marginal": marginal,
        }
    )
    assert Acceptance.model_validate(chosen.as_written()) == chosen
