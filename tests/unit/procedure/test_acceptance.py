from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from helpers_measurand import LimitOfColour, LimitOfHardness, analysis, kinds
from rigrunner.api.errors import PluginError
from rigrunner.procedure import Acceptance
from rigrunner.procedure.kinds import KINDS, STORED

HARDNESS = {KINDS: kinds(analysis())}
BOTH = {KINDS: kinds(analysis("colour", LimitOfColour), analysis())}
NEITHER = {KINDS: kinds(analysis(model=None))}


def limit(**changes):
    return {"of": "torque", "mean": True, "max": "1 N·m", "source": "a test"} | changes


def each(*, where=(), **changes):
    places = {"where": {"frequency": list(where)}} if where else {}
    return limit(mean=False, each="frequency", **places, **changes)


def accept(*limits, **changes):
    return Acceptance.model_validate({"limits": list(limits), **changes})


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"limits": []}, "at least 1 item"),
        ({}, "Field required"),
        (
            {
                "limits": [limit()],
                "rule": {"lab_s_own": {"fraction": 1}},
                "fraction": 0.5,
            },
            "write 'fraction' with the other settings of the rule",
        ),
        ({"limits": [limit(), limit(max="2 N·m")]}, "there are two limits of torque .mean."),
        (
            {"limits": [each(where=["5 Hz", "9 Hz"]), each(where=["9 Hz", "5 Hz"])]},
            "there are two limits of torque at frequency = 5 Hz or 9 Hz",
        ),
        ({"limits": [limit(min="1 rad")]}, "min is an angle, max a torque"),
        ({"limits": [limit(each="frequency")]}, "'mean' cannot be combined"),
        ({"limits": [limit(where={"frequency": []})]}, "got an empty list"),
        ({"limits": [limit()], "marginal": "0 N·m"}, "more than 0"),
        ({"limits": [limit()], "marginal": "0.1 °C"}, "not a difference of two"),
        ({"limits": [limit()], "marginal": "1.8 °F"}, "write it in K: '1 K'"),
    ],
)
def test_what_does_not_fit_together_is_refused(content, words):
    with pytest.raises(ValidationError, match=words):
        Acceptance.model_validate(content)


torques = st.floats(1e-6, 1e3).map(lambda value: f"{value!r} N·m")


@given(
    torques,
    st.none() | torques,
    st.lists(st.integers(1, 60), unique=True, max_size=3),
    st.none() | st.floats(0.1, 1e5).map(lambda value: {"scale": "HRC", "load": f"{value!r} N"}),
    st.sampled_from(
        ["simple", "guard_band_u", "guard_band_fraction", {"lab_s_own": {"share": 0.5}}]
    ),
)
def test_it_reads_back_as_it_was_written(most, marginal, frequencies, measurand, rule):
    named = [each(where=[f"{hz} Hz"], max=most) for hz in frequencies]
    others = {"except": {"frequency": [f"{hz} Hz" for hz in frequencies]}} if frequencies else {}
    chosen = Acceptance.model_validate(
        {
            "limits": [limit(max=most, measurand=measurand), each(**others), *named],
            "rule": rule,
            "fraction": 0.3 if rule == "guard_band_fraction" else None,
            "marginal": marginal,
        },
        context=HARDNESS,
    )
    assert Acceptance.model_validate(chosen.as_written(), context=HARDNESS) == chosen


def measurand(written, context):
    content = {"limits": [limit(measurand=written)]}
    return Acceptance.model_validate(content, context=context).limits[0].measurand


def test_the_analysis_whose_key_it_is_reads_it():
    for context in (HARDNESS, BOTH):
        assert measurand({"scale": "HRC"}, context) == LimitOfHardness(scale="HRC")
    assert measurand({"illuminant": "A"}, BOTH) == LimitOfColour(illuminant="A")
    with pytest.raises(ValidationError, match="illuminant"):  # as the first one says
        measurand({"scale": "HRA"}, BOTH)


@pytest.mark.parametrize("content", [{"text": float("nan")}, {"text": object()}])
def test_a_measurand_that_no_file_can_have_is_refused_before_the_run(monkeypatch, content):
    monkeypatch.setattr(LimitOfHardness, "document", lambda _: content)
    with pytest.raises(PluginError, match="LimitOfHardness, gave a document that is no JSON"):
        measurand({"scale": "HRC"}, HARDNESS)


def test_without_such_an_analysis_it_is_kept_as_it_is_written():
    written = {"scale": "HRC", "load": "1471 N", "drift": {"of": 3}}
    for context in (NEITHER, HARDNESS | {STORED: True}):
        unread = measurand(written, context)
        assert unread.as_written() == written
        assert unread.document() == written | {"text": str(unread)}
        assert str(unread) == "{scale: HRC, load: 1471 N, drift: {'of': 3}}"
        assert "can read the limit's measurand {scale: HRC" in unread.objection("hardness HRC")
