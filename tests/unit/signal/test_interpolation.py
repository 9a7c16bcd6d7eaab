"""Samples between the samples."""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner.signal.interpolation import BEFORE, BEHIND, between

PLACES = np.linspace(BEFORE, 90.0, 500)


def test_polynomials_of_degree_five_are_exact():
    x = np.arange(100.0) / 50
    coefficients = [1.0, -2.0, 0.5, 3.0, -1.0, 0.25]
    expected = np.polyval(coefficients, PLACES / 50)
    assert between(np.polyval(coefficients, x), PLACES) == pytest.approx(expected, abs=1e-9)


def test_at_the_samples_it_gives_the_samples():
    samples = np.random.default_rng(1).standard_normal(50)
    places = np.arange(BEFORE, 50 - BEHIND, dtype=float)
    assert between(samples, places) == pytest.approx(samples[BEFORE : 50 - BEHIND], abs=1e-12)


def test_up_to_a_tenth_of_the_rate_it_errs_by_less_than_a_thousandth():
    for cycles_per_sample in (0.01, 0.05, 0.1):
        sine = np.sin(2 * np.pi * cycles_per_sample * np.arange(100))
        expected = np.sin(2 * np.pi * cycles_per_sample * PLACES)
        assert np.abs(between(sine, PLACES) - expected).max() < 1e-3


@pytest.mark.parametrize("place", [BEFORE - 0.1, 50.0 - BEHIND])
def test_too_near_to_the_ends_is_refused(place):
    with pytest.raises(ValueError, match="too near to the ends"):
        between(np.zeros(50), np.array([place]))
