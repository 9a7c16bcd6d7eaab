"""Interlocks: when they trip and clear, with which latency, and what they do and forbid."""

from __future__ import annotations

import threading
from dataclasses import replace
from math import inf

import numpy as np
import pytest

from helpers_devices import FakeTester, Listener, plan_of, record, run
from rigrunner.api.data import Block
from rigrunner.api.errors import DeviceLostError
from rigrunner.api.events import (
    InterlockCleared,
    InterlockTripped,
    Intervention,
    MadeSafe,
    Outcome,
    StepEnded,
)
from rigrunner.api.member import Member
from rigrunner.api.units import unit
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.engine.interlocks import Guard
from rigrunner.engine.watching import Watch
from rigrunner.plan.actions import Interlock
from rigrunner.rig import Rig
from rigrunner.station.drive_rules import DriveRules
from rigrunner.station.limits import DriveLimits
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.settle import Settle

HOT = Interlock(
    name="hot",
    member=Member("tester", "load"),
    condition="above 2000 N",
    shown=unit("N"),
    maximum=2000.0,
)


def changes_of(interlock, *values, step_s=1.0):
    """Return the (time, change) pairs when values are read one after the other."""
    watch, changes = Watch(interlock, 0.0), []
    for number, value in enumerate(values):
        now_s = number * step_s
        if value is None:
            watch.miss(now_s, "cable")
        else:
            watch.take(np.array([now_s]), np.array([float(value)]), now_s)
        changes += [(now_s, change) for change in watch.changes]
        watch.changes.clear()
    return changes


@pytest.mark.parametrize(
    ("more", "values", "changes"),
    [
        ({"maximum": 5.0}, [5, 6, 6, 5], [(1, "tripped"), (3, "cleared")]),
        ({"maximum": inf, "minimum": 5.0}, [5, 4.9, 5], [(1, "tripped"), (2, "cleared")]),
        ({"maximum": 5.0, "minimum": -5.0}, [0, -6, 6, 0], [(1, "tripped"), (3, "cleared")]),
        ({"maximum": 5.0, "debounce_s": 2.0}, [6, 6, 5, 6, 6, 6], [(5, "tripped")]),
        ({"maximum": 5.0, "hysteresis": 2.0}, [6, 4, 3], [(0, "tripped"), (2, "cleared")]),
        (
            {"maximum": inf, "minimum": 5.0, "hysteresis": 2.0},
            [4, 6, 7],
            [(0, "tripped"), (2, "cleared")],
        ),
        ({"maximum": 5.0, "latched": True}, [6, 0, 0], [(0, "tripped")]),
        ({"maximum": inf, "rate_per_s": 2.0}, [0, 2, 4.1, 4.1], [(2, "tripped"), (3, "cleared")]),
        ({"maximum": inf, "rate_per_s": 2.0}, [0, -2.5], [(1, "tripped")]),
        ({"maximum": inf, "stale_s": 2.0}, [0, None, None, 0], [(2, "tripped"), (3, "cleared")]),
        ({"maximum": inf, "stale_s": 2.0}, [7, 7, 7, 7, 7], []),
        ({"maximum": 5.0}, [0, None], [(1, "tripped")]),
        ({"maximum": 5.0, "debounce_s": 1.5}, [0, None, None], [(2, "tripped")]),
        ({"maximum": 5.0}, [float("nan")], [(0, "tripped")]),
    ],
)
def test_watch_trips_and_clears(more, values, changes):
    assert changes_of(replace(HOT, **more), *values) == changes


@pytest.mark.parametrize(
    ("bad", "debounce_s", "trips"),
    [
        (slice(50, 51), 0.0, True),
        (slice(50, 60), 0.01, False),
        (slice(50, 61), 0.01, True),
        (slice(0, 5), 0.01, False),
        (slice(95, 100), 0.01, False),
    ],
)
def test_every_sample_of_block_is_checked(bad, debounce_s, trips):
    values = np.zeros(100)
    values[bad] = 9.0
    watch = Watch(replace(HOT, maximum=5.0, debounce_s=debounce_s), 0.0)
    watch.take(np.arange(100) / 1000, values, 0.1)
    assert watch.tripped is trips


def test_debounce_continues_across_blocks():
    watch = Watch(replace(HOT, maximum=5.0, debounce_s=0.15), 0.0)
    times_s = np.arange(100) / 1000
    values = np.where(times_s < 0.04, 0.0, 9.0)
    watch.take(times_s, values, 0.1)
    assert not watch.tripped
    watch.take(times_s + 0.1, np.full(100, 9.0), 0.2)
    assert watch.tripped
    assert watch.latency_s == pytest.approx(0.2 - 0.039)


class Rising(FakeTester):
    """A tester whose load is a function of the simulated time."""

    def __init__(self, clock, load_at, **more):
        super().__init__(**more)
        self.clock, self.load_at = clock, load_at

    def read(self, channels):
        self._record_call(f"read {','.join(channels)}")
        return dict.fromkeys(channels, self.load_at(self.clock.monotonic_s()))


def run_with(interlock, load_at, plan=None, **more):
    clock, listener = SimulatedClock(), Listener()
    device = Rising(clock, load_at)
    plan = plan or plan_of((), [Settle(3.0)], (SetDrive("tester", "load", 0.0, "N"),))
    summary = run(
        device,
        replace(plan, interlocks=(interlock,)),
        critical=[listener],
        clock=clock,
        **more,
    )
    return summary, listener, device


def step_at(seconds, low=0.0, high=9e3):
    return lambda now_s: high if now_s >= seconds else low


def test_interlock_aborts_and_reports_latency():
    summary, listener, device = run_with(HOT, step_at(1.04))
    assert summary.outcome is Outcome.ABORTED
    assert summary.reason == "tester.load is 9000 N, above 2000 N"
    (tripped,) = listener.of(InterlockTripped)
    assert (tripped.source, tripped.does) == ("interlock hot", "abort")
    assert tripped.latency_s == pytest.approx(0.1)
    (intervention,) = listener.of(Intervention)
    assert (intervention.action, intervention.by) == ("abort", "interlock hot")
    assert device.calls[-3:] == ["set load 0", "read_back load", "make_safe"]


def test_interlock_makes_rig_safe_before_teardown():
    summary, listener, device = run_with(replace(HOT, does="make_safe"), step_at(1.0))
    assert summary.outcome is Outcome.ABORTED
    ends = [call for call in device.calls if not call.startswith("read")]
    assert ends == ["connect", "make_safe", "set load 0", "make_safe"]
    assert len(listener.of(MadeSafe)) == 2


def test_interlock_tripped_at_start_prevents_every_step():
    plan = plan_of((SetDrive("tester", "load", 5.0, "N"),), (), ())
    summary, listener, device = run_with(HOT, lambda _: 9e3, plan)
    assert summary.outcome is Outcome.ABORTED
    assert "set load 5" not in device.calls
    assert listener.of(StepEnded) == []


def test_interlock_checks_samples_of_recording():
    torque = replace(HOT, member=Member("tester", "torque"), shown=unit("N·m"), maximum=0.5)

    def spoil(blocks):
        values = blocks[1].channels["torque"].copy()
        values[3] = 0.7
        return [blocks[0], replace(blocks[1], channels={**blocks[1].channels, "torque": values})]

    listener = Listener()
    plan = replace(plan_of((), [record("001", seconds=2.0)], ()), interlocks=(torque,))
    device = FakeTester(spoil=spoil)
    # the fake reads 1000 for every single value; what counts here are the samples
    device.read = lambda channels: dict.fromkeys(channels, 0.0)
    summary = run(device, plan, critical=[listener])
    assert summary.reason == "tester.torque is 0.7 N·m, above 2000 N"
    assert summary.outcome is Outcome.ABORTED


LOADED = (
    SetDrive("tester", "load", 500.0, "N"),
    Settle(2.0),
    SetDrive("tester", "load", 200.0, "N"),
    SetDrive("tester", "load", 201.0, "N"),
)


def test_forbidding_interlock_allows_unloading():
    forbids = replace(HOT, does="forbid", forbids=(Member("tester", "load"),))
    summary, listener, device = run_with(forbids, step_at(1.0), plan_of((), LOADED, ()))
    assert summary.outcome is Outcome.ABORTED
    sets = [call for call in device.calls if call.startswith("set")]
    assert sets == ["set load 500", "set load 200"]
    assert "tester.load may not be set to 201: tester.load is 9000 N" in summary.reason
    assert listener.of(Intervention)[0].by == "interlock hot"


def test_cleared_interlock_forbids_nothing():
    forbids = replace(HOT, does="forbid", forbids=(Member("tester", "load"),))
    load_at = {0: 0.0, 1: 9e3, 2: 0.0}
    summary, listener, _ = run_with(
        forbids, lambda now_s: load_at[min(int(now_s), 2)], plan_of((), LOADED, ())
    )
    assert summary.outcome is Outcome.COMPLETED
    assert len(listener.of(InterlockTripped)) == len(listener.of(InterlockCleared)) == 1


def test_unreadable_channel_trips_interlock():
    def load_at(now_s):
        if now_s > 1.0:
            raise DeviceLostError("cable")
        return 0.0

    summary, _, _ = run_with(HOT, load_at)
    assert summary.outcome is Outcome.ABORTED
    assert "tester.load cannot be read: tester: cable" in summary.reason


def test_ctrl_c_during_interlock_reading_is_not_an_unreadable_channel():
    presses = iter([KeyboardInterrupt])

    def load_at(now_s):
        for press in presses if now_s > 1.0 else ():
            raise press
        return 0.0

    summary, listener, _ = run_with(HOT, load_at)
    assert summary.outcome is Outcome.ABORTED
    assert listener.of(InterlockTripped) == []
    (intervention,) = listener.of(Intervention)
    assert (intervention.action, intervention.by) == ("abort", "keyboard")


def test_interlock_pause_aborts_unattended_run():
    summary, listener, _ = run_with(replace(HOT, does="pause"), step_at(1.0))
    assert summary.outcome is Outcome.ABORTED
    assert "there is nobody to resume it" in summary.reason
    assert [event.action for event in listener.of(Intervention)] == ["pause", "abort"]


@pytest.mark.parametrize(
    ("actions", "safe_first"),
    [(("pause", "abort"), False), (("pause", "abort", "make_safe"), True)],
)
def test_gravest_tripped_interlock_decides(actions, safe_first):
    clock = SimulatedClock()
    interlocks = tuple(replace(HOT, name=name, does=name) for name in actions)
    device = Rising(clock, step_at(1.0))
    plan = plan_of((), [Settle(3.0)], (SetDrive("tester", "load", 0.0, "N"),))
    summary = run(device, replace(plan, interlocks=interlocks), clock=clock)
    assert "nobody to resume" not in summary.reason
    assert (device.calls.index("make_safe") < device.calls.index("set load 0")) is safe_first


def test_override_ends_when_interlock_clears():
    watch = Watch(HOT, 0.0)
    take(watch, 9e3, 1.0)
    watch.overridden = True
    take(watch, 0.0, 2.0)
    take(watch, 9e3, 3.0)
    assert watch.tripped
    assert not watch.overridden


def test_teardown_runs_despite_tripped_interlock():
    plan = plan_of((), [Settle(2.0)], (Settle(1.0), SetDrive("tester", "load", 0.0, "N")))
    summary, listener, device = run_with(HOT, step_at(1.0), plan)
    assert summary.outcome is Outcome.ABORTED
    assert [event.ok for event in listener.of(StepEnded)] == [False, True, True]
    assert device.calls[-1] == "make_safe"


def test_interlock_is_checked_after_last_step():
    # the channel is not due again before the last step ends
    plan = plan_of((), [Settle(1.0), Settle(0.5)], ())
    summary, _, _ = run_with(replace(HOT, every_s=60.0), step_at(1.2), plan)
    assert summary.outcome is Outcome.ABORTED


def test_station_rate_limits_drive_in_monitored_steps():
    clock, listener = SimulatedClock(), Listener()
    device = Rising(clock, step_at(6.0))
    rules = DriveRules({Member("tester", "load"): DriveLimits(rate="100 N/s")})
    rig = Rig({"tester": device}, clock, rules=rules)
    rig.connect()
    device.drives_at["load"] = 0.0
    plan = plan_of((), [SetDrive("tester", "load", 500.0, "N")], ())
    begin_s = clock.monotonic_s()
    summary = run_plan(
        plan, rig, Bus([listener]), clock, UnattendedAnswers(), threading.Event(), "led"
    )
    assert summary.outcome is Outcome.COMPLETED
    assert clock.monotonic_s() - begin_s == pytest.approx(5.0, abs=0.2)
    steps = [float(call.split()[-1]) for call in device.calls if call.startswith("set load")]
    assert max(np.diff(steps)) <= 10.0 + 1e-6
    assert steps[-1] == 500.0


@pytest.mark.parametrize(
    ("position", "outcome", "sets"),
    [
        (-0.5, Outcome.COMPLETED, ["set load 0", "set load 10", "set load 20"]),
        (-30.0, Outcome.COMPLETED, ["set load 0", "set load 10", "set load 20"]),  # 1 % of 3000 N
        (-31.0, Outcome.ERROR, []),  # beyond the tolerance: from there it would jump to its range
        (3000.5, Outcome.COMPLETED, None),
    ],
)
def test_drive_slightly_out_of_range_ramps_from_edge_of_range(position, outcome, sets):
    clock, device = SimulatedClock(), FakeTester()
    rules = DriveRules({Member("tester", "load"): DriveLimits(rate="100 N/s")})
    rig = Rig({"tester": device}, clock, rules=rules)
    rig.connect()
    device.drives_at["load"] = position
    plan = plan_of((), [SetDrive("tester", "load", 20.0, "N")], ())
    summary = run_plan(plan, rig, Bus(), clock, UnattendedAnswers(), threading.Event(), "led")
    assert summary.outcome is outcome
    if sets is not None:
        assert [call for call in device.calls if call.startswith("set load")] == sets


def take(watch, value, now_s):
    watch.take(np.array([now_s]), np.array([value]), now_s)


@pytest.mark.parametrize(("samples", "trips"), [(50, False), (150, True)])
def test_debounce_follows_sample_rate(samples, trips):
    clock = SimulatedClock()
    rig = Rig({"tester": FakeTester()}, clock)
    lasting = replace(HOT, member=Member("tester", "torque"), maximum=5.0, debounce_s=0.1)
    guard = Guard([lasting], rig, lambda *_, **__: None)
    clock.sleep(1.0)
    values = np.zeros(500)
    values[100 : 100 + samples] = 9.0
    guard.feed("tester", Block(1000.0, 0, 1.0, {"torque": values}))
    assert bool(guard.tripped) is trips


def test_empty_block_does_not_trip_interlock():
    rig = Rig({"tester": FakeTester()}, SimulatedClock())
    rig.connect()
    guard = Guard([HOT], rig, lambda *_args, **_more: None)
    guard.feed("tester", Block(1000.0, 0, 0.0, {"load": np.zeros(0)}))
    assert not guard.tripped
    guard.feed("tester", Block(1000.0, 0, 0.0, {"load": np.array([9e3])}))
    assert [watch.interlock for watch in guard.tripped] == [HOT]


def test_interlocks_are_read_before_each_step_even_if_not_due():
    seldom = replace(HOT, every_s=1e6)
    plan = plan_of((), [Settle(1.0), SetDrive("tester", "frequency", 5.0, "Hz")], ())
    summary, _, device = run_with(seldom, step_at(0.5), plan)
    assert summary.outcome is Outcome.ABORTED
    assert "set frequency 5" not in device.calls


def test_interlock_tripping_in_teardown_is_recorded():
    plan = plan_of((), (), [Settle(2.0), SetDrive("tester", "load", 0.0, "N")])
    summary, listener, device = run_with(HOT, step_at(1.0), plan)
    assert summary.outcome is Outcome.COMPLETED
    assert [event.interlock for event in listener.of(InterlockTripped)] == ["hot"]
    assert "set load 0" in device.calls


def test_condition_lasting_exactly_debounce_time_trips():
    """With times that are exact as binary fractions."""
    lasting = replace(HOT, maximum=5.0, debounce_s=0.5)
    watch = Watch(lasting, 0.0)
    for now_s in (0.0, 0.25, 0.5):
        assert not watch.tripped
        take(watch, 9.0, now_s)
    assert watch.tripped


def test_rate_needs_readings_as_far_apart_as_the_interval():
    """Readings closer together would show noise as a change."""
    quick = replace(HOT, maximum=inf, rate_per_s=2.0, every_s=0.5)
    early, due = Watch(quick, 0.0), Watch(quick, 0.0)
    for watch, now_s in ((early, 0.25), (due, 0.5)):
        take(watch, 0.0, 0.0)
        take(watch, 9.0, now_s)
    assert (early.tripped, due.tripped) == (False, True)


def test_rate_compares_with_previous_reading():
    watch = Watch(replace(HOT, maximum=inf, rate_per_s=50.0), 0.0)
    for now_s in range(100):
        take(watch, 1000.0, float(now_s))
    assert not watch.tripped
    take(watch, 2000.0, 100.0)
    assert watch.tripped


def feed(interlock, blocks, value_at, *, late_s=(), read_after_s=0.1):
    """Feed blocks of these durations, some of them late, then read once; return the changes."""
    clock, kinds, first, rate_hz = SimulatedClock(), [], 0, 100.0
    rig = Rig({"tester": FakeTester()}, clock)
    rig.connect()
    guard = Guard([interlock], rig, lambda kind, **_more: kinds.append(kind))
    watch = Watch(interlock, 0.0)
    guard._watches = [watch]
    for index, seconds in enumerate(blocks):
        count = round(seconds * rate_hz)
        times_s = (first + np.arange(1, count + 1)) / rate_hz
        late = late_s[index] if late_s else 0.0
        clock.sleep(max(float(times_s[-1]) + late - clock.monotonic_s(), 0.0))
        channels = {"load": np.vectorize(value_at)(times_s).astype(float)}
        guard.feed("tester", Block(rate_hz, first, 0.0, channels))
        first += count
    clock.sleep(read_after_s)
    now_s = clock.monotonic_s()
    watch.take(
        np.array([now_s]), np.array([float(value_at(first / rate_hz + read_after_s))]), now_s
    )
    return watch.changes


RISING = replace(HOT, maximum=inf, rate_per_s=6.0)


@pytest.mark.parametrize(
    ("blocks", "late_s"),
    [([1.0] * 3, ()), ([0.1] * 10, ()), ([0.1] * 10, [0, 0.1, 0, 0.05, 0] * 2)],
)
@pytest.mark.parametrize(("rate", "trips"), [(4.0, False), (9.0, True)])
def test_rate_does_not_depend_on_blocks(blocks, late_s, rate, trips):
    """With each block as one reading of its mean at its end, 4 K/s would look like 24 K/s."""
    changes = feed(RISING, blocks, lambda at_s: rate * at_s, late_s=late_s)
    assert ("tripped" in changes) == trips


def test_jump_within_long_block_trips_rate():
    """It rises by 20 in 0.2 s, as single readings show; the means of blocks give 5.5 per s."""
    changes = feed(RISING, [2.0, 2.0], lambda at_s: np.clip(100 * (at_s - 1), 0, 20))
    assert "tripped" in changes


def test_interlock_not_due_is_not_read():
    device, clock = FakeTester(), SimulatedClock()
    rig = Rig({"tester": device}, clock)
    rig.connect()
    guard = Guard([replace(HOT, every_s=1.0)], rig, lambda *_args, **_more: None)
    for _ in range(3):
        guard.check()
        guard.look()  # as in a teardown, where nothing is raised
    assert device.calls.count("read load") == 1
    clock.sleep(1.0)
    guard.check()
    assert device.calls.count("read load") == 2


def test_text_names_value_that_tripped_and_value_that_cleared():
    watch = Watch(HOT, 0.0)
    take(watch, 3000.0, 1.0)
    assert watch.text == "tester.load is 3000 N, above 2000 N"
    take(watch, 1000.0, 2.0)
    assert watch.text == "tester.load is 1000 N again"


def test_times_of_samples_follow_a_slow_clock():
    """It loses 0.5 ms in a second, and the last good sample is that of 100.05 s before."""
    clock = SimulatedClock()
    rig = Rig({"tester": FakeTester()}, clock)
    guard = Guard([HOT], rig, lambda *_args, **_more: None)
    for block in range(10):
        clock.sleep(100.05)
        values = np.zeros(1000)
        values[-1] = 9e3 * (block == 9)
        guard.feed("tester", Block(10.0, 1000 * block, 0.0, {"load": values}))
    (watch,) = guard.tripped
    assert watch.latency_s == pytest.approx(100.05, abs=0.01)
