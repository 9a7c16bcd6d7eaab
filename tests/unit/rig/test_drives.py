"""Waiting for a drive until it has arrived or its time is over."""

from __future__ import annotations

import pytest

from rigrunner.api.devices import DriveInfo
from rigrunner.api.errors import DeviceTimeoutError
from rigrunner.rig.drives import agrees, approach

LOAD = DriveInfo("load", "N", "Load", 0.0, 1000.0)


class CoarseClock:
    """A clock on which each wait takes one second, so that times are exact."""

    def __init__(self):
        self.now_s = 0.0

    def monotonic_s(self):
        return self.now_s

    def sleep(self, seconds):  # noqa: ARG002  (the Protocol's)
        self.now_s += 1.0


class Stuck:
    """A drive that takes a set-point and never arrives, or at a given time."""

    def __init__(self, clock, arrives_at_s=float("inf")):
        self.clock, self.arrives_at_s = clock, arrives_at_s
        self.polled_at_s = []

    def begin(self, drive, value):
        pass

    def arrived(self, drive):  # noqa: ARG002  (of one drive)
        self.polled_at_s.append(self.clock.now_s)
        return self.clock.now_s >= self.arrives_at_s

    def read_back(self, drive):  # noqa: ARG002  (of one drive)
        return 500.0


def approach_load(drive, limit_s):
    def call(_what, function):
        return function()

    approach(
        drive,
        LOAD,
        1000.0,
        call=call,
        move=call,
        clock=drive.clock,
        limit_s=limit_s,
        meanwhile=lambda: None,
    )


def test_stuck_drive_times_out():
    drive = Stuck(CoarseClock())
    with pytest.raises(DeviceTimeoutError, match="load reads back 500 N after 2 s, set to 1000 N"):
        approach_load(drive, limit_s=2.0)
    assert drive.polled_at_s == [0.0, 1.0, 2.0]


def test_drive_may_arrive_at_the_time_limit():
    drive = Stuck(CoarseClock(), arrives_at_s=2.0)
    approach_load(drive, limit_s=2.0)
    assert drive.polled_at_s == [0.0, 1.0, 2.0]


@pytest.mark.parametrize(("actual", "expected"), [(100.5, True), (99.5, True), (100.625, False)])
def test_deviation_of_exactly_the_tolerance_agrees(actual, expected):
    load = DriveInfo("load", "N", "Load", 0.0, 1000.0, tolerance=0.5)
    assert agrees(load, actual, 100.0) is expected
