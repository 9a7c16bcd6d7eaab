"""Channels with readings beyond the range of their calibration."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from rigrunner.analysis.analyse import _beyond_calibration
from rigrunner.api.data import ZeroReading


class Calibrated:
    """A channel with a calibration from 0 to 10."""

    def __init__(self, channel, quantity):
        self.channel = channel
        self.quantity = quantity
        self.checked = []

    def beyond_range(self, low, high, unit):
        self.checked.append((low, high, unit))
        return "" if low >= 0 and high <= 10 else f"{low:g} to {high:g} {unit}"


UNITS = dict.fromkeys(("rig.force", "rig.depth"), "N")


def excesses(rows=(), recordings=(), *, quantity="pressure", zero=0.0):
    """Return the channels of a run beyond their range, and the checked ranges by channel."""
    channels = {name: Calibrated(name, quantity) for name in ("rig.force", "rig.depth")}
    run = SimpleNamespace(
        instruments=channels,
        measurements=[
            SimpleNamespace(values=values, units=UNITS, recording="", zeros={}) for values in rows
        ],
        recordings=[
            SimpleNamespace(
                name="001",
                channels={"rig.force": np.array(samples)},
                samples=len(samples),
                units={"rig.force": "kN"},
            )
            for samples in recordings
        ],
        zero_of=lambda _part, _channel: ZeroReading(zero),
    )
    beyond = list(_beyond_calibration(run))
    return beyond, {name: channel.checked for name, channel in channels.items()}


def test_range_covers_single_values_and_samples():
    beyond, checked = excesses([{"rig.force": 3.0}, {"rig.force": 5.0}], [[1.0, 12.0], [-2.0, 4.0]])
    assert checked == {"rig.force": [(-2.0, 12.0, "kN")], "rig.depth": []}
    assert beyond == [("rig.force", "-2 to 12 kN")]


def test_statistics_of_samples_are_checked():
    beyond, _ = excesses(
        [{"rig.force.minimum": -1.0, "rig.force.maximum": 4.0, "rig.force.rms": 20.0}]
    )
    assert beyond == [("rig.force", "-1 to 4 N")]


def test_channels_within_range_or_without_readings_are_not_reported():
    beyond, checked = excesses([{"rig.force": 0.0}, {"rig.depth": 10.0}])
    assert beyond == []
    assert checked == {"rig.force": [(0.0, 0.0, "N")], "rig.depth": [(10.0, 10.0, "N")]}
    assert excesses([], [[]]) == ([], {"rig.force": [], "rig.depth": []})


def test_zero_is_subtracted_from_a_force_but_not_from_a_pressure():
    _, checked = excesses([{"rig.force": 12.0}], [[7.0, 14.0]], quantity="force", zero=5.0)
    assert checked["rig.force"] == [(2.0, 9.0, "kN")]
    _, checked = excesses([{"rig.force": 12.0}], [[7.0, 14.0]], zero=5.0)
    assert checked["rig.force"] == [(7.0, 14.0, "kN")]
