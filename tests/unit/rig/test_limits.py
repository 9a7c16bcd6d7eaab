"""Limits of a station for its drives when they are set; and pausing."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace

import pytest

from helpers_devices import DRIVES, FakeTester
from rigrunner.api.devices import DriveInfo
from rigrunner.api.errors import DeviceLostError, DeviceRejectedError, DeviceTimeoutError
from rigrunner.api.member import Member
from rigrunner.api.quantity import parse_quantity
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig
from rigrunner.station.drive_rules import DriveRules
from rigrunner.station.limits import Combination, DriveLimits
from unit.engine.helpers_pausing import Patient


def quantities(**values: str):
    return {f"tester.{name}": parse_quantity(text) for name, text in values.items()}


PAIR = Combination(
    allowed=(quantities(load="1 kN", frequency="35 Hz"), quantities(load="2 kN", frequency="5 Hz"))
)


def rig_of(device, **rules):
    rig = Rig({"tester": device}, SimulatedClock(), rules=DriveRules(**rules))
    rig.connect()
    return rig


def test_set_point_out_of_narrower_range_never_reaches_device():
    device = FakeTester()
    rig = rig_of(device, drives={"tester.load": DriveLimits(max="500 N")})
    with pytest.raises(DeviceRejectedError, match=r"load: 600 N is out of range .*0 to 500 N"):
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
def test_drives_may_be_combined_up_to_one_of_the_corners(load, frequency, allowed):
    device = FakeTester(drives_at={"load": 0.0, "frequency": 0.0})
    rig = rig_of(device, combinations=(PAIR,))
    corner = "tester.load up to 1 kN with tester.frequency up to 35 Hz"
    with nullcontext() if allowed else pytest.raises(DeviceRejectedError, match=corner):
        rig.set("tester", "load", load)
        rig.set("tester", "frequency", frequency)
    assert (device.drives_at["frequency"] == frequency) is (allowed or frequency == 0.0)


def test_unset_drive_counts_with_its_read_back():
    device = FakeTester(drives_at={"load": 1900.0, "frequency": 0.0})
    with pytest.raises(DeviceRejectedError, match=r"tester\.load at 1900"):
        rig_of(device, combinations=(PAIR,)).set("tester", "frequency", 10.0)


def test_small_set_points_are_shown_in_smaller_unit():
    tiny = {"stage.x": parse_quantity("500 nm"), "stage.y": parse_quantity("200 nm")}
    info = DriveInfo("x", "m", "X", minimum=0.0, maximum=1e-6, rate_per_s=None)
    rules = DriveRules(combinations=(Combination(allowed=(tiny,)),))
    message = r"x cannot be set to 600 nm with stage\.y at 300 nm"
    with pytest.raises(DeviceRejectedError, match=message):
        rules.check(Member("stage", "x"), info, 6e-7, lambda _: 3e-7)


def test_unreadable_drive_blocks_drives_combined_with_it():
    def lost(call):
        if call == "read_back load":
            raise DeviceLostError("cable")

    device = FakeTester(before=lost)
    with pytest.raises(DeviceLostError):
        rig_of(device, combinations=(PAIR,)).set("tester", "frequency", 1.0)
    assert "set frequency 1" not in device.calls


def test_drive_after_failed_set_counts_with_its_read_back():
    """It may have moved all the same, so its last set-point is not its position."""

    def late(call):
        if call == "read_back load" and device.drives_at["load"] == 1900.0 and not answered:
            answered.append(call)
            raise DeviceTimeoutError("no answer in time")

    answered: list[str] = []
    device = FakeTester(before=late, drives_at={"load": 0.0, "frequency": 0.0})
    rig = rig_of(device, combinations=(PAIR,))
    rig.set("tester", "load", 0.0)
    with pytest.raises(DeviceTimeoutError):
        rig.set("tester", "load", 1900.0)
    with pytest.raises(DeviceRejectedError, match=r"35 Hz with tester\.load at 1900"):
        rig.set("tester", "frequency", 35.0)
    assert device.drives_at["frequency"] == 0.0


@pytest.mark.parametrize(("offset", "agrees"), [(0.5, True), (-0.5, True), (0.625, False)])
def test_read_back_may_deviate_by_whole_tolerance(offset, agrees):
    drive = DriveInfo("load", "N", "radial load", 0.0, 3000.0, tolerance=0.5)
    rig = rig_of(FakeTester(drives=(drive,), read_back_offset=offset))
    raises = pytest.raises(DeviceRejectedError, match="load was set to 10 N but reads back")
    with nullcontext() if agrees else raises:
        assert rig.set("tester", "load", 10.0) == 10.0 + offset


def test_rate_of_station_applies_only_if_slower_than_device():
    rig = rig_of(FakeTester(), drives={"tester.load": DriveLimits(rate="100 N/s")})
    assert rig.led_rate_per_s("tester", "load") == 100.0
    assert rig.led_rate_per_s("tester", "frequency") is None
    faster = rig_of(FakeTester(), drives={"tester.load": DriveLimits(rate="2000 kN/s")})
    assert faster.led_rate_per_s("tester", "load") is None


def test_pause_stops_drives_and_reports_devices_that_cannot_pause():
    patient, press = Patient(), FakeTester()
    rig = Rig({"tester": patient, "press": press}, SimulatedClock())
    rig.connect()
    rig.set("tester", "frequency", 20.0)
    rig.set("press", "load", 500.0)
    assert rig.pause() == ["press cannot pause: load stays at 500 N"]
    assert patient.drives_at["frequency"] == 0.0
    rig.resume()
    assert patient.drives_at["frequency"] == 20.0


def test_resume_after_make_safe_moves_nothing():
    patient = Patient()
    rig = rig_of(patient)
    rig.pause()
    rig.make_safe()
    rig.resume()
    assert "resume" not in patient.calls


def test_resume_moves_only_a_paused_device():
    patient = Patient()
    rig = rig_of(patient)
    rig.set("tester", "frequency", 20.0)
    patient.drives_at["frequency"] = 5.0
    assert not rig.resume_leads_away("tester", "frequency")
    rig.pause()
    assert rig.resume_leads_away("tester", "frequency")


@pytest.mark.parametrize(("set_point", "away"), [(9.9, False), (10.0, False), (10.1, True)])
def test_resume_leads_away_if_farther_from_safe_than_position(set_point, away):
    """It stands at 0 Hz while paused, 5 Hz below its safe value."""
    patient = Patient(drives=(replace(DRIVES[1], safe_value=5.0),))
    rig = rig_of(patient)
    rig.set("tester", "frequency", set_point)
    rig.pause()
    assert rig.resume_leads_away("tester", "frequency") is away


@pytest.mark.parametrize(("value", "away"), [(7.0, False), (6.0, False), (7.5, True)])
def test_set_point_leads_away_if_farther_from_safe_than_position(value, away):
    rig = rig_of(FakeTester(drives_at={"load": 7.0, "frequency": 0.0}))
    assert rig.leads_away("tester", "load", value) is away
