"""Numbers, commands and line ends of instruments that talk in text."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from rigrunner.api.errors import DeviceRejectedError
from rigrunner_plugins.devices.text.commands import SettingCommand, with_samples, with_value
from rigrunner_plugins.devices.text.numbers import NumberInText
from rigrunner_plugins.devices.text.patterns import fits
from rigrunner_plugins.devices.text.termination import Termination, termination_name

ENDING = TypeAdapter(Termination)


@pytest.mark.parametrize(
    ("text", "form", "number"),
    [
        ("12.5", {}, 12.5),
        (" +12.5E-03\n", {}, 0.0125),
        (".5", {}, 0.5),
        ("5.", {}, 5.0),
        ("-  100.00 g", {"unit_in_answer": "g"}, -100.0),
        ("100.00g", {"unit_in_answer": "g"}, 100.0),
        ("1.0,2.5,3.5", {"field": 2}, 2.5),
        ("N     +   1.5 Nm   S", {"field": 3, "separator": " "}, 1.5),
        ("a=1;b=-7", {"field": 2, "separator": ";", "pattern": ""}, None),
        ("T=23.4C;P=9", {"pattern": r"T=([\d.]+)C"}, 23.4),
        ("T=23.4 C;P=9", {"pattern": r"T=(.+);", "unit_in_answer": "C"}, 23.4),
        ("#H1F", {"number": "hexadecimal"}, 31.0),
        ("0x1f", {"number": "hexadecimal"}, 31.0),
        ("FF", {"number": "hexadecimal"}, 255.0),
        ("OL", {}, None),
        ("1,234.5", {}, None),
        ("0x1F", {}, None),
        ("1e", {}, None),
        ("--1", {}, None),
        ("inf", {}, None),
        ("1_000", {}, None),
        ("\u0661", {}, None),  # an Arabic one
        ("1.0", {"unit_in_answer": "g"}, None),
        ("1.0,2.0", {"field": 3}, None),
        ("x", {"pattern": r"T=(\d+)"}, None),
        ("-1E+9", {"overload": 1e9}, None),
        ("9.9E8", {"overload": 1e9}, 9.9e8),
    ],
)
def test_number_is_read_from_a_text_or_refused(text, form, number):
    number_in_text = NumberInText(**form)
    if number is None:
        with pytest.raises(DeviceRejectedError, match="the answer"):
            number_in_text.number_in(text, "the answer")
    else:
        assert number_in_text.number_in(text, "the answer") == pytest.approx(number)


@given(st.text(max_size=30))
def test_number_from_any_text_is_finite_or_refused(text):
    try:
        number = NumberInText().number_in(text, "the answer")
    except DeviceRejectedError:
        return
    assert math.isfinite(number)
    assert number == float(text.strip().replace(" ", ""))


@given(
    st.text(max_size=30), st.text(max_size=3), st.integers(1, 9), st.sampled_from([",", ";", " "])
)
def test_number_from_any_list_is_finite_or_refused(text, unit, field, separator):
    form = NumberInText(unit_in_answer=unit, field=field, separator=separator)
    try:
        number = form.number_in(text, "the answer")
    except DeviceRejectedError:
        return
    assert math.isfinite(number)


@pytest.mark.parametrize(
    ("command", "number", "sent"),
    [
        ("SOUR:FREQ {value}", 12.5, "SOUR:FREQ 12.5"),
        ("SOUR:FREQ {value}", 1 / 3, "SOUR:FREQ 0.333333333333"),
        ("SOUR:FREQ {value:.3f}", 12.5, "SOUR:FREQ 12.500"),
        ("S{value:+06.1f};", 1.25, "S+001.2;"),  # 1.25 is a binary tie, which goes to even
        ("L{value:.0f}{x}", 41.6, "L42{x}"),
    ],
)
def test_set_point_is_formatted_in_a_command(command, number, sent):
    assert with_value(TypeAdapter(SettingCommand).validate_python(command), number) == sent


@given(st.floats(-1e30, 1e30))
def test_set_point_is_sent_with_twelve_digits(number):
    assert float(with_value("{value}", number)) == pytest.approx(number, rel=1e-11)


def test_number_of_samples_is_formatted_in_a_command():
    assert with_samples("TRAC:DATA? {samples},1", 100) == "TRAC:DATA? 100,1"


@pytest.mark.parametrize(
    ("named", "characters"), [("CRLF", "\r\n"), ("none", ""), ("\r", "\r"), ("NUL", "\0")]
)
def test_line_ends_are_given_by_name_or_characters(named, characters):
    assert ENDING.validate_python(named) == characters


@pytest.mark.parametrize("wrong", ["crlf", "", "LF ", ";", "\\n"])
def test_other_line_ends_are_refused(wrong):
    with pytest.raises(ValidationError, match="expected one of: LF, CR, CRLF"):
        ENDING.validate_python(wrong)


def test_line_ends_are_named():
    assert [termination_name(end) for end in ("\n", "\r\n", "\x02")] == ["LF", "CRLF", r"'\x02'"]


@pytest.mark.parametrize(
    ("pattern", "text", "good"),
    [
        ("0", "0\n", True),
        ("0", "03", False),
        (r"[+-]?0(,.*)?", '+0,"No error"', True),
        (r"[+-]?0(,.*)?", '-100,"Command error"', False),
        ("ACME.*", "ACME,1\r,2", True),
    ],
)
def test_pattern_must_match_the_whole_answer(pattern, text, good):
    assert fits(pattern, text) is good
