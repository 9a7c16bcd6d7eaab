from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helpers_long import short_blocks
from helpers_thorough import examples
from rigrunner.signal import order
from rigrunner.signal.blocks import blocks
from rigrunner.signal.order import median, percentiles

VALUES = st.one_of(
    st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=2, max_size=300),
    st.lists(st.sampled_from([-1.0, 0.0, 1.0, 1e-300]), min_size=2, max_size=300),
)


@pytest.mark.parametrize("kept", [1 << 21, 3])
@given(values=VALUES, percent=st.lists(st.floats(0, 100), min_size=1, max_size=3))
@settings(
    max_examples=examples(15),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_order_statistics_in_parts_are_those_of_the_whole(monkeypatch, kept, values, percent):
    array = np.array(values)
    expected = np.percentile(array, percent).tolist(), float(np.median(array))
    short_blocks(monkeypatch, 10)
    monkeypatch.setattr(order, "KEPT", kept)
    computed = (
        percentiles(array, percent),
        median(lambda: (part for _, part in blocks(array)), len(array)),
    )
    assert computed == expected
