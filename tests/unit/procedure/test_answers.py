"""Which answers are accepted."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from rigrunner.api.quantity import parse_quantity
from rigrunner.procedure.answers import AnswerError, Expected

SIDE = Expected(("left side", "right side"))
ROOM = Expected(unit="°C", minimum=parse_quantity("15 °C"), maximum=parse_quantity("30 °C"))
LOAD = Expected(unit="kN", minimum=parse_quantity("100 N"))
ANY_LOAD = Expected(unit="N")


@pytest.mark.parametrize(
    ("expected", "answer", "accepted"),
    [
        (Expected(), "  SN-17 ", "SN-17"),
        (Expected(), "$5, 1e3: yes", "$5, 1e3: yes"),
        (SIDE, "left side", "left side"),
        (SIDE, " LEFT Side", "left side"),
        (ROOM, "23 °C", "23 °C"),
        (ROOM, "23", "23 °C"),
        (ROOM, "23.50", "23.5 °C"),
        (ROOM, "296.15K", "296.15 K"),
        (ROOM, "15", "15 °C"),
        (ROOM, "30 degC", "30 °C"),
        (LOAD, "1000 N", "1000 N"),
        (LOAD, ".5", "0.5 kN"),
        (ANY_LOAD, "-5", "-5 N"),
        (ANY_LOAD, "\N{MINUS SIGN}5 kN", "-5 kN"),
    ],
)
def test_valid_answer_is_accepted(expected, answer, accepted):
    assert expected.accept(answer) == accepted
    assert expected.accept(accepted) == accepted


@pytest.mark.parametrize(
    ("expected", "answer", "message", "hint"),
    [
        (SIDE, "left", "got 'left', expected one of: left side, right side",
         "did you mean 'left side'?"),
        (SIDE, "", "got '', expected one of: left side, right side", ""),
        (SIDE, "1", "expected one of", ""),
        (Expected(), "SN\x00", r"got 'SN\x00', expected a text without control characters", ""),
        (Expected(), "SN\udcff", r"got 'SN\udcff', expected a text without control", ""),
        (ROOM, "", "'' is not a number with a unit", "units of temperature: K, °C"),
        (ROOM, "warm", "'warm' is not a number with a unit", ""),
        (ROOM, "23,5", "'23,5' has a decimal comma", "write '23.5'"),
        (ROOM, "23,5 °C", "'23,5 °C' has a decimal comma", "write '23.5 °C'"),
        (ROOM, "23 N", "'23 N' is a force, not a temperature", ""),
        (ROOM, "14.9", "14.9 °C is out of range (15 °C to 30 °C)", ""),
        (ROOM, "31 °C", "31 °C is out of range (15 °C to 30 °C)", ""),
        (ROOM, "1e3", "1000 °C is out of range (15 °C to 30 °C)", ""),
        (ROOM, "nan", "'nan' is not a number with a unit", ""),
        (ROOM, "1_0", "more than one number", ""),
        (LOAD, "50 N", "50 N is out of range (100 N or more)", ""),
        (Expected(unit="N", maximum=parse_quantity("0 N")), "1", "out of range (0 N or less)", ""),
    ],
)  # fmt: skip
def test_invalid_answer_is_refused_with_what_is_allowed(expected, answer, message, hint):
    with pytest.raises(AnswerError) as caught:
        expected.accept(answer)
    assert message in caught.value.message
    assert hint in caught.value.hint


@pytest.mark.parametrize(
    ("expected", "words"),
    [
        (Expected(), ""),
        (SIDE, "left side / right side"),
        (ROOM, "in °C, 15 °C to 30 °C"),
        (ANY_LOAD, "in N"),
    ],
)
def test_question_states_what_is_allowed(expected, words):
    assert expected.words == words


@settings(max_examples=examples(200), deadline=None)
@given(st.sampled_from([SIDE, ROOM, LOAD, ANY_LOAD]), st.text(max_size=30))
def test_any_answer_is_accepted_or_refused(expected, answer):
    try:
        accepted = expected.accept(answer)
    except AnswerError:
        return
    assert expected.accept(accepted) == accepted
