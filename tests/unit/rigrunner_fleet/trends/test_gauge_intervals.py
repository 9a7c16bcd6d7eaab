"""Intervals of a gauge study's components, compared with exact ones and by their coverage."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from rigrunner_fleet.trends.gauge_rr import gauge_rr

PARTS, OPERATORS, TRIALS = 10, 3, 3


def readings(rng, part=1.0, operator=0.3, interaction=0.2, repeatability=0.2):
    return (
        part * rng.normal(size=(PARTS, 1, 1))
        + operator * rng.normal(size=(1, OPERATORS, 1))
        + interaction * rng.normal(size=(PARTS, OPERATORS, 1))
        + repeatability * rng.normal(size=(PARTS, OPERATORS, TRIALS))
    )


def study(seed=1, **deviations):
    return gauge_rr(readings(np.random.default_rng(seed), **deviations))


def test_repeatability_interval_is_chi_squared():
    """SS/chi² at 2.5 % and 97.5 % of 60 degrees of freedom."""
    analysis = study()
    assert not analysis.pooled
    squares = analysis.table[3].sum_of_squares
    interval = analysis.known["repeatability"]
    low, high = np.sqrt(squares / stats.chi2.ppf([0.975, 0.025], 60))
    assert (interval.low, interval.high) == pytest.approx((low, high), rel=1e-2)
    assert interval.degrees_of_freedom == 60
    assert interval.confidence == 0.95


def test_components_lie_within_their_intervals():
    analysis = study()
    for name, interval in analysis.known.items():
        assert interval.low <= getattr(analysis.components, name) <= interval.high


def test_degrees_of_freedom_by_satterthwaite():
    """Reproducibility is (MS_o + (p - 1) MS_po - p MS_e)/(p r), by the expected mean squares."""
    analysis = study()
    _, operator, interaction, error, _ = analysis.table
    terms = np.array([
        operator.mean_square / 30, 9 * interaction.mean_square / 30, -10 * error.mean_square / 30,
    ])  # fmt: skip
    assert terms.sum() == pytest.approx(analysis.components.reproducibility**2, rel=1e-12)
    expected = terms.sum() ** 2 / (terms**2 / [2, 18, 60]).sum()
    interval = analysis.known["reproducibility"]
    assert interval.degrees_of_freedom == pytest.approx(expected, rel=1e-12)


def test_pooled_interaction_counts_as_repeatability():
    analyses = (study(seed, interaction=0.0) for seed in range(20))
    analysis = next(analysis for analysis in analyses if analysis.pooled)
    assert "interaction" not in analysis.known
    pooled = analysis.table[2].sum_of_squares + analysis.table[3].sum_of_squares
    interval = analysis.known["repeatability"]
    low, high = np.sqrt(pooled / stats.chi2.ppf([0.975, 0.025], 78))
    assert (interval.low, interval.high) == pytest.approx((low, high), rel=1e-2)
    assert interval.degrees_of_freedom == 78
    assert analysis.known["gauge"].low <= analysis.components.gauge <= analysis.known["gauge"].high


def test_intervals_cover_the_truth_in_95_percent():
    """Of 200 studies 95 % would be 190; with 4 standard deviations of the count, 178 or more."""
    truth = {
        "repeatability": 0.2,
        "operator": 0.3,
        "interaction": 0.2,
        "reproducibility": np.hypot(0.3, 0.2),
        "gauge": np.sqrt(0.3**2 + 0.2**2 + 0.2**2),
        "part": 1.0,
    }
    hits = dict.fromkeys(truth, 0)
    rng, count = np.random.default_rng(7), 0
    while count < 200:
        analysis = gauge_rr(readings(rng))
        if analysis.pooled:
            continue
        count += 1
        for name, value in truth.items():
            hits[name] += analysis.known[name].low <= value <= analysis.known[name].high
    assert min(hits.values()) >= 178, hits


def test_same_study_gives_the_same_intervals():
    assert study().known == study().known
