from __future__ import annotations

from dataclasses import replace

import pytest

from rigrunner.api.instruments import Instrument
from rigrunner_bearings.torque.analysis import with_known_load
from unit.analysis.helpers_analysis import RIG, run_of

CELL = {
    "channel": "tester.load",
    "serial": "LC-3",
    "measures": "force",
    "range": {"max": "3 kN"},
}


def tolerance(loads=(1000.0,), torque="tester.torque", **cell):
    register = {"tester.load": Instrument.model_validate(CELL | cell)} if cell else {}
    run = replace(run_of(), instruments=register)
    return with_known_load(run, torque, loads).load_tolerance


@pytest.mark.parametrize(
    ("accuracy", "expected"), [("0.5 % FS", 0.015), ("1 % reading", 0.01), ("4 N", 0.004)]
)
def test_register_gives_load_tolerance(accuracy, expected):
    assert tolerance(accuracy=accuracy) == pytest.approx(expected)


def test_smallest_load_has_largest_relative_tolerance():
    assert tolerance((2000.0, 500.0, 0.0), accuracy="4 N") == pytest.approx(0.008)


def test_calibration_points_give_tolerance_without_accuracy():
    points = [{"applied": "1 kN", "indicated": "1.002 kN", "U": "3 N"}]
    assert tolerance(points=points) == pytest.approx(0.005)


def test_station_gives_tolerance_without_instrument():
    assert tolerance() == RIG.load_tolerance == 0.005
    assert tolerance(torque="other.torque", accuracy="4 N") == RIG.load_tolerance
    assert tolerance((0.0,), accuracy="4 N") == RIG.load_tolerance
    assert tolerance(id="no accuracy") == RIG.load_tolerance
