"""Statistics of a recording that have limits, taken block by block."""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner.engine.recorded import RecordedStatistics


def test_statistics_cover_all_blocks_of_their_channel():
    names = ["tester.torque.mean", "tester.torque.maximum", "tester.load.rms"]
    statistics = RecordedStatistics(names)
    for torque, load in (([1.0, 2.0], [3.0, 3.0]), ([6.0, -1.0], [4.0, 4.0])):
        statistics.take({
            "tester.torque": np.array(torque),
            "tester.load": np.array(load),
            "tester.angle": np.array([9.0, 9.0]),
        })  # fmt: skip
    assert statistics.by_name() == {
        "tester.torque.mean": 2.0,
        "tester.torque.maximum": 6.0,
        "tester.load.rms": pytest.approx(12.5**0.5),
    }


def test_statistics_without_samples_are_refused():
    with pytest.raises(DataError, match=r"tester\.torque: there is no sample"):
        RecordedStatistics(["tester.torque.mean"]).by_name()
