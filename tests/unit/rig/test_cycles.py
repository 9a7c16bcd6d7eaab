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


def test_nothing_counts_that_never_moved(count):
    assert count.done() == {}


def test_a_frequency_counts_for_as_long_as_it_stands(count, clock):
    set_to(count, clock, 10.0)
    clock.sleep(50.0)
    assert count.done() == {"tester": 500.0}
    set_to(count, clock, 5.0)
    clock.sleep(2.0)
    assert count.done() == {"tester": 510.0}


def test_the_way_counts_by_the_mean_of_both_frequencies(count, clock):
    set_to(count, clock, 10.0, takes_s=1.0)
    assert count.done() == {"tester": 5.0}
    set_to(count, clock, 0.0, takes_s=2.0)
    clock.sleep(100.0)
    assert count.done() == {"tester": 15.0}


def test_nothing_counts_while_it_is_paused(count, clock):
    set_to(count, clock, 10.0)
    clock.sleep(1.0)
    count.pause("tester")
    clock.sleep(60.0)
    count.resume("tester")
    clock.sleep(1.0)
    assert count.done() == {"tester": 20.0}


def test_at_rest_nothing_counts(count, clock):
    set_to(count, clock, 10.0)
    clock.sleep(1.0)
    count.stop()
    clock.sleep(60.0)
    assert count.done() == {"tester": 10.0}


def test_it_counts_on_from_a_number_and_each_role_by_itself(count, clock):
    set_to(count, clock, 10.0)
    set_to(count, clock, 1.0, role="other")
    clock.sleep(3.0)
    count.start_from({"tester": 1000.0})
    clock.sleep(1.0)
    assert count.done() == {"tester": 1010.0, "other": 1.0}


def test_a_number_holds_before_the_role_moves(count, clock):
    count.start_from({"tester": 1000.0})
    clock.sleep(10.0)
    set_to(count, clock, 10.0)
    clock.sleep(1.0)
    assert count.done() == {"tester": 1010.0}
