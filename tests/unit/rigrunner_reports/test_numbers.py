# ruff: noqa: RUF001  (typographic signs are expected)
from __future__ import annotations

from math import inf, nan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from rigrunner.api.data import Estimate
from rigrunner_reports.numbers import (
    fixed,
    places,
    plain,
    significant,
    stated,
    to_place_of,
    with_sign,
    with_standard_uncertainty,
)


def test_expanded_uncertainty_has_two_digits_and_rounds_the_value():
    # the normal quantile 1.959964: U = 0.01215
    shown = stated(Estimate(0.72744, 0.0062))
    assert (shown.interval, shown.factor, str(shown)) == (
        "0.727 ± 0.012",
        "1.96",
        "0.727 ± 0.012 N·m",
    )


def test_coverage_factor_follows_the_degrees_of_freedom():
    # Student's t of two-sided 95 % at 9 degrees of freedom is 2.262157 (GUM table G.2)
    shown = stated(Estimate(10.0, 1.0, 9.0, "Hz"))
    assert (shown.value, shown.expanded, shown.factor) == ("10.0", "2.3", "2.26")


def test_rounding_up_to_next_decade_drops_a_decimal_place():
    assert [places(value) for value in (0.0994, 0.0996, 0.012, 9.96, 12.0, 120.0)] == [
        *(3, 2, 3, 0, 0, -1)
    ]


@pytest.mark.parametrize("u", [0.0, nan, inf])
def test_value_without_usable_uncertainty_has_four_decimals(u):
    assert stated(Estimate(0.726249, u)).value == "0.7262"


def test_nan_uncertainty_is_shown_as_unknown():
    assert stated(Estimate(0.7, nan, nan)).interval == "0.7000 ± unknown"
    assert stated(Estimate(5.25e-6, nan, nan)).interval == "0.000005250 ± unknown"  # not 0.0000
    assert stated(Estimate(12.34567, nan, nan)).value == "12.3457"


def test_large_uncertainties_round_to_tens():
    assert fixed(1234.0, -1) == "1230"


@given(
    st.floats(-1e4, 1e4, allow_nan=False),
    st.floats(1e-6, 1e3, allow_nan=False),
)
@settings(max_examples=examples(200), deadline=None)
def test_rounding_keeps_value_and_interval_within_half_a_step(value, u):
    shown = stated(Estimate(value, u))
    step = 10.0 ** -places(1.959964 * u)
    assert abs(float(shown.value.replace("−", "-")) - value) <= 0.5001 * step
    assert abs(float(shown.expanded) - 1.959964 * u) <= 0.5001 * step
    digits = shown.expanded.replace(".", "").lstrip("0").rstrip("0")
    assert 1 <= len(digits) <= 2


def test_minus_signs_are_typographic_and_zero_has_none():
    assert [fixed(-0.5, 1), fixed(-0.001, 1), with_sign(0.5, 1), with_sign(-0.5, 1)] == [
        *("−0.5", "0.0", "+0.5", "−0.5")
    ]


def test_numbers_far_from_one_have_a_power_of_ten():
    assert significant(0.02324) == "0.02324"
    assert significant(0.002324) == "2.324 × 10⁻³"
    assert significant(-1234567.0, 3) == "−1.23 × 10⁶"
    assert significant(0.0) == "0"
    assert significant(400.0) == "400.0"


def test_coefficient_and_its_uncertainty_share_a_power_of_ten():
    shown = with_standard_uncertainty(0.0002324, 4.1e-7, "kg·m²")
    assert shown == "(2.3240 ± 0.0041) × 10⁻⁴ kg·m²"
    assert with_standard_uncertainty(400.31, 0.62, "Hz") == "400.31 ± 0.62 Hz"


def test_value_below_its_uncertainty_is_scaled_by_the_uncertainty():
    assert with_standard_uncertainty(0.001, 0.027, "1") == "0.001 ± 0.027 1"
    assert with_standard_uncertainty(0.0, 1.1e-6, "s") == "(0.0 ± 1.1) × 10⁻⁶ s"


def test_estimate_alone_keeps_its_power_of_ten():
    assert to_place_of(1e5, 1155.0) == "1.000 × 10⁵"
    assert to_place_of(0.0002324, 4.1e-7) == "2.3240 × 10⁻⁴"
    assert to_place_of(35.00001, 7.4e-5) == "35.000010"


def test_set_values_are_shown_as_they_were_written():
    assert [plain(35.0), plain(0.5), plain(-2.0)] == ["35", "0.5", "−2"]
