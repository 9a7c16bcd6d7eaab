from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from rigrunner.signal.repeatability import (
    autocorrelation,
    effective_number,
    jackknife_error,
    standard_error,
)
from rigrunner.signal.uncertainty import coverage_factor


def series(phi, n, seed):
    """Return n values of a first-order autoregressive process about 0, long after its start."""
    noise = np.random.default_rng(seed).standard_normal(n + 100)
    values = np.zeros(n + 100)
    for i in range(1, n + 100):
        values[i] = phi * values[i - 1] + noise[i]
    return values[100:]


def coverage(error, phi, n=30, repeats=600):
    """Return how often mean +/- k u holds 0, the mean of the process."""
    covered = 0
    for seed in range(repeats):
        values = series(phi, n, seed)
        u, dof = error(values)
        covered += abs(values.mean()) <= coverage_factor(dof) * u
    return covered / repeats


def naive(values):
    return float(values.std(ddof=1)) / sqrt(len(values)), len(values) - 1.0


def test_of_correlated_cycles_the_plain_standard_error_is_far_too_small():
    assert coverage(naive, 0.6) < 0.75
    assert coverage(standard_error, 0.6) > 0.9


def test_of_independent_cycles_nothing_is_padded():
    assert 0.93 < coverage(standard_error, 0.0) < 0.97
    u = np.array(
        [[standard_error(x)[0], naive(x)[0]] for x in (series(0, 30, s) for s in range(300))]
    )
    assert np.sqrt(np.mean(u[:, 0] ** 2) / np.mean(u[:, 1] ** 2)) < 1.1


@pytest.mark.parametrize(("phi", "at_least"), [(0.99, 0.8), (0.999, 0.8)])
def test_cycles_that_hardly_change_are_told_to_be_few(phi, at_least):
    """Then u is too small by a half and more, as a known process shows; chance 0.001."""
    few = np.mean([effective_number(series(phi, 30, seed), 0.001) < 5 for seed in range(300)])
    assert few > at_least


@pytest.mark.parametrize("n", [8, 10, 20, 30])
def test_independent_cycles_are_hardly_ever_told_to_be_few(n):
    few = sum(effective_number(series(0.0, n, seed), 0.001) < 5 for seed in range(4000))
    assert few <= 8  # 0.2 %: twice what is expected, and none of 30


def test_effective_number_of_a_long_series():
    """Zhang 2006: n (1 - phi)/(1 + phi) for large n."""
    assert effective_number(series(0.5, 20000, 1)) == pytest.approx(20000 / 3, rel=0.05)


def test_standard_error_of_independent_values():
    values = np.array([1.0, -1.0] * 10)
    assert standard_error(values) == pytest.approx(naive(values))
    assert effective_number(values) == 20


def test_few_values_show_no_correlation():
    assert autocorrelation(np.arange(7.0)) == 0
    assert standard_error(np.arange(7.0)) == naive(np.arange(7.0))


def test_a_drift_through_the_run_is_seen():
    drifting = np.linspace(0, 1, 20) + 0.01 * np.random.default_rng(2).standard_normal(20)
    u, dof = standard_error(drifting)
    assert u > 2.5 * naive(drifting)[0]
    assert dof < 3


def test_values_that_agree_have_no_scatter():
    assert standard_error(np.ones(12)) == (0.0, 11.0)


@pytest.mark.parametrize("phi", [0.0, 0.7])
def test_jackknife_of_a_mean_is_its_standard_error(phi):
    values = series(phi, 25, 3)
    without = (values.sum() - values) / 24
    assert jackknife_error(without) == pytest.approx(standard_error(values))
