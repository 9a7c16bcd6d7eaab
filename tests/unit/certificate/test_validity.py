"""Which readings lie beyond the range of their calibration, where no analysis names instruments."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from rigrunner.certificate import validity


class Calibrated:
    """A channel that was calibrated from 0 to 10."""

    def __init__(self, channel):
        self.channel = channel
        self.asked = []

    def beyond_range(self, low, high, unit):
        self.asked.append((low, high, unit))
        return "" if low >= 0 and high <= 10 else f"{low:g} to {high:g} {unit}"


@pytest.fixture
def found(monkeypatch):
    """Return the deviations of a run, and what its channels were asked."""
    monkeypatch.setattr(validity, "certified_of", lambda _result: [])

    def of(rows=(), recordings=(), *, others=("wear",)):
        channels = {name: Calibrated(name) for name in ("rig.force", "rig.depth")}
        run = SimpleNamespace(
            run_id="R-1",
            instruments=channels,
            measurements=[
                SimpleNamespace(values=values, units=dict.fromkeys(values, "N")) for values in rows
            ],
            recordings=[
                SimpleNamespace(
                    channels={"rig.force": np.array(samples)},
                    samples=len(samples),
                    units={"rig.force": "kN"},
                )
                for samples in recordings
            ],
        )
        result = SimpleNamespace(run=run, other_results=others)
        told = [(each.kind, each.where, each.text) for each in validity.not_calibrated(result)]
        return told, {name: each.asked for name, each in channels.items()}

    return of


def test_single_values_and_samples_of_a_channel_count_together(found):
    told, asked = found([{"rig.force": 3.0}, {"rig.force": 5.0}], [[1.0, 12.0], [-2.0, 4.0]])
    assert asked == {"rig.force": [(-2.0, 12.0, "kN")], "rig.depth": []}
    assert told == [("range", "rig.force", "-2 to 12 kN")]


def test_what_lies_within_the_range_and_what_was_not_read_is_no_deviation(found):
    told, asked = found([{"rig.force": 0.0}, {"rig.depth": 10.0}])
    assert told == []
    assert asked == {"rig.force": [(0.0, 0.0, "N")], "rig.depth": [(10.0, 10.0, "N")]}
    assert found([], [[]]) == ([], {"rig.force": [], "rig.depth": []})


def test_a_run_whose_results_all_name_their_instruments_is_not_looked_at_again(found):
    assert found([{"rig.force": 99.0}], others=()) == ([], {"rig.force": [], "rig.depth": []})
