"""Statistics computed block by block equal those of all samples."""

from __future__ import annotations

from math import fsum, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.limits import STATISTICS
from rigrunner.signal.sample_statistics import SampleStatistics

samples = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=200)


def statistics_of(values, cuts):
    statistics = SampleStatistics()
    for part in np.split(np.array(values), sorted(cuts)):
        statistics.take(part)
    return statistics.by_name()


@given(samples, st.lists(st.integers(0, 200), max_size=5))
def test_statistics_do_not_depend_on_block_cuts(values, cuts):
    statistics = statistics_of(values, [cut for cut in cuts if cut <= len(values)])
    assert tuple(statistics) == STATISTICS
    assert (statistics["minimum"], statistics["maximum"]) == (min(values), max(values))
    assert statistics["peak_to_peak"] == max(values) - min(values)
    scale = max(map(abs, values))
    mean = fsum(values) / len(values)
    assert statistics["mean"] == pytest.approx(mean, rel=1e-12, abs=1e-12 * scale)
    squares = sqrt(fsum(value * value for value in values) / len(values))
    assert statistics["rms"] == pytest.approx(squares, rel=1e-12, abs=1e-150)


def test_mean_over_many_blocks_keeps_small_parts():
    """A plain sum of 20 000 blocks loses it: 1e9 + 1e-7 has no digit left for more."""
    statistics = SampleStatistics()
    statistics.take(np.array([1e9]))
    for _ in range(20_000):
        statistics.take(np.array([1e-8]))
    statistics.take(np.array([-1e9]))
    assert statistics.by_name()["mean"] * 20_002 == pytest.approx(20_000 * 1e-8, rel=1e-9)


def test_statistics_of_no_samples_are_refused():
    statistics = SampleStatistics()
    statistics.take(np.array([]))
    with pytest.raises(ValueError, match="no sample"):
        statistics.by_name()
