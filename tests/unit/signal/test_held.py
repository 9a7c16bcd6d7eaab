from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.signal import blocks
from rigrunner.signal.held import longest_held


def by_hand(values, parts):
    """Return the same sample by sample."""
    longest, at = [1] * parts, 0
    for _, run in groupby(values):
        count = len(list(run))
        part = min(int(at / (len(values) / parts)), parts - 1)
        longest[part] = max(longest[part], count)
        at += count
    return longest


@pytest.mark.parametrize("block", [2, 3, 1 << 21])
@given(
    values=st.lists(st.sampled_from([0.0, 1.0, 2.0]), min_size=1, max_size=40),
    parts=st.integers(1, 5),
)
def test_runs_of_equal_samples(block, values, parts):
    parts = min(parts, len(values))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "BLOCK", block)
        found = longest_held(np.array(values), parts)
    assert found.tolist() == by_hand(values, parts)
