"""Quantities are read as intended, or refused."""

from __future__ import annotations

import contextlib
import math
import re

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from rigrunner.api.devices import DriveInfo
from rigrunner.api.quantity import (
    Quantity,
    largest,
    legible,
    parse_quantity,
    quantity_pattern,
    readable,
)
from rigrunner.api.unit_tables import UNITS
from rigrunner.api.units import (
    QuantityError,
    is_coherent,
    kinds,
    rate_of,
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
        ("1.54 Å", 1.54e-10, "length"),
        ("1.54 \N{ANGSTROM SIGN}", 1.54e-10, "length"),
        ("1.54 angstrom", 1.54e-10, "length"),
        ("2 1/Å", 2e10, "1/m"),
        ("0.00233 kg·m²", 0.00233, "moment of inertia"),
    ],
)
def test_quantity_is_parsed(text, si, dimension):
    quantity = parse_quantity(text)

    assert quantity.si == pytest.approx(si, rel=1e-15)
    assert quantity.dimension == dimension


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("1,5 N", "has a decimal comma", "write '1.5 N'"),
        ("1/s", "has no number before its unit", "such as '10 Hz'"),
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
        ("1e300 s", "too large", "at most 3653 d"),
        ("3654 d", "too large", "at most 3653 d"),
        ("-1e300 s", "too large", "at most 3653 d"),
        ("2e9 kHz", "too large", "at most 1000000000 kHz"),
        ("1e300 N·m", "too large", "at most"),
        ("0x10 N", "unknown unit", ""),
        ("\N{ARABIC-INDIC DIGIT THREE} N", "is not a number with a unit", ""),
        ("5 hz", "unknown unit 'hz'", "did you mean 'Hz'?"),
        ("5 Newtonmeter", "unknown unit 'Newtonmeter'", ""),
        ("5 °C/min", "which has an offset zero", "differences of temperature are in K"),
        ("5 dB/m", "no unit is made of dB", "a level is a logarithm"),
        ("5 N/m/s", "unknown unit 'N/m/s'", "did you mean"),
        ("5 N·q", "unknown unit 'N·q'", ""),
        ("5 Nm2", "unknown unit 'Nm2'", ""),
        ("5 s9·s", "power of a unit is too high", ""),
        ("5 fA9·fA9·fA9", "too large or too small a unit", ""),
        ("5 Kn", "unknown unit 'Kn'", "did you mean 'kN'?"),
        ("5 mM", "unknown unit 'mM'", "did you mean 'mmol/L'?"),
        ("5 M", "unknown unit 'M'", "did you mean 'mol/L'?"),
        ("5 %RH", "unknown unit '%RH'", "did you mean '%'?"),
        ("5 newton", "unknown unit 'newton'", ""),
        (
            "5 qqq",
            "unknown unit 'qqq'",
            "known units, with prefixes, products and quotients: N·m, mN·m",
        ),
        ("5 N or so", "unknown unit 'N or so'", ""),
    ],
)
def test_invalid_quantity_is_refused_with_a_hint(text, message, hint):
    with pytest.raises(QuantityError) as caught:
        parse_quantity(text)

    assert message in caught.value.message
    assert hint in caught.value.hint


def test_other_dimension_is_refused():
    with pytest.raises(QuantityError) as caught:
        parse_quantity("5 deg", "torque")

    assert (
        str(caught.value)
        == "'5 deg' is an angle, not a torque (units of torque: N·m, mN·m, in·lbf)"
    )


@pytest.mark.parametrize(
    ("text", "needed", "message"),
    [
        ("5 J", "torque", "is an energy, not a torque"),
        ("5 nm", "torque", "is a length, not a torque"),
        ("5 Bq", "frequency", "is an activity, not a frequency"),
        ("5 1/s", "frequency", "is a rate, not a frequency"),
        ("5 rad/s", "rate", "is an angular velocity, not a rate"),
        ("5 N·m", "force", "is a torque, not a force"),
        ("5 dB", "ratio", "is a level, not a ratio"),
        ("5 V/K", "voltage", "is a quantity in V/K, not a voltage"),
    ],
)
def test_other_kind_of_equal_dimension_is_refused(text, needed, message):
    with pytest.raises(QuantityError, match=re.escape(message)):
        parse_quantity(text, needed)


def test_messages_for_long_texts_are_short():
    with pytest.raises(QuantityError) as caught:
        parse_quantity("5 " + "x" * 100_000)

    assert len(caught.value.message) < 100


@settings(max_examples=examples(300), deadline=None)
@given(st.floats(-1e15, 1e15), st.sampled_from(UNITS))
def test_quantity_round_trips_through_its_text(number, of_unit):
    quantity = Quantity(number, of_unit)
    assume(abs(quantity.si) <= largest(quantity.dimension))

    assert parse_quantity(str(quantity), of_unit.dimension) == quantity


@settings(max_examples=examples(300), deadline=None)
@given(st.text(max_size=20) | st.from_regex(r"[-+0-9.,eE _']{0,8} ?[a-zA-Z·µ%°/]{0,4}"))
def test_any_text_is_a_quantity_or_refused(text):
    with contextlib.suppress(QuantityError):
        assert math.isfinite(parse_quantity(text).si)


def test_units_are_found_by_symbol_and_dimensions_have_a_coherent_unit():
    for u in UNITS:
        assert unit(u.symbol) is u
    assert units_of("torque") == ["N·m", "mN·m", "in·lbf"]
    assert units_of("V/K") == ["V/K"]
    for dimension in kinds():
        coherent = unit(si_symbol(dimension))
        assert is_coherent(coherent)
        assert coherent.dimension == dimension


DIMENSIONS = sorted({u.dimension for u in UNITS})


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
def test_value_is_written_in_a_suitable_unit(si, dimension, text):
    assert str(readable(si, dimension)) == text


@given(st.floats(-1e8, 1e8), st.sampled_from(DIMENSIONS))
@settings(deadline=None, max_examples=examples(200))
def test_readable_value_round_trips(si, dimension):
    read_back = parse_quantity(str(readable(si, dimension)), dimension).si
    assert read_back == pytest.approx(si, rel=1e-10, abs=1e-10)


@given(
    st.one_of(
        st.builds("{}{}{}".format, st.floats(-1e6, 1e6), st.sampled_from(["", " ", "\t"]),
                  st.sampled_from([*(u.symbol for u in UNITS), "Nm", "in-lb", "Nq", ""])),
        st.text("0123456789.,eE+-Nm·k \N{MINUS SIGN}", max_size=8),
    ),
    st.sampled_from([None, *DIMENSIONS]),
)  # fmt: skip
@settings(deadline=None, max_examples=examples(500))
def test_pattern_matches_what_the_parser_accepts(text, dimension):
    """It does not know the largest values, nor the kinds of products and quotients."""
    matches = re.search(quantity_pattern(dimension), text) is not None
    try:
        parse_quantity(text, dimension)
        accepted = True
    except QuantityError as error:
        accepted = "too large" in error.message
    assert matches or not accepted
    if not re.search(r"[·.*/^²³]|[A-Za-z°%][-\N{MINUS SIGN}]?[0-9]", text):
        assert matches == accepted


@pytest.mark.parametrize(
    ("symbol", "kind", "factor", "coherent"),
    [
        ("V/A", "resistance", 1.0, "Ω"),
        ("kΩ", "resistance", 1e3, "Ω"),
        ("Ohm", "resistance", 1.0, "Ω"),
        ("N/mm²", "pressure", 1e6, "Pa"),
        ("lbf/in2", "pressure", 6894.757293168362, "Pa"),  # NIST SP 811, B.8: 6.894 757 E+03
        ("psi", "pressure", 6894.757293168362, "Pa"),
        ("L/min", "volume flow rate", 1e-3 / 60, "m³/s"),
        ("kN·m", "torque", 1e3, "N·m"),
        ("lbf·ft", "torque", 1.3558179483314004, "N·m"),  # NIST SP 811, B.8: 1.355 818 E+00
        ("V·A", "power", 1.0, "W"),
        ("kWh", "energy", 3.6e6, "J"),
        ("g/cm^3", "density", 1e3, "kg/m³"),
        ("1/K", "temperature coefficient", 1.0, "1/K"),
        ("%/K", "temperature coefficient", 0.01, "1/K"),
        ("mV/K", "V/K", 1e-3, "V/K"),
        ("W/(m²·K)", "W/(m²·K)", 1.0, "W/(m²·K)"),
        ("W*m-2", "W/m²", 1.0, "W/m²"),
        ("µV/V", "voltage ratio", 1e-6, "V/V"),
        ("kHz/min", "frequency rate", 1e3 / 60, "Hz/s"),
        ("lm/m²", "illuminance", 1.0, "lx"),
        ("cd/m²", "luminance", 1.0, "cd/m²"),
        ("rev/s", "angular velocity", 2 * math.pi, "rad/s"),
        ("\N{OHM SIGN}", "resistance", 1.0, "Ω"),
    ],
)
def test_prefixes_products_and_quotients_of_units(symbol, kind, factor, coherent):
    composed = unit(symbol)
    assert (composed.dimension, si_symbol(kind)) == (kind, coherent)
    assert composed.factor == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "kelvin"), [("32 °F", 273.15), ("212 degF", 373.15), ("-40 °F", 233.15)]
)
def test_fahrenheit_is_converted(text, kelvin):
    assert parse_quantity(text).si == pytest.approx(kelvin, abs=1e-9)


def test_spellings_of_a_unit_are_equal():
    spellings = ["N·m·s/rad", "N*m*s/rad", "N.m.s/rad"]
    assert {unit(spelling) for spelling in spellings} == {unit("N·m·s/rad")}
    assert unit("W/A").dimension == "voltage"
    assert unit("W/(A·K)").dimension == unit("V/K").dimension


@pytest.mark.parametrize(
    ("kind", "rate"),
    [
        ("force", "force rate"),
        ("angle", "angular velocity"),
        ("temperature", "temperature rate"),
        ("torque", "torque rate"),
        ("frequency", "frequency rate"),
        ("voltage", "voltage rate"),
        ("pressure", "pressure rate"),
        ("illuminance", "cd/(m²·s)"),
        ("level", None),
    ],
)
def test_rate_of_a_quantity(kind, rate):
    assert rate_of(kind) == rate


_FACTORS = st.lists(
    st.sampled_from([("N", 1), ("mm", 3), ("kg", 2), ("s", 1), ("V", 1), ("K", 1), ("rad", 1),
                     ("Hz", 1), ("min", 1), ("Ω", 1), ("lx", 1)]),
    min_size=1, max_size=2,
)  # fmt: skip


@given(_FACTORS, _FACTORS)
@settings(deadline=None, max_examples=examples(100))
def test_factor_of_a_quotient_is_the_quotient_of_factors(above, below):
    def written(parts):
        product = "·".join(f"{name}{power if power > 1 else ''}" for name, power in parts)
        return f"({product})" if len(parts) > 1 else product

    def factor(parts):
        return math.prod(unit(name).factor ** power for name, power in parts)

    assume(not {("mm", 3), ("lx", 1)} <= {*above, *below})  # mm⁶/lx², say, is m¹⁰/cd²: refused
    composed = unit(f"{written(above).strip('()')}/{written(below)}")
    assert composed.factor == pytest.approx(factor(above) / factor(below), rel=1e-12)
    assert unit(composed.symbol) == composed
    assert unit(si_symbol(composed.dimension)).dimension == composed.dimension


@pytest.mark.parametrize(
    ("si", "symbol", "text"),
    [
        (24.5, "N", "24.5 N"),
        (0.0, "m", "0 m"),
        (0.02, "m", "0.02 m"),
        (4.5e-7, "m", "450 nm"),
        (-3.80215e-6, "A", "-3.80215 µA"),
        (2.508e-5, "m³", "25.08 mL"),
        (3.2e6, "Pa", "3.2 MPa"),
        (1e-30, "m", "1e-30 m"),
        (1e-6, "", "1e-06"),
        (5e-12, "H", "5e-12 H"),
        (float("nan"), "V", "nan V"),
        (673.15, "K", "400 °C"),
    ],
)
def test_small_or_large_number_is_given_in_a_legible_unit(si, symbol, text):
    assert legible(si, symbol) == text


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [(0, 3000, "0 to 3000 m"), (3e-7, 1.1e-6, "300 nm to 1.1 µm"), (3e-7, 9e-7, "300 to 900 nm")],
)
def test_range_of_a_drive_in_words(low, high, text):
    assert DriveInfo("x", "m", "X", low, high).range_text == text


def test_temperature_range_is_in_degrees_celsius():
    """'500 °C is out of range (0 to 673.15 K)' would mix units."""
    assert DriveInfo("x", "K", "X", 273.15, 673.15).range_text == "0 to 400 °C"
