"""JCGM 101:2008, clause 9: the guide's own examples, recomputed from its inputs.

The intervals are the shortest ones, as in the guide's tables. If an example has an exact
solution, it is compared with that too, more closely than the printed digits allow.
"""

from __future__ import annotations

from math import inf, log, sqrt

import numpy as np
import pytest

from rigrunner.api.data import Estimate
from rigrunner.signal.monte_carlo import distributions as d
from rigrunner.signal.monte_carlo.adaptive import Adaptive, propagate
from rigrunner.signal.monte_carlo.agreement import difference, gum_interval, tolerance

MILLION = Adaptive(least_trials=1_000_000, most_trials=1_000_000)


def sum_of(*parts):
    return lambda rng, n: np.sum([part.draw(rng, n) for part in parts], axis=0)


def rectangular(u):
    return d.Rectangular(0.0, sqrt(3) * u)


def ends(interval):
    return [interval.low, interval.high]


def test_9_2_2_sum_of_four_normal():
    """y 0.00, u 2.00, [-3.92, 3.92]; GUM and Monte Carlo agree."""
    result = propagate(sum_of(*[d.Normal(0.0, 1.0)] * 4), MILLION)
    assert result.mean == pytest.approx(0.0, abs=0.01)
    assert result.u == pytest.approx(2.00, abs=0.005)
    assert ends(result.shortest) == pytest.approx([-3.92, 3.92], abs=0.05)
    assert ends(result.symmetric) == pytest.approx([-3.92, 3.92], abs=0.02)


def test_9_2_3_sum_of_four_rectangular():
    """u 2.00, [-3.88, 3.88]; exactly 2 sqrt 3 (2 - (3/5)^(1/4)) = 3.8794."""
    result = propagate(sum_of(*[rectangular(1.0)] * 4), MILLION)
    assert result.u == pytest.approx(2.00, abs=0.005)
    assert ends(result.shortest) == pytest.approx([-3.88, 3.88], abs=0.05)
    exact = 2 * sqrt(3) * (2 - (3 / 5) ** 0.25)
    assert exact == pytest.approx(3.88, abs=0.005)
    assert ends(result.symmetric) == pytest.approx([-exact, exact], abs=0.015)


def test_9_2_3_gum_agrees_with_one_digit_only():
    """d is 0.04, which is within 0.5 (one digit of u = 2), but beyond 0.05 (two)."""
    gum = Estimate(0.0, 2.0, inf)
    result = propagate(sum_of(*[rectangular(1.0)] * 4), MILLION)
    distance = difference(gum_interval(gum), result.symmetric)
    assert distance.low == pytest.approx(0.04, abs=0.015)
    assert distance.within(tolerance(gum, digits=1))
    assert tolerance(gum, digits=1) == 0.5
    assert tolerance(gum, digits=2) == 0.05


def test_9_2_4_one_rectangle_ten_times_wider():
    """u 10.1, Monte Carlo [-17.0, 17.0], GUM [-19.9, 19.9]: they do not agree."""
    result = propagate(sum_of(*[rectangular(1.0)] * 3, rectangular(10.0)), MILLION)
    assert result.u == pytest.approx(10.1, abs=0.06)
    assert ends(result.symmetric) == pytest.approx([-17.0, 17.0], abs=0.05)
    assert ends(result.shortest) == pytest.approx([-17.0, 17.0], abs=0.15)
    gum = Estimate(0.0, sqrt(103), inf)
    assert ends(gum_interval(gum)) == pytest.approx([-19.9, 19.9], abs=0.05)
    assert not difference(gum_interval(gum), result.symmetric).within(tolerance(gum, digits=2))


def mass_deviation(rng, n):
    """The deviation in mg of a weight of 100 g, calibrated in air."""
    reference = d.Normal(100_000.000, 0.050).draw(rng, n)
    added = d.Normal(1.234, 0.020).draw(rng, n)
    air = d.Rectangular(1.20, 0.10).draw(rng, n)
    weight = d.Rectangular(8.0e3, 1.0e3).draw(rng, n)
    standard = d.Rectangular(8.00e3, 0.05e3).draw(rng, n)
    buoyancy = 1 + (air - 1.2) * (1 / weight - 1 / standard)
    return (reference + added) * buoyancy - 100_000.0


def test_9_3_mass_calibration():
    """Monte Carlo 1.2341 mg, u 0.0754 mg, [1.0834, 1.3825] mg; first-order GUM u 0.0539.

    The two differ by d_low 0.0451 mg and d_high 0.0430 mg, far beyond 0.005 mg (one digit).
    """
    result = propagate(mass_deviation, MILLION)
    assert result.mean == pytest.approx(1.2341, abs=3e-4)
    assert result.u == pytest.approx(0.0754, abs=3e-4)
    assert ends(result.shortest) == pytest.approx([1.0834, 1.3825], abs=5e-3)
    first_order = Estimate(1.2340, sqrt(0.050**2 + 0.020**2), inf)
    assert first_order.u == pytest.approx(0.0539, abs=5e-5)
    gum = gum_interval(first_order)
    assert ends(gum) == pytest.approx([1.1285, 1.3395], abs=1e-4)
    distance = difference(gum, result.shortest)
    assert [distance.low, distance.high] == pytest.approx([0.0451, 0.0430], abs=5e-3)
    assert not distance.within(tolerance(first_order, digits=1))


def comparison_loss(x1, correlation):
    """X1^2 + X2^2 of two normal quantities of u = 0.005."""
    mean, covariance = (
        np.array([x1, 0.0]),
        0.005**2 * np.array([[1, correlation], [correlation, 1]]),
    )
    inputs = d.MultivariateNormal(mean, covariance)
    return lambda rng, n: np.sum(inputs.draw(rng, n) ** 2, axis=1)


@pytest.mark.parametrize(
    ("x1", "correlation", "y", "u", "low", "high"),
    [
        (0.000, 0.0, 50, 50, 0, 150),
        (0.010, 0.0, 150, 112, 0, 367),
        (0.050, 0.0, 2551, 502, 1590, 3543),
        (0.000, 0.9, 50, 67, 0, 185),
        (0.010, 0.9, 150, 121, 13, 398),
        (0.050, 0.9, 2551, 504, 1628, 3555),
    ],
)
def test_9_4_comparison_loss(x1, correlation, y, u, low, high):  # noqa: PLR0917  (a table's row)
    """Monte Carlo, shortest interval, all in 1e-6.

    Exactly, by the moments of normal quantities: u^2 = 4 x1^2 u1^2 + 4 u1^4 (1 + r^2).
    """
    u1 = 0.005
    assert 1e6 * sqrt(4 * x1**2 * u1**2 + 4 * u1**4 * (1 + correlation**2)) == pytest.approx(
        u, abs=0.6
    )
    result = propagate(comparison_loss(x1, correlation), MILLION)
    assert 1e6 * result.mean == pytest.approx(y, abs=1.5)
    assert 1e6 * result.u == pytest.approx(u, abs=1)
    assert 1e6 * result.shortest.high == pytest.approx(high, abs=0.01 * high + 3)
    assert 1e6 * result.shortest.low == pytest.approx(low, abs=0.01 * high + 3)


def test_9_4_2_exact_at_zero():
    """At x1 = x2 = 0 the loss is exponential; 95 % are below -2 u^2 ln 0.05."""
    result = propagate(comparison_loss(0.0, 0.0), MILLION)
    assert result.mean == pytest.approx(2 * 0.005**2, rel=0.005)
    assert result.shortest.low == pytest.approx(0.0, abs=1e-6)
    assert result.shortest.high == pytest.approx(-2 * 0.005**2 * log(0.05), rel=0.01)


def gauge_block(rng, n):
    """The block's length less the nominal one, in nm."""
    standard = d.ScaledT(50_000_623.0, 25.0, 18).draw(rng, n)
    read = d.ScaledT(215.0, 6.0, 24).draw(rng, n)
    random = d.ScaledT(0.0, 4.0, 5).draw(rng, n)
    systematic = d.ScaledT(0.0, 7.0, 8).draw(rng, n)
    expansion = d.Rectangular(11.5e-6, 2.0e-6).draw(rng, n)
    room = d.Normal(-0.1, 0.2).draw(rng, n) + d.Arcsine(0.0, 0.5).draw(rng, n)
    other_expansion = d.CurvilinearTrapezoid(0.0, 1.0e-6, 0.1e-6).draw(rng, n)
    other_temperature = d.CurvilinearTrapezoid(0.0, 0.050, 0.025).draw(rng, n)
    warmth = other_expansion * room + expansion * other_temperature
    return standard + read + random + systematic - standard * warmth - 50_000_000.0


def test_9_5_gauge_block():
    """838 nm, u 36 nm, shortest 99 % interval [745, 932] nm."""
    ninety_nine = Adaptive(least_trials=1_000_000, most_trials=1_000_000, p=0.99)
    result = propagate(gauge_block, ninety_nine)
    assert result.mean == pytest.approx(838, abs=0.5)
    assert result.u == pytest.approx(36, abs=0.5)
    assert ends(result.shortest) == pytest.approx([745, 932], abs=2)


def test_7_9_2_numerical_tolerance():
    """The examples of 7.9.2: u = 0.00035 g of two digits, and u = 2 K of one; then rounding up."""
    assert tolerance(Estimate(0.0, 0.00035), digits=2) == pytest.approx(0.000005)
    assert tolerance(Estimate(0.0, 2.0), digits=1) == pytest.approx(0.5)
    assert tolerance(Estimate(0.0, 0.0996), digits=2) == pytest.approx(0.005)
    assert tolerance(Estimate(0.0, 0.0994), digits=2) == pytest.approx(0.0005)
