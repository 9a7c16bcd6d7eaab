from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.signal.extremes import CACHED, extremes


@given(
    samples=st.integers(2, 3 * CACHED),
    cuts=st.sets(st.one_of(st.integers(1, 3 * CACHED), st.integers(-2, 2)), max_size=60),
    seed=st.integers(0, 9),
)
def test_each_part_has_its_own_least_and_greatest(samples, cuts, seed):
    values = np.random.default_rng(seed).standard_normal(samples)
    near_cache = {cut + CACHED for cut in cuts if cut < 9}
    edges = np.array(sorted({0, samples} | {c for c in cuts | near_cache if 0 < c < samples}))
    least, greatest = extremes(values, edges)
    parts = [values[a:b] for a, b in itertools.pairwise(edges)]
    assert least.tolist() == [part.min() for part in parts]
    assert greatest.tolist() == [part.max() for part in parts]


def test_what_lies_before_the_first_edge_and_behind_the_last_does_not_count():
    values = np.array([9.0, 1.0, 2.0, 3.0, -9.0])
    assert [each.tolist() for each in extremes(values, np.array([1, 3, 4]))] == [[1, 3], [2, 3]]


def test_no_part_has_no_extremes():
    assert [len(extreme) for extreme in extremes(np.ones(4), np.array([2]))] == [0, 0]
