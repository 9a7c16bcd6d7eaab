from __future__ import annotations

import math
from dataclasses import replace

import pytest

from helpers_devices import DRIVES, FakeTester
from rigrunner.api.calling import ThreadCaller
from rigrunner.api.errors import DeviceTimeoutError
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Patience, Pulse, Rig
from rigrunner.rig.pulse import PulseCaller, PulseClock

USUAL_S = 30.0


@pytest.fixture
def announced():
    return []


@pytest.fixture
def pulse(announced):
    return Pulse(USUAL_S, announced.append)


def test_time_runs_out_without_progress(pulse):
    assert pulse.left_s() == USUAL_S
    pulse.tick(29.0)
    assert pulse.left_s() == 1.0
    pulse.note()
    assert pulse.left_s() == USUAL_S
    pulse.tick(31.0)
    assert pulse.left_s() < 0


def test_call_has_its_own_time_plus_usual_time(pulse, announced):
    with pulse.call(600.0):
        pulse.tick(600.0)
        assert pulse.left_s() == USUAL_S
        assert announced == [630.0]
    assert pulse.left_s() == USUAL_S


def test_concurrent_calls_each_have_their_own_time(pulse):
    """Devices are made safe concurrently: a quick answer takes no time from a slow device."""
    with pulse.call(600.0):
        with pulse.call(1.0):
            pulse.tick(1.0)
        assert pulse.left_s() == 599.0 + USUAL_S
    assert pulse.left_s() == USUAL_S


def test_short_call_is_not_announced(pulse, announced):
    with pulse.call(10.0):
        assert pulse.left_s() == 40.0
    with pulse.call(USUAL_S):
        assert pulse.left_s() == 2 * USUAL_S
    assert announced == []


def test_abandoned_call_keeps_its_time(pulse):
    """Making safe waits for it, with other calls in between."""
    with pytest.raises(DeviceTimeoutError), pulse.call(600.0):
        raise DeviceTimeoutError("given up")
    pulse.tick(1.0)
    with pulse.call(10.0):
        pass
    pulse.tick(500.0)
    assert pulse.left_s() > 0
    pulse.tick(200.0)
    assert pulse.left_s() < 0
    pulse.note()
    assert pulse.left_s() == USUAL_S


def test_person_has_unlimited_time(pulse):
    with pulse.person():
        with pulse.person():
            pulse.tick(1e6)
        assert pulse.left_s() == math.inf
    assert pulse.left_s() == USUAL_S


def test_each_sleep_is_progress(pulse):
    clock = PulseClock(SimulatedClock(), pulse)
    pulse.tick(29.0)
    clock.sleep(0.1)
    assert pulse.left_s() == USUAL_S
    assert clock.monotonic_s() == pytest.approx(0.1)


def test_each_device_call_has_its_time(pulse):
    caller = PulseCaller(ThreadCaller("test"), pulse)
    left = [call("look", pulse.left_s, 5.0) for call in (caller.call, caller.call_urgently)]
    caller.stop()
    assert left == [35.0, 35.0]


def test_rig_call_has_time_of_its_patience(pulse):
    left = []
    tester = FakeTester(non_blocking=False, before=lambda _: left.append(pulse.left_s()))
    rig = Rig({"tester": tester}, SimulatedClock(), Patience(answer_s=100.0), pulse=pulse)
    rig.read("tester", ["load"])
    rig.close()
    assert left == [100.0 + USUAL_S] * 2


def test_pause_has_time_for_full_travel_of_all_drives(pulse):
    left = []
    slow = tuple(replace(info, rate_per_s=10.0, settle_s=1.0) for info in DRIVES)

    class Pausing(FakeTester):
        def pause(self):
            left.append(pulse.left_s())

        resume = pause

    tester = Pausing(non_blocking=False, drives=slow)
    rig = Rig({"tester": tester}, SimulatedClock(), Patience(answer_s=100.0), pulse=pulse)
    rig.connect()
    rig.pause()
    rig.resume()
    rig.close()
    assert left == [100.0 + (3000.0 / 10.0 + 1.0) + (35.0 / 10.0 + 1.0) + USUAL_S] * 2


def test_connect_each_reports_devices_that_fail():
    good, bad = FakeTester(), FakeTester()
    bad.non_blocking = False

    def refuse(_timeout_s):
        raise DeviceTimeoutError("nobody answers")

    bad.connect = refuse
    rig = Rig({"good": good, "bad": bad}, SimulatedClock())
    failed = rig.connect_each()
    assert list(failed) == ["bad"]
    assert "nobody answers" in failed["bad"]
    reports = {report.role: report for report in rig.make_safe() if not report.drive}
    rig.close()
    assert reports["good"].safe


def test_utc_is_that_of_wrapped_clock(pulse):
    clock = SimulatedClock()
    assert PulseClock(clock, pulse).utc() == clock.utc()
