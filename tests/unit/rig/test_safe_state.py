"""Making safe: in the station's order, each read back, whatever fails."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest

from helpers_devices import DRIVES, FakeTester
from rigrunner.api.errors import DeviceLostError
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Patience, Rig

OTHER_DRIVES = (replace(DRIVES[0], name="heater", safe_value=20.0, maximum=200.0),)


class Oven(FakeTester):
    """A second device, without a motion in cycles."""

    def __init__(self, told: list[str], **more: object) -> None:
        super().__init__(**more)
        self.told, self.drives, self.drives_at = told, OTHER_DRIVES, {"heater": 90.0}

    def _told(self, call: str) -> None:
        self.told.append(f"oven {call}")
        super()._told(call)

    def make_safe(self):
        self._told("make_safe")
        self.drives_at["heater"] = 20.0
        return dict(self.drives_at)


class Bench(FakeTester):
    def __init__(self, told: list[str], **more: object) -> None:
        super().__init__(**more)
        self.told = told

    def _told(self, call: str) -> None:
        self.told.append(f"tester {call}")
        super()._told(call)


def made_safe(order, **more):
    """Return what the devices were told in which order, and the reports."""
    told: list[str] = []
    rig = Rig(
        {"oven": Oven(told), "tester": Bench(told, **more)},
        SimulatedClock(),
        Patience(answer_s=0.05),
        order,
    )
    rig.connect()
    told.clear()
    reports = rig.make_safe()
    return [call for call in told if "read_back" not in call], reports


def test_unless_told_what_moves_in_cycles_is_made_safe_first():
    told, reports = made_safe(())
    assert told == ["tester make_safe", "oven make_safe"]
    assert [(one.what, one.safe) for one in reports] == [("tester", True), ("oven", True)]


def test_the_stations_order_goes_through_drives_and_devices():
    told, reports = made_safe(("tester.frequency", "oven", "tester.load"))
    assert told == [
        "tester set frequency 0",
        "oven make_safe",
        "tester set load 0",
        "tester make_safe",
    ]
    assert [one.what for one in reports] == ["tester.frequency", "oven", "tester.load", "tester"]
    assert reports[0].read_back == {"frequency": 0.0}


@pytest.mark.parametrize("error", [DeviceLostError("cable"), ZeroDivisionError("bug")])
def test_a_drive_that_fails_does_not_stop_the_next(error):
    def refuse(call):
        if call == "set frequency 0":
            raise error

    told, reports = made_safe(("tester.frequency", "tester.load"), before=refuse)
    assert told == [
        "tester set frequency 0",
        "tester set load 0",
        "tester make_safe",
        "oven make_safe",
    ]
    assert [one.safe for one in reports] == [False, True, True, True]


def test_a_drive_that_hangs_is_abandoned_and_the_others_follow():
    release = threading.Event()

    def hang(call):
        if call == "set frequency 0":
            release.wait()

    told: list[str] = []
    tester = Bench(told, before=hang, non_blocking=False)
    tester.drives = tuple(replace(info, rate_per_s=None) for info in DRIVES)
    rig = Rig(
        {"oven": Oven(told), "tester": tester},
        SimulatedClock(),
        Patience(answer_s=0.05),
        ("tester.frequency", "tester.load"),
    )
    rig.connect()
    rig._roles["tester"].caller.grace_s = 0.02
    reports = rig.make_safe()
    release.set()
    assert [(one.what, one.safe) for one in reports] == [
        ("tester.frequency", False),
        ("tester.load", True),
        ("tester", True),
        ("oven", True),
    ]
    assert "'make safe' did not return within 0.05 s" in reports[0].problems[0]
    rig.close()


def test_a_drive_that_reads_back_something_else_is_not_safe():
    _, reports = made_safe(("tester.frequency",), read_back_offset=0.5)
    assert reports[0].problems == ("frequency reads back 0.5 Hz, safe is 0 Hz",)


def test_drives_of_a_device_that_never_answered_are_left_to_its_own_make_safe():
    told: list[str] = []
    rig = Rig({"tester": Bench(told)}, SimulatedClock(), None, ("tester.frequency",))
    assert [one.what for one in rig.make_safe()] == ["tester"]
    assert told == ["tester make_safe"]
