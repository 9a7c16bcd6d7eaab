"""Making safe: in the station's order, each read back, whatever fails."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import pytest

from helpers_devices import DRIVES, FakeTester
from rigrunner.api.calling import ThreadCaller
from rigrunner.api.errors import DeviceLostError, DeviceTimeoutError
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


class Late(FakeTester):
    """A tester whose 'set load 1000' comes to the drive only once it is let go."""

    def __init__(self, **more: object) -> None:
        super().__init__(non_blocking=False, **more)
        self.let_go = threading.Event()

    def set(self, drive, value):
        if value:
            self.let_go.wait(10)
        super().set(drive, value)


class LateToBegin(Late):
    """The same for a device that is asked whether a drive has arrived."""

    def begin(self, drive, value):
        self.set(drive, value)

    def arrived(self, _drive):
        return True


@pytest.fixture(params=[Late, LateToBegin])
def late(request, monkeypatch):
    """Return a tester whose set was given up, and its rig."""
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    tester = request.param()
    tester.drives = tuple(replace(info, rate_per_s=None) for info in DRIVES)
    rig = Rig({"tester": tester}, SimulatedClock(), Patience(answer_s=0.05))
    rig.connect()
    with pytest.raises(DeviceTimeoutError, match="'set load' did not return"):
        rig.set("tester", "load", 1000.0)
    yield tester, rig
    tester.let_go.set()
    rig.close()


def test_behind_a_set_that_comes_late_the_device_is_made_safe_once_more(late, monkeypatch):
    tester, rig = late

    def then_the_late_one(self):
        safe = FakeTester.make_safe(self)
        if not self.let_go.is_set():
            self.let_go.set()
            while self.drives_at["load"] != 1000.0:
                time.sleep(0.001)
        return safe

    monkeypatch.setattr(Late, "make_safe", then_the_late_one)
    (report,) = rig.make_safe()
    assert report.safe
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}
    assert tester.calls.count("make_safe") == 2


def test_a_set_that_does_not_come_back_leaves_the_rig_not_safe(late):
    tester, rig = late
    (report,) = rig.make_safe()
    assert report.read_back == {"load": 0.0, "frequency": 0.0}
    assert report.problems == (
        "'set load' was given up and has not come back: it may still move the drive",
    )
    tester.let_go.set()
    (report,) = rig.make_safe()
    assert report.safe
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}


def test_a_teardown_that_was_refused_hides_no_set_that_may_still_come(late):
    tester, rig = late
    for drive in ("frequency", "load"):
        with pytest.raises(DeviceLostError, match="still hangs"):
            rig.set("tester", drive, 0.0)
    (report,) = rig.make_safe()
    assert report.problems == (
        "'set load' was given up and has not come back: it may still move the drive",
    )
    tester.let_go.set()
