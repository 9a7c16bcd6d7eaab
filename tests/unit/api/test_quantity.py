"""Quantities: read as a person means them, or refused."""

from __future__ import annotations

import contextlib
import math
import re

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rigrunner.api.quantity import (
    UNITS,
    Quantity,
    QuantityError,
    largest,
    parse_quantity,
    quantity_pattern,
    readable,
    si_symbol,
    unit,
    units_of,
)


@pytest.mark.parametrize(
    ("text", "si", "dimension"),
    [
        ("12.3 Nm", 12.3, "torque"),
        ("12.3Nm", 12.3, "torque"),
        ("12.3 N.m", 12.3, "torque"),
        ("500 mN·m", 0.5, "torque"),
        (
            "1 in-lb",
            0.1129848290276167,
            "torque",
        ),  # 0.0254 m * 4.4482216152605 N, exact by definition
        ("1.5 kN", 1500.0, "force"),
        ("1e3 N", 1000.0, "force"),
        ("-.5 N", -0.5, "force"),
        ("\N{MINUS SIGN}5 N", -5.0, "force"),
        ("5\N{NO-BREAK SPACE}N", 5.0, "force"),
        ("2100 rpm", 35.0, "frequency"),
        ("180 deg", math.pi, "angle"),
        ("30 d", 2_592_000.0, "time"),
        ("0.3 %", 0.003, "ratio"),
        ("20 °C", 293.15, "temperature"),
        ("5 µm", 5e-6, "length"),
        ("5 \N{GREEK SMALL LETTER MU}m", 5e-6, "length"),
        ("0.00233 kg·m²", 0.00233, "moment of inertia"),
    ],
)
def test_read_as_meant(text, si, dimension):
    quantity = parse_quantity(text)

    assert quantity.si == pytest.approx(si, rel=1e-15)
    assert quantity.dimension == dimension


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("1,5 N", "has a decimal comma", "write '1.5 N'"),
        ("1,000 N", "has a decimal comma", "write '1.000 N' or '1000 N'"),
        ("1.000,5 N", "more than one number", "without spaces or marks"),
        ("1 000 N", "more than one number", "'1000.5 N'"),
        ("1'000 N", "more than one number", "'1000.5 N'"),
        ("1_000 N", "more than one number", "'1000.5 N'"),
        ("10:30", "more than one number", ""),
        ("1.5.2 N", "more than one number", ""),
        ("5", "has no unit", "such as '10 Hz'"),
        ("N", "is not a number with a unit", ""),
        ("", "is not a number with a unit", ""),
        ("inf N", "is not a number with a unit", ""),
        ("nan N", "is not a number with a unit", ""),
        ("1e400 N", "too large", ""),
        ("1e300 s", "too large to be meant", "at most 3653 d"),
        ("3654 d", "too large to be meant", "at most 3653 d"),
        ("-1e300 s", "too large to be meant", "at most 3653 d"),
        ("2e9 kHz", "too large to be meant", "at most 1000000000 kHz"),
        ("1e300 N·m", "too large to be meant", "at most"),
        ("0x10 N", "unknown unit", ""),
        ("\N{ARABIC-INDIC DIGIT THREE} N", "is not a number with a unit", ""),
        ("5 hz", "unknown unit 'hz'", "did you mean 'Hz'?"),
        ("5 nm", "unknown unit 'nm'", "did you mean 'N·m'?"),
        ("5 Kn", "unknown unit 'Kn'", "did you mean 'kN'?"),
        ("5 newton", "unknown unit 'newton'", ""),
        ("5 qqq", "unknown unit 'qqq'", "known units: N·m, mN·m"),
        ("5 N or so", "unknown unit 'N or so'", ""),
    ],
)
def test_refused_with_a_hint(text, message, hint):
    with pytest.raises(QuantityError) as caught:
        parse_quantity(text)

    assert message in caught.value.message
    assert hint in caught.value.hint


def test_another_dimension_is_refused():
    with pytest.raises(QuantityError) as caught:
        parse_quantity("5 deg", "torque")

    assert (
        str(caught.value)
        == "'5 deg' is an angle, not a torque (units of torque: N·m, mN·m, in·lbf)"
    )


def test_messages_stay_short():
    with pytest.raises(QuantityError) as caught:
        parse_quantity("5 " + "x" * 100_000)

    assert len(caught.value.message) < 100


@settings(max_examples=300, deadline=None)
@given(st.floats(-1e15, 1e15), st.sampled_from(UNITS))
def test_a_quantity_comes_back_from_its_text(number, of_unit):
    quantity = Quantity(number, of_unit)
    assume(abs(quantity.si) <= largest(quantity.dimension))

    assert parse_quantity(str(quantity), of_unit.dimension) == quantity


@settings(max_examples=300, deadline=None)
@given(st.text(max_size=20) | st.from_regex(r"[-+0-9.,eE _']{0,8} ?[a-zA-Z·µ%°/]{0,4}"))
def test_any_text_is_a_quantity_or_refused(text):
    with contextlib.suppress(QuantityError):
        assert math.isfinite(parse_quantity(text).si)


def test_every_unit_is_found_by_its_symbol_and_every_dimension_has_a_coherent_unit():
    for known in UNITS:
        assert unit(known.symbol) is known
        assert known.symbol in units_of(known.dimension)
    for dimension in {known.dimension for known in UNITS} - {"voltage ratio", "mass"}:
        coherent = unit(si_symbol(dimension))
        assert (coherent.factor, coherent.offset) == (1, 0)


DIMENSIONS = sorted({known.dimension for known in UNITS})


@pytest.mark.parametrize(
    ("si", "dimension", "text"),
    [
        (0.045, "length", "45 mm"),
        (1000.0, "force", "1 kN"),
        (2_592_000.0, "time", "30 d"),
        (math.pi / 180, "angle", "1 deg"),
        (0.02, "ratio", "2 %"),
        (293.15, "temperature", "20 °C"),
        (0.95, "torque", "0.95 N·m"),
        (-0.5, "torque", "-0.5 N·m"),
        (0.0, "force", "0 N"),
    ],
)
def test_a_value_is_written_in_the_unit_that_suits_it(si, dimension, text):
    assert str(readable(si, dimension)) == text


@given(st.floats(-1e8, 1e8), st.sampled_from(DIMENSIONS))
@settings(deadline=None, max_examples=200)
def test_what_is_written_readably_is_read_as_it_was(si, dimension):
    back = parse_quantity(str(readable(si, dimension)), dimension).si
    assert back == pytest.approx(si, rel=1e-10, abs=1e-10)


@given(
    st.one_of(
        st.builds("{}{}{}".format, st.floats(-1e6, 1e6), st.sampled_from(["", " ", "\t"]),
                  st.sampled_from([*(known.symbol for known in UNITS), "Nm", "in-lb", "Nq", ""])),
        st.text("0123456789.,eE+-Nm·k \N{MINUS SIGN}", max_size=8),
    ),
    st.sampled_from([None, *DIMENSIONS]),
)  # fmt: skip
@settings(deadline=None, max_examples=500)
def test_the_pattern_takes_what_is_read_and_nothing_else(text, dimension):
    """But for what is too large to be meant, of which the pattern does not know."""
    matches = re.search(quantity_pattern(dimension), text) is not None
    try:
        parse_quantity(text, dimension)
        taken = True
    except QuantityError as error:
        taken = "too large to be meant" in error.message
    assert matches == taken
