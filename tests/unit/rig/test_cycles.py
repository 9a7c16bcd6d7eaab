from __future__ import annotations

import pytest

from rigrunner.clock import SimulatedClock
from rigrunner.rig.cycles import CycleCount


@pytest.fixture
def clock():
    return SimulatedClock()


@pytest.fixture
def count(clock):
    return CycleCount(clock)


def set_to(count, clock, frequency_hz, takes_s=0.0, role="tester"):
    count.leave(role)
    clock.sleep(takes_s)
    count.stand(role, frequency_hz)


def test_no_cycles_before_first_motion(count):
    assert count.done() == {}


def test_cycles_are_frequency_times_duration(count, clock):
    set_to(count, clock, 10.0)
    clock.sleep(50.0)
    assert count.done() == {"tester": 500.0}
    set_to(count, clock, 5.0)
    clock.sleep(2.0)
    assert count.done() == {"tester": 510.0}


def test_change_of_frequency_counts_with_mean_of_both(count, clock):
    set_to(count, clock, 10.0, takes_s=1.0)
    assert count.done() == {"tester": 5.0}
    set_to(count, clock, 0.0, takes_s=2.0)
    clock.sleep(100.0)
    assert count.done() == {"tester": 15.0}


def test_no_cycles_during_pause(count, clock):
    set_to(count, clock, 10.0)
    clock.sleep(1.0)
    count.pause("tester")
    clock.sleep(60.0)
    count.resume("tester")
    clock.sleep(1.0)
    assert count.done() == {"tester": 20.0}


def test_no_cycles_after_stop(count, clock):
    set_to(count, clock, 10.0)
    clock.sleep(1.0)
    count.stop()
    clock.sleep(60.0)
    assert count.done() == {"tester": 10.0}


def test_count_continues_from_number_for_each_role(count, clock):
    set_to(count, clock, 10.0)
    set_to(count, clock, 1.0, role="other")
    clock.sleep(3.0)
    count.start_from({"tester": 1000.0})
    clock.sleep(1.0)
    assert count.done() == {"tester": 1010.0, "other": 1.0}


def test_initial_number_is_kept_until_role_moves(count, clock):
    count.start_from({"tester": 1000.0})
    clock.sleep(10.0)
    set_to(count, clock, 10.0)
    clock.sleep(1.0)
    assert count.done() == {"tester": 1010.0}
