from __future__ import annotations

import numpy as np
import pytest

from rigrunner_bearings.study.share import Share, clustered, rate_interval


def test_values_that_agree_within_a_rig_count_once():
    """Ten rigs of eight values, all within U or none: as uncertain as ten values."""
    hits = np.repeat([[1.0]] * 9 + [[0.0]], 8, axis=1)
    rate = clustered(hits)
    assert rate.rate == pytest.approx(0.9)
    assert rate.effective == pytest.approx(9.0)  # with n - 1 in the variance
    assert rate.interval[0] < Share(72, 80).interval[0]


def test_independent_values_count_separately():
    rng = np.random.default_rng(1)
    rate = clustered((rng.random((2000, 8)) < 0.95).astype(float))
    assert rate.effective == pytest.approx(16000, rel=0.1)


def test_full_coverage_counts_each_rig_once():
    assert clustered(np.ones((30, 8))).interval == Share(30, 30).interval


def test_single_rig_is_one_value():
    assert clustered(np.array([[1.0, 0.0]])).effective == 1.0


def test_interval_has_stated_coverage():
    """Rigs with different rates: the pooled interval contains the true rate in about 95 %."""
    rng = np.random.default_rng(2)
    hits = 0
    for _ in range(400):
        rates = rng.beta(9, 1, size=(100, 1))
        low, high = clustered((rng.random((100, 8)) < rates).astype(float)).interval
        hits += low <= 0.9 <= high
    assert 0.92 <= hits / 400 <= 0.99


def test_interval_without_hits_begins_at_zero():
    assert rate_interval(0, 10)[0] == 0.0
