from dataclasses import replace

import pytest

from rigrunner.api.errors import DataError
from rigrunner_bearings.compensations.matching import pairs
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import FEW, sweep_of


@pytest.fixture(scope="module")
def sweep():
    return sweep_of(RigParameters(), FEW)


def test_pairs_by_measured_not_entered_frequency(sweep):
    mislabelled = tuple(replace(point, set_frequency_hz=99.0) for point in sweep.no_load)
    shuffled = replace(sweep, no_load=mislabelled[::-1])
    for loaded, no_load in pairs(shuffled.loaded, shuffled.no_load, 0.001):
        assert no_load.frequency_hz.value == pytest.approx(loaded.frequency_hz.value, rel=1e-4)


def test_missing_partner_lists_available_frequencies(sweep):
    short = replace(sweep, no_load=sweep.no_load[:2])
    with pytest.raises(DataError) as caught:
        pairs(short.loaded, short.no_load, 0.02)
    message = str(caught.value)
    assert "within 2.0% of 10 Hz (10 Hz), 20 Hz (20 Hz), 30 Hz (30 Hz), 35 Hz (35 Hz)" in message
    assert "the no-load run has 1 Hz, 5 Hz" in message
    assert "record the no-load sweep at the same frequencies" in message


def test_empty_no_load_run_is_reported(sweep):
    with pytest.raises(DataError, match="the no-load run has no points"):
        pairs(sweep.loaded, (), 0.02)
