"""Each distribution has the mean and the standard uncertainty that its budget line states."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import pytest
from scipy import stats

from rigrunner.api.errors import DataError
from rigrunner.signal.monte_carlo.distributions import (
    NAMED,
    CurvilinearTrapezoid,
    MultivariateNormal,
    MultivariateT,
    named,
)

N = 200_000


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.mark.parametrize("name", sorted(NAMED))
def test_mean_and_standard_uncertainty(name, rng):
    values = named(name, 3.0, 0.2).draw(rng, N)
    assert values.mean() == pytest.approx(3.0, abs=5 * 0.2 / sqrt(N))
    assert values.std() == pytest.approx(0.2, rel=0.01)


@pytest.mark.parametrize(
    ("name", "reference"),
    [
        ("normal", stats.norm(1.0, 0.1)),
        ("rectangular", stats.uniform(1 - 0.1 * sqrt(3), 0.2 * sqrt(3))),
        ("triangular", stats.triang(0.5, 1 - 0.1 * sqrt(6), 0.2 * sqrt(6))),
        ("arcsine", stats.arcsine(1 - 0.1 * sqrt(2), 0.2 * sqrt(2))),
    ],
)
def test_shape(name, reference, rng):
    assert stats.kstest(named(name, 1.0, 0.1).draw(rng, 20_000), reference.cdf).pvalue > 0.001


@pytest.mark.parametrize("name", ["normal", "t"])
def test_few_degrees_of_freedom_make_a_t(name, rng):
    values = named(name, 1.0, 0.1, 4.0).draw(rng, 20_000)
    assert stats.kstest(values, stats.t(4, 1.0, 0.1).cdf).pvalue > 0.001


def test_rectangle_with_finite_dof_becomes_a_curvilinear_trapezoid():
    """GUM G.4.2: 50 degrees of freedom are a width known to 10 %, as in JCGM 101 9.5.3.8."""
    assert named("rectangular", 0.0, 1 / sqrt(3), 50) == CurvilinearTrapezoid(
        0.0, pytest.approx(1.0), pytest.approx(0.1)
    )


def test_curvilinear_trapezoid_has_the_variance_of_the_guide(rng):
    """JCGM 101, 6.4.3.3: (b - a)^2/12 + d^2/9."""
    values = CurvilinearTrapezoid(0.0, 1.0, 0.6).draw(rng, N)
    assert values.var() == pytest.approx(4 / 12 + 0.36 / 9, rel=0.01)


def test_multivariate_normal(rng):
    covariance = np.array([[4.0, 1.2], [1.2, 1.0]])
    values = MultivariateNormal(np.array([1.0, 2.0]), covariance).draw(rng, N)
    assert values.mean(axis=0) == pytest.approx([1.0, 2.0], abs=0.02)
    assert np.cov(values.T) == pytest.approx(covariance, rel=0.02)


def test_full_correlation(rng):
    values = MultivariateNormal(np.zeros(2), np.ones((2, 2))).draw(rng, 100)
    assert values[:, 0] == pytest.approx(values[:, 1], abs=1e-7)


def test_multivariate_t_is_wider_than_its_scale(rng):
    scale = np.array([[1.0, -0.5], [-0.5, 1.0]])
    values = MultivariateT(np.zeros(2), scale, 8.0).draw(rng, N)
    assert np.cov(values.T) == pytest.approx(scale * 8 / 6, rel=0.04)
    assert stats.kstest(values[:20_000, 0], stats.t(8).cdf).pvalue > 0.001


def test_contradicting_correlations(rng):
    impossible = np.array([[1.0, 0.9, 0.9], [0.9, 1.0, -0.9], [0.9, -0.9, 1.0]])
    with pytest.raises(DataError, match="contradict"):
        MultivariateNormal(np.zeros(3), impossible).draw(rng, 10)


def test_unknown_name():
    with pytest.raises(DataError, match="'cauchy'"):
        named("cauchy", 0.0, 1.0, inf)
