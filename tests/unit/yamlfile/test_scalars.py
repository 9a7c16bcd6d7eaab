"""Unquoted scalars: the YAML 1.2 core schema; ambiguous ones are refused."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_language import only_problem
from helpers_thorough import examples
from rigrunner.yamlfile import parse


def value_of(text: str) -> object:
    return parse(f"key: {text}\n", "f.yaml").data["key"]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True), ("False", False), ("TRUE", True), ("null", None), ("~", None), ("", None),
        ("5", 5), ("-3", -3), ("+3", 3), ("0", 0), ("1.5", 1.5), (".5", 0.5), ("5.", 5.0),
        ("1e3", 1000.0), ("1E-2", 0.01), ("0.5", 0.5), ("0e1", 0.0),
    ],
)  # fmt: skip
def test_yaml_1_2_core_scalars(text, value):
    scalar = value_of(text)

    assert scalar == value
    assert type(scalar) is type(value)


@pytest.mark.parametrize(
    "text",
    ["no", "yes", "off", "on", "y", "N", "No", "10:30", "1:30:00", "2026-01-05", "1_000",
     "0x1F", "0o17", "0b1", "1,5", "inf", "NaN", "5 Hz", "1.2.3", "<<", "=", "truE"],
)  # fmt: skip
def test_other_scalars_are_texts(text):
    assert value_of(text) == text


@pytest.mark.parametrize("text", ["5", "true", "null", "010", ".nan", "~", "no"])
@pytest.mark.parametrize("quote", ["'", '"'])
def test_quoted_scalars_are_texts(text, quote):
    assert value_of(f"{quote}{text}{quote}") == text


@pytest.mark.parametrize(
    ("text", "number"),
    [("010", "10"), ("-007.5", "-7.5"), ("00", "0"), ("00.5", "0.5"), ("0001", "1"), ("+01", "+1")],
)
def test_leading_zeros_are_refused_with_both_interpretations(text, number):
    problem = only_problem(value_of, text)

    assert str(problem.location) == "f.yaml:1:6"
    assert problem.message == f"{text} has a leading zero"
    assert problem.hint == f"write {number} for the number, or '{text}' in quotes for the text"


@pytest.mark.parametrize("text", [".inf", "-.inf", ".NaN", "1e999", "-1e400", "9" * 5000])
def test_non_finite_numbers_are_refused(text):
    problem = only_problem(value_of, text)

    assert problem.field == "key"
    assert str(problem.location) == "f.yaml:1:6"


@settings(max_examples=examples(200), deadline=None)
@given(st.integers(-(10**15), 10**15) | st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_round_trip(number):
    scalar = value_of(repr(number))

    assert scalar == number
    assert math.copysign(1, scalar) == math.copysign(1, number)
