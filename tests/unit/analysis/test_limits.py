from __future__ import annotations

import pytest

from rigrunner.api.data import Estimate
from rigrunner.api.verdict import Limits
from rigrunner.signal.coverage import probability_within

UPPER = Limits.between(None, 0.95)


def test_limits_as_text():
    assert str(UPPER) == "≤ 0.95 N·m"
    assert str(Limits.between(0.2, None)) == "≥ 0.2 N·m"
    assert str(Limits.between(0.2, 0.95)) == "0.2 N·m to 0.95 N·m"


def test_limit_is_shown_with_all_digits():
    """Rounded to six, a band of 1 Hz about 10 MHz would read '10 MHz to 10 MHz'."""
    assert str(Limits(9.999999, 10.000001, "MHz")) == "9.999999 MHz to 10.000001 MHz"
    assert str(Limits.between(None, 1000000.5, "Hz")) == "≤ 1000000.5 Hz"
    assert str(Limits.between(1013.254, None, "hPa")) == "≥ 1013.254 hPa"


def test_dimensionless_limit_is_shown_without_unit():
    assert str(Limits.between(None, 0.5, "1")) == "≤ 0.5"
    assert Limits.between(0.25, 0.5, "1").in_words == "0.25 to 0.5"


def test_edges_are_moved_by_the_guard_band():
    assert UPPER.edges(0.25) == (0.7,)
    assert Limits.between(0.5, 1.0).edges(-0.25) == (0.25, 1.25)


def test_probability_is_by_students_t():
    """P(t <= 1) with one degree of freedom (Cauchy) is 3/4."""
    assert probability_within(UPPER, Estimate(0.9, 0.05, 1)) == pytest.approx(0.75)


def test_probability_between_two_limits():
    limits = Limits.between(0.9, 1.0)
    assert probability_within(limits, Estimate(0.95, 0.05)) == pytest.approx(0.682689492, abs=1e-9)


def test_probability_without_uncertainty_is_zero_or_one():
    assert probability_within(UPPER, Estimate(0.9, 0.0)) == 1
    assert probability_within(UPPER, Estimate(0.96, 0.0)) == 0
