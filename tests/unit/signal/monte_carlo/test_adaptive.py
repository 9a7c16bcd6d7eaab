"""The adaptive procedure: when it stops, and that a seed names the values."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from rigrunner.api.errors import DataError
from rigrunner.signal.monte_carlo import adaptive
from rigrunner.signal.monte_carlo.adaptive import BLOCK, Adaptive, propagate
from rigrunner.signal.monte_carlo.intervals import (
    intervals,
    numerical_tolerance,
    ranked,
    symmetric,
)


def normal(rng, n):
    return rng.normal(5.0, 0.11, n)


def test_stops_once_the_results_stay():
    """2 s of every result must be below the tolerance; the ends of the interval are the last."""
    loose = propagate(normal, Adaptive(digits=1, least_trials=BLOCK, tolerance_share=1.0))
    tight = propagate(normal, Adaptive(digits=2, least_trials=BLOCK, tolerance_share=0.5))
    assert loose.trials == 2 * BLOCK
    assert tight.stable
    assert tight.trials > loose.trials
    # the end's standard error at n trials: sqrt(p (1 - p)/n)/density; solved for half of 0.005/2
    density = stats.norm.pdf(1.959964) / 0.11
    enough = 0.025 * 0.975 / (density * 0.25 * 0.005) ** 2
    assert tight.trials == pytest.approx(enough, rel=0.6)
    assert abs(tight.symmetric.high - (5 + 1.959964 * 0.11)) < 0.005


def test_never_below_the_least_nor_beyond_the_most():
    few = Adaptive(digits=1, least_trials=5 * BLOCK, tolerance_share=1.0)
    assert propagate(normal, few).trials == 5 * BLOCK
    never = propagate(normal, Adaptive(digits=2, least_trials=BLOCK, most_trials=4 * BLOCK))
    assert (never.trials, never.stable) == (4 * BLOCK, False)


def test_a_seed_names_the_values_and_further_blocks_only_add():
    def keeping(drawn):
        def output(rng, n):
            drawn.append(rng.normal(size=n))
            return drawn[-1]

        return output

    first, second = [], []
    propagate(keeping(first), Adaptive(least_trials=3 * BLOCK, most_trials=3 * BLOCK))
    propagate(keeping(second), Adaptive(least_trials=5 * BLOCK, most_trials=5 * BLOCK))
    assert np.array_equal(first, second[:3])
    assert not np.array_equal(second[0], second[1])
    other = propagate(normal, Adaptive(seed=2, most_trials=10**6))
    assert other.mean != propagate(normal, Adaptive(seed=1, most_trials=10**6)).mean


def test_the_deviation_of_all_values_is_that_of_their_blocks_together():
    """The law of total variance."""
    values = np.array([[3.0, 7.0, 3.0, 7.0], [8.0, 16.0, 8.0, 16.0]])
    statistics = [(float(value.mean()), float(value.std())) for value in values]
    assert adaptive._pooled_u(statistics) == pytest.approx(values.std())


def test_a_constant_has_no_uncertainty():
    result = propagate(lambda _, n: np.full(n, 2.0), Adaptive(least_trials=BLOCK))
    assert (result.mean, result.u, result.stable, result.trials) == (2.0, 0.0, True, 2 * BLOCK)


def test_values_that_are_not_finite():
    with pytest.raises(DataError, match="no finite value in 1 of 10000"):
        propagate(lambda _, n: np.r_[np.inf, np.ones(n - 1)], Adaptive())


def test_intervals_of_an_exponential():
    """The shortest begins at the density's peak; the symmetric one leaves 2.5 % on either side."""
    ordered = stats.expon.ppf((np.arange(100_000) + 0.5) / 100_000)
    even, short = intervals([ordered], 0.95)
    assert (short.low, short.high) == (
        pytest.approx(0.0, abs=1e-4),
        pytest.approx(-np.log(0.05), rel=1e-3),
    )
    assert even.low == pytest.approx(-np.log(0.975), rel=1e-2)
    assert even.high == pytest.approx(-np.log(0.025), rel=1e-3)


@pytest.mark.parametrize("p", [0.0, 0.5, 0.9545, 0.99, 1.0])
@pytest.mark.parametrize("n", [1, 2, 999, 1000])
@pytest.mark.parametrize("digits", [1, 12])
def test_intervals_of_blocks_are_those_of_all_their_values(p, n, digits):
    """JCGM 101, 7.7.2 and 7.7.3 by the letter; few digits make many values equal."""
    values = np.random.default_rng(5).gamma(2.0, size=(7, n)).round(digits)
    values[3] += 4.0  # the blocks need not be alike
    ordered, q = np.sort(values, axis=None), min(round(p * values.size), values.size - 1)
    r = (values.size - q) // 2
    even, short = intervals([ranked(value, p) for value in values], p)
    alone = ranked(values.ravel(), p)
    assert symmetric(alone, p) == intervals([alone], p).symmetric == even
    assert (even.low, even.high) == (ordered[r], ordered[r + q])
    widths = [ordered[k + q] - ordered[k] for k in range(values.size - q)]
    assert short.high - short.low == min(widths)
    assert short.low == ordered[widths.index(min(widths))]


def test_mean_and_deviation_of_blocks_are_those_of_all_their_values():
    drawn = []

    def output(rng, n):
        drawn.append(rng.gamma(2.0, size=n) + 1e6)
        return drawn[-1]

    propagated = propagate(output, Adaptive(least_trials=3 * BLOCK, most_trials=3 * BLOCK))
    assert propagated.mean == pytest.approx(np.mean(drawn), rel=1e-15)
    assert propagated.u == pytest.approx(np.std(drawn, ddof=1), rel=1e-9)


def test_tolerance_of_no_uncertainty():
    assert numerical_tolerance(0.0, 2) == 0.0
