"""What the station allows of its drives, at the moment of setting; and standing still."""

from __future__ import annotations

from contextlib import nullcontext

import pytest

from helpers_devices import FakeTester
from helpers_pausing import Patient
from rigrunner.api.errors import DeviceLostError, DeviceRejectedError
from rigrunner.api.quantity import parse_quantity
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig
from rigrunner.station.drive_rules import DriveRules
from rigrunner.station.limits import Combination, DriveLimits


def quantities(**values: str):
    return {f"tester.{name}": parse_quantity(text) for name, text in values.items()}


PAIR = Combination(
    allowed=(quantities(load="1 kN", frequency="35 Hz"), quantities(load="2 kN", frequency="5 Hz"))
)


def rig_of(device, **rules):
    rig = Rig({"tester": device}, SimulatedClock(), rules=DriveRules(**rules))
    rig.connect()
    return rig


def test_a_narrower_range_never_lets_the_set_point_through():
    device = FakeTester()
    rig = rig_of(device, drives={"tester.load": DriveLimits(max="500 N")})
    with pytest.raises(DeviceRejectedError, match=r"load cannot be set to 600 N .*0 to 500 N"):
        rig.set("tester", "load", 600.0)
    assert device.calls == ["connect"]


@pytest.mark.parametrize(
    ("load", "frequency", "allowed"),
    [
        (1000.0, 35.0, True),
        (1001.0, 35.0, False),
        (2000.0, 5.0, True),
        (2000.0, 5.1, False),
        (2001.0, 0.0, False),
    ],
)
def test_drives_may_go_together_up_to_one_of_the_corners(load, frequency, allowed):
    device = FakeTester(drives_at={"load": 0.0, "frequency": 0.0})
    rig = rig_of(device, combinations=(PAIR,))
    corner = "tester.load up to 1 kN with tester.frequency up to 35 Hz"
    with nullcontext() if allowed else pytest.raises(DeviceRejectedError, match=corner):
        rig.set("tester", "load", load)
        rig.set("tester", "frequency", frequency)
    assert (device.drives_at["frequency"] == frequency) is (allowed or frequency == 0.0)


def test_a_drive_that_nobody_has_set_counts_as_it_reads_back():
    device = FakeTester(drives_at={"load": 1900.0, "frequency": 0.0})
    with pytest.raises(DeviceRejectedError, match=r"tester\.load at 1900"):
        rig_of(device, combinations=(PAIR,)).set("tester", "frequency", 10.0)


def test_a_drive_that_cannot_be_read_back_lets_no_other_one_move():
    def lost(call):
        if call == "read_back load":
            raise DeviceLostError("cable")

    device = FakeTester(before=lost)
    with pytest.raises(DeviceLostError):
        rig_of(device, combinations=(PAIR,)).set("tester", "frequency", 1.0)
    assert "set frequency 1" not in device.calls


def test_a_slower_rate_is_known_and_a_faster_one_is_the_devices():
    rig = rig_of(FakeTester(), drives={"tester.load": DriveLimits(rate="100 N/s")})
    assert rig.led_rate_per_s("tester", "load") == 100.0
    assert rig.led_rate_per_s("tester", "frequency") is None
    faster = rig_of(FakeTester(), drives={"tester.load": DriveLimits(rate="2000 kN/s")})
    assert faster.led_rate_per_s("tester", "load") is None


def test_what_stands_still_goes_on_and_what_cannot_says_where_it_stays():
    patient, other = Patient(), FakeTester()
    rig = Rig({"tester": patient, "press": other}, SimulatedClock())
    rig.connect()
    rig.set("tester", "frequency", 20.0)
    rig.set("press", "load", 500.0)
    assert rig.pause() == ["press cannot pause: load stays at 500 N"]
    assert patient.drives_at["frequency"] == 0.0
    rig.resume()
    assert patient.drives_at["frequency"] == 20.0


def test_what_was_made_safe_is_not_gone_on_with():
    patient = Patient()
    rig = rig_of(patient)
    rig.pause()
    rig.make_safe()
    rig.resume()
    assert "resume" not in patient.calls
