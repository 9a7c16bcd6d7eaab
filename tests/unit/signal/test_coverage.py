"""Coverage intervals of what few bounded errors make up, against trials and closed forms."""

from dataclasses import replace
from math import inf, sqrt

import numpy as np
import pytest
from scipy.stats import t

from rigrunner.api.data import Estimate
from rigrunner.api.uncertainty import Corrected, Distribution, Effect, Input, MeasurementModel
from rigrunner.signal.coverage import cumulative, excess_kurtosis, expanded, factor
from rigrunner.signal.propagation import propagate

TRIALS = 100_000


def estimate(kurtosis=0.0, dof=inf):
    return Estimate(0.0, 1.0, dof, kurtosis=kurtosis)


def test_a_single_rectangle_is_covered_by_95_per_cent_of_its_width():
    assert factor(estimate(-1.2)) == pytest.approx(0.95 * sqrt(3), rel=1e-12)


def test_two_equal_rectangles_make_a_triangle():
    exact = sqrt(6) * (1 - sqrt(0.05))  # of a triangle of u = 1 (JCGM 101, 6.4.5)
    assert factor(estimate(excess_kurtosis([(1.0, "rectangular")] * 2, sqrt(2)))) == pytest.approx(
        exact, rel=0.01
    )


def test_without_bounded_parts_the_factor_is_that_of_student():
    assert factor(estimate()) == pytest.approx(1.959964, abs=1e-6)
    for dof in (3, 9, 29.5):
        assert factor(estimate(dof=dof)) == pytest.approx(t.ppf(0.975, dof), rel=1e-12)
        assert factor(estimate(dof=dof), 0.99) == pytest.approx(t.ppf(0.995, dof), rel=1e-12)


def test_a_nearly_normal_sum_goes_over_into_the_normal_one_without_a_step():
    assert factor(estimate(-0.00101)) == pytest.approx(factor(estimate(-0.00099)), abs=2e-4)


def test_a_single_arcsine_is_covered_by_its_own_quantile():
    assert factor(estimate(-1.5)) == pytest.approx(sqrt(2) * np.sin(0.475 * np.pi), rel=1e-9)


@pytest.mark.parametrize(
    ("names", "exact"),
    [(("arcsine",) * 3, 1.9531), (("arcsine",) * 2 + ("rectangular",), 1.9352),
     (("rectangular",) * 3, 1.9373)],
    ids=["three arcsines", "two arcsines and a rectangle", "three rectangles"],
)  # fmt: skip
def test_equal_half_widths_are_within_what_the_documents_say(names, exact):
    """Exact k from the characteristic functions J0(w) and sin(w)/w, and by 8 million trials."""
    parts = [(1 / sqrt(2 if name == "arcsine" else 3), name) for name in names]
    u = sqrt(sum(contribution**2 for contribution, _ in parts))
    error = factor(estimate(excess_kurtosis(parts, u))) / exact - 1
    assert -0.0255 <= error <= 0.028
    assert error >= -0.0095 or "arcsine" in names


@pytest.mark.parametrize("other", ["normal", "rectangular", "arcsine"])
@pytest.mark.parametrize("share", [0.02, 0.05, 0.1, 0.2, 0.3, 0.4])
def test_an_arcsine_with_a_little_of_something_else_is_covered(share, other):
    rng = np.random.default_rng(round(100 * share))
    shapes = {
        "normal": rng.standard_normal(TRIALS),
        "rectangular": sqrt(3) * rng.uniform(-1, 1, TRIALS),
        "arcsine": sqrt(2) * np.sin(rng.uniform(-np.pi, np.pi, TRIALS)),
    }
    errors = sqrt(2) * np.sin(rng.uniform(-np.pi, np.pi, TRIALS)) + share * shapes[other]
    u = sqrt(1 + share**2)
    kurtosis = excess_kurtosis([(1.0, "arcsine"), (share, other)], u)
    covered = np.mean(np.abs(errors) <= expanded(Estimate(0.0, u, inf, kurtosis=kurtosis)))
    assert 0.935 <= covered <= 0.99


def test_the_factor_is_the_same_on_both_sides_of_a_rectangle():
    assert factor(estimate(-1.2 - 1e-12)) == pytest.approx(factor(estimate(-1.2)), rel=1e-5)


@pytest.mark.parametrize("seed", range(12))
def test_the_interval_of_a_random_budget_holds_95_per_cent(seed):
    """Rectangles, and a scatter that is estimated from few values again in each trial."""
    rng = np.random.default_rng(seed)
    widths = rng.exponential(1.0, rng.integers(1, 6))
    scatter, dof = rng.exponential(0.5), float(rng.choice([9, 29, 100]))
    variance = float(np.sum(widths**2))
    error = sum(w * sqrt(3) * rng.uniform(-1, 1, TRIALS) for w in widths)
    error = error + rng.normal(0, scatter, TRIALS)
    s = scatter * np.sqrt(rng.chisquare(dof, 200) / dof)

    covered = [np.mean(np.abs(error) <= expanded(_budget(widths, variance, u, dof))) for u in s]

    assert np.mean(covered) == pytest.approx(0.95, abs=0.008)


def _budget(widths, variance, s, dof):
    u = sqrt(variance + s**2)
    kurtosis = excess_kurtosis([*((w, "rectangular") for w in widths), (s, "t")], u)
    return Estimate(0.0, u, u**4 / (s**4 / dof), kurtosis=kurtosis)


@pytest.mark.parametrize(
    ("kurtosis", "dof"), [(0, inf), (0, 9), (-1.5, inf), (-1.2, inf), (-0.5, 40), (-1, 12)]
)
def test_the_probability_belongs_to_the_interval(kurtosis, dof):
    one = replace(estimate(kurtosis, dof), value=2.0, u=0.3)
    assert cumulative(one, 2.0 + expanded(one)) == pytest.approx(0.975, abs=1e-9)
    assert cumulative(one, 2.0 - expanded(one)) == pytest.approx(0.025, abs=1e-9)
    assert cumulative(one, 2.0) == pytest.approx(0.5)
    assert (cumulative(one, -inf), cumulative(one, inf)) == (0.0, 1.0)
    assert cumulative(one, 100.0) == pytest.approx(1.0)


@pytest.mark.parametrize("dof", [1.5, 2.0, 4.0, 30.0])
def test_few_degrees_of_freedom_give_a_bounded_sum_their_tails(dof):
    below, above = (estimate(kurtosis, dof) for kurtosis in (-0.9e-3, -1.1e-3))
    for limit in (-4.0, -2.0, -0.5, 3.0, 5.0, 20.0):
        assert cumulative(above, limit) == pytest.approx(cumulative(below, limit), rel=0.02)


@pytest.mark.parametrize("z", [-12.0, -8.0, -6.0, -2.0])
def test_the_tail_of_three_readings_with_a_small_bounded_error(z):
    half = 0.2 * sqrt(3)  # of a rectangle beside t-distributed scatter of scale 1, dof 2
    grid = np.linspace(-half, half, 2001)
    exact = float(np.mean(t.cdf(z - grid, 2)))

    u = sqrt(1 + 0.2**2)
    one = Estimate(0.0, u, 2 * u**4, kurtosis=excess_kurtosis([(0.2, "rectangular")], u))

    assert cumulative(one, z) == pytest.approx(exact, rel=0.25)


def test_a_model_tells_the_shape_of_its_measurand():
    inputs = (
        Input("gain", 0.0, 3.0, distribution=Distribution.RECTANGULAR),
        Input("scatter", 0.0, 4.0, 9.0, Distribution.T),
    )
    model = MeasurementModel(inputs, Corrected(1.0, tuple(Effect(each, 1.0) for each in inputs)))
    combined = propagate(model).estimate
    assert combined.u == pytest.approx(5.0)
    assert combined.kurtosis == pytest.approx(-1.2 * 3**4 / 5**4)


def test_correlated_inputs_pass_for_normal_ones():
    inputs = tuple(Input(name, 0.0, 1.0, distribution=Distribution.RECTANGULAR) for name in "ab")
    correlation = np.array([[1.0, 0.5], [0.5, 1.0]])
    equation = Corrected(1.0, tuple(Effect(each, 1.0) for each in inputs))
    assert propagate(MeasurementModel(inputs, equation, correlation)).estimate.kurtosis == 0.0
