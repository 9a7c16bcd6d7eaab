"""A limit and its decision on one value: pass, marginal, and the text."""

from __future__ import annotations

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.limits import ValueLimit
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.verdict import Verdict

NAME = "press.torque"


def limit(low=None, high=None, marginal=0.0):
    least, most = (None if text is None else parse_quantity(text) for text in (low, high))
    return ValueLimit.between(NAME, least, most, marginal)


@pytest.mark.parametrize(
    ("low", "high", "value", "passes"),
    [
        ("1 N·m", "3 N·m", 1.0, True),
        ("1 N·m", "3 N·m", 3.0, True),
        ("1 N·m", "3 N·m", 3.0 * (1 + 1e-14), False),
        ("1 N·m", "3 N·m", 1.0 - 1e-14, False),
        (None, "3 N·m", -inf, True),
        ("1 N·m", None, 1e9, True),
        ("20 mN·m", None, 0.019, False),
        ("1 N·m", "3 N·m", nan, False),
    ],
)
def test_limits_are_inclusive(low, high, value, passes):
    decision = limit(low, high).decision(value)
    assert decision.passes is passes
    assert decision.verdict is (Verdict.PASS if passes else Verdict.FAIL)


@given(st.floats(-1e3, 1e3), st.floats(0, 10), st.floats(-2e3, 2e3))
def test_lower_limit_mirrors_the_upper_one(bound, marginal, value):
    lower = ValueLimit(NAME, bound, None, "N·m", marginal).decision(value)
    upper = ValueLimit(NAME, None, -bound, "N·m", marginal).decision(-value)
    assert (lower.verdict, lower.marginal) == (upper.verdict, upper.marginal)
    assert lower.passes is (value >= bound)
    assert lower.marginal is (lower.passes and value - bound < marginal)


@pytest.mark.parametrize(
    ("marginal", "value", "expected"),
    [(0.5, 2.6, True), (0.5, 2.4, False), (0.5, 1.4, True), (0.0, 3.0, False), (0.5, 3.1, False)],
)
def test_marginal_is_within_but_near_the_limit(marginal, value, expected):
    assert limit("1 N·m", "3 N·m", marginal).decision(value).marginal is expected


@pytest.mark.parametrize(
    ("low", "high", "value", "text"),
    [
        (None, "26 °C", 300.15, f"{NAME} is 27 °C (limit: 26 °C or less)"),
        ("20 °C", "26 °C", 292.15, f"{NAME} is 19 °C (limit: 20 °C or more)"),
        (None, "0.5 N·m", 0.500001, f"{NAME} is 0.500001 N·m (limit: 0.5 N·m or less)"),
        (None, "500 mN·m", nan, f"{NAME} is nan mN·m (limit: 500 mN·m or less)"),
    ],
)
def test_reason_is_in_the_unit_of_the_procedure(low, high, value, text):
    assert limit(low, high).decision(value).reason == text


def test_value_just_beyond_the_limit_is_shown_with_more_digits():
    decision = limit(None, "0.5 N·m").decision(0.5 * (1 + 1e-14))
    assert not decision.passes
    assert decision.reason == f"{NAME} is 0.500000000000005 N·m (limit: 0.5 N·m or less)"


@pytest.mark.parametrize(
    ("read", "allowed"),
    [
        ("0.9 mV", "0.0009 V"),
        ("16.1 kN", "16100 N"),
        ("0.3 mbar", "0.0003 bar"),
        ("1.1 bar", "110000 Pa"),
        ("77.09 °F", "25.05 °C"),
    ],
)
def test_value_on_the_limit_passes_in_another_unit(read, allowed):
    """Equal as written; as binary numbers in SI they differ in the last digits."""
    value, end = parse_quantity(read), parse_quantity(allowed)
    for bound in (ValueLimit.between(NAME, None, end), ValueLimit.between(NAME, end, None)):
        assert bound.decision(value.si).passes
    number, shown = parse_quantity(allowed).number, end.unit.symbol
    reason = ValueLimit.between(NAME, None, end).decision(value.si).reason
    assert reason == f"{NAME} is {number:.4g} {shown} (limit: {number:g} {shown} or less)"


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        ("20 °C", "26 °C", "20 °C to 26 °C"),
        (None, "0.1 N·m", "0.1 N·m or less"),
        ("0 N", None, "0 N or more"),
    ],
)
def test_limits_in_words(low, high, text):
    assert limit(low, high).limits.in_words == text


def test_temperature_limit_is_in_kelvin_and_shown_in_degrees_celsius():
    limits = limit("20 °C", "26 °C").limits
    assert (limits.lower, limits.upper, limits.unit) == (293.15, 299.15, "K")
    assert (str(limits), limits.in_signs) == ("20 °C to 26 °C", "20 °C … 26 °C")
    assert limits.shown(300.15) == "27 °C"
