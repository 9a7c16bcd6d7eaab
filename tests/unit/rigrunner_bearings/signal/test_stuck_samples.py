from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.frame import allocated_peak
from helpers_long import short_blocks
from rigrunner_bearings.signal.stuck_samples import longest_at, longest_stuck


def by_hand(values, parts):
    """Return the same sample by sample."""
    longest, start = [1] * parts, 0
    for _, run in groupby(values):
        count = len(list(run))
        part = min(int(start / (len(values) / parts)), parts - 1)
        longest[part] = max(longest[part], count)
        start += count
    return longest


@pytest.mark.parametrize("block", [2, 3, 1 << 21])
@given(
    values=st.lists(st.sampled_from([0.0, 1.0, 2.0]), min_size=1, max_size=40),
    parts=st.integers(1, 5),
)
def test_longest_runs_of_equal_samples(block, values, parts):
    parts = min(parts, len(values))
    with pytest.MonkeyPatch.context() as patch:
        short_blocks(patch, block)
        longest = longest_stuck(np.array(values), parts)
        ends = longest_at(np.array(values), [min(values), max(values)])
    assert longest.tolist() == by_hand(values, parts)
    extremes = min(values), max(values)
    assert ends == max(len([*run]) for value, run in groupby(values) if value in extremes)


def test_memory_does_not_grow_with_length_of_run(monkeypatch):
    short_blocks(monkeypatch, 10_000)
    still = np.zeros(1_000_000)
    assert allocated_peak(lambda: longest_stuck(still, 7)) < 20 * 10_000 * 8
    assert longest_stuck(still, 7).tolist() == [1_000_000, *[1] * 6]
