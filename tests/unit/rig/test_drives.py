"""How long a drive that is on its way is waited for."""

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
    """A drive that takes a set-point and stays where it is."""

    def __init__(self, clock, arrives_at_s=float("inf")):
        self.clock, self.arrives_at_s = clock, arrives_at_s
        self.looked_at_s = []

    def begin(self, drive, value):
        pass

    def arrived(self, drive):  # noqa: ARG002  (of one drive)
        self.looked_at_s.append(self.clock.now_s)
        return self.clock.now_s >= self.arrives_at_s

    def read_back(self, drive):  # noqa: ARG002  (of one drive)
        return 500.0


def approached(drive, limit_s):
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


def test_a_drive_that_stays_is_given_up_when_its_time_is_over():
    drive = Stuck(CoarseClock())
    with pytest.raises(DeviceTimeoutError, match="load reads back 500 N after 2 s, set to 1000 N"):
        approached(drive, limit_s=2.0)
    assert drive.looked_at_s == [0.0, 1.0, 2.0]


def test_a_drive_that_arrives_at_the_last_moment_has_arrived():
    drive = Stuck(CoarseClock(), arrives_at_s=2.0)
    approached(drive, limit_s=2.0)
    assert drive.looked_at_s == [0.0, 1.0, 2.0]


@pytest.mark.parametrize(("actual", "there"), [(100.5, True), (99.5, True), (100.625, False)])
def test_a_drive_stands_at_a_value_that_it_is_off_by_the_whole_tolerance(actual, there):
    load = DriveInfo("load", "N", "Load", 0.0, 1000.0, tolerance=0.5)
    assert agrees(load, actual, 100.0) is there
