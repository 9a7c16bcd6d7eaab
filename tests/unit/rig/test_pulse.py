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


def test_without_progress_the_time_runs_out(pulse):
    assert pulse.left_s() == USUAL_S
    pulse.tick(29.0)
    assert pulse.left_s() == 1.0
    pulse.note()
    assert pulse.left_s() == USUAL_S
    pulse.tick(31.0)
    assert pulse.left_s() < 0


def test_a_call_may_take_its_own_time_and_the_usual_one_beyond(pulse, announced):
    with pulse.call(600.0):
        pulse.tick(600.0)
        assert pulse.left_s() == USUAL_S
        assert announced == [630.0]
    assert pulse.left_s() == USUAL_S


def test_of_calls_at_the_same_time_each_may_take_its_own_time(pulse):
    """Devices are made safe side by side: the first answer is not that of the slow one."""
    with pulse.call(600.0):
        with pulse.call(1.0):
            pulse.tick(1.0)
        assert pulse.left_s() == 599.0 + USUAL_S
    assert pulse.left_s() == USUAL_S


def test_a_short_call_is_not_announced(pulse, announced):
    with pulse.call(10.0):
        assert pulse.left_s() == 40.0
    with pulse.call(USUAL_S):
        assert pulse.left_s() == 2 * USUAL_S
    assert announced == []


def test_a_call_that_was_given_up_is_still_waited_for(pulse):
    """What makes safe waits for it, with calls of its own in between."""
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


def test_a_person_may_take_any_time(pulse):
    with pulse.person():
        with pulse.person():
            pulse.tick(1e6)
        assert pulse.left_s() == math.inf
    assert pulse.left_s() == USUAL_S


def test_each_nap_of_a_wait_is_progress(pulse):
    clock = PulseClock(SimulatedClock(), pulse)
    pulse.tick(29.0)
    clock.sleep(0.1)
    assert pulse.left_s() == USUAL_S
    assert clock.monotonic_s() == pytest.approx(0.1)


def test_each_call_of_a_device_is_allowed_its_time(pulse):
    caller = PulseCaller(ThreadCaller("test"), pulse)
    left = [call("look", pulse.left_s, 5.0) for call in (caller.call, caller.call_urgently)]
    caller.stop()
    assert left == [35.0, 35.0]


def test_a_call_of_a_rig_is_allowed_the_patience_of_its_station(pulse):
    left = []
    tester = FakeTester(non_blocking=False, before=lambda _: left.append(pulse.left_s()))
    rig = Rig({"tester": tester}, SimulatedClock(), Patience(answer_s=100.0), pulse=pulse)
    rig.read("tester", ["load"])
    rig.close()
    assert left == [100.0 + USUAL_S] * 2


def test_a_pause_is_allowed_the_time_in_which_all_drives_reach_their_ends(pulse):
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


def test_a_rig_connects_what_answers_and_says_why_the_rest_does_not():
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


def test_the_date_and_time_are_those_of_the_clock(pulse):
    clock = SimulatedClock()
    assert PulseClock(clock, pulse).utc() == clock.utc()
