"""Tries, time-outs and limits of steps: what is tried again, passed over, or ends the run."""

from __future__ import annotations

import threading

import pytest

from helpers_devices import FakeTester, Listener, NthCall, measured, record, run
from rigrunner.api.devices import ChannelInfo
from rigrunner.api.errors import (
    DataError,
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
)
from rigrunner.api.events import (
    Alarm,
    LimitMissed,
    Note,
    Outcome,
    RunEnded,
    Samples,
    StepEnded,
    StepStarted,
)
from rigrunner.api.limits import ValueLimit
from rigrunner.api.member import Member
from rigrunner.api.quantity import parse_quantity
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.plan.actions import Phase, Plan, PlannedStep, Terms
from rigrunner.rig import Rig
from rigrunner.steps.measure import Measure
from rigrunner.steps.ramp import Ramp
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.wait import Wait
from rigrunner.steps.zero import Zero

LOAD = Measure(
    "table", (Member("tester", "load"),), 0.0, {"tester.load": 5.0}, {"tester.load": "N"}
)
MEAN = Measure("table", (Member("tester", "torque"),), 0.2, {}, {"tester.torque": "N·m"}, 1000.0)
READ_MEAN = Measure("table", (Member("tester", "load"),), 0.5, {}, {"tester.load": "N"})


def steps(*actions):
    """Return a plan of these steps, each an action or an action with its terms."""
    pairs = [step if isinstance(step, tuple) else (step, Terms()) for step in actions]
    return Plan(
        tuple(
            PlannedStep(f"main[{n}]", Phase.MAIN, action, "", 1.0, terms)
            for n, (action, terms) in enumerate(pairs)
        )
    )


def done(device, *actions, **more):
    listener = Listener()
    return run(device, steps(*actions), critical=[listener], **more), listener


def between(low, high, marginal=0.0, **more):
    limit = ValueLimit.between("tester.load", parse_quantity(low), parse_quantity(high), marginal)
    return Terms(limits=(limit,), **more)


def test_a_failure_is_tried_again_and_put_on_record():
    fault = NthCall(0, DeviceLostError("cable"), never=("connect", "make_safe"))
    summary, listener = done(FakeTester(before=fault), (LOAD, Terms(attempts=2)))

    assert (summary.outcome, summary.reason) == (Outcome.COMPLETED, "")
    assert [event.ok for event in listener.of(StepEnded)] == [False, True]
    assert len(listener.of(StepStarted)) == 2
    assert [event.text for event in listener.of(Alarm)] == ["tester: cable; try 1 of 2"]


def test_each_try_of_a_recording_is_a_recording_of_its_own():
    fault = NthCall(2, DeviceTimeoutError("late"), never=("connect", "make_safe"))
    summary, listener = done(FakeTester(before=fault), (record("001"), Terms(attempts=3)))

    assert summary.outcome is Outcome.COMPLETED
    assert [(event.recording, event.ok) for event in listener.of(StepEnded)] == [
        ("001", False),
        ("001_try2", True),
    ]


def test_the_last_failure_ends_the_run():
    def refuse(call):
        if call.startswith("read"):
            raise DeviceTimeoutError("late")

    summary, listener = done(FakeTester(before=refuse), (LOAD, Terms(attempts=3)), LOAD)

    assert (summary.outcome, summary.reason) == (Outcome.ERROR, "tester: late")
    assert [event.ok for event in listener.of(StepEnded)] == [False] * 3
    assert len(listener.of(Alarm)) == 3


def test_the_run_goes_on_where_the_procedure_says_so_and_says_so_itself():
    fault = NthCall(0, DeviceLostError("cable"), never=("connect", "make_safe"))
    summary, listener = done(FakeTester(before=fault), (LOAD, Terms(continues=True)), LOAD)

    assert (summary.outcome, summary.error) == (Outcome.COMPLETED, None)
    assert summary.passed_over == ("main[0]: tester: cable",)
    assert summary.reason == "passed over: main[0]: tester: cable"
    assert [event.ok for event in listener.of(StepEnded)] == [False, True]
    assert [event.text for event in listener.of(Alarm)] == ["tester: cable; the run continues"]


@pytest.mark.parametrize("terms", [Terms(attempts=2), Terms(continues=True)])
def test_a_failure_after_which_the_run_goes_on_is_kept_with_its_traceback(terms):
    fault = NthCall(0, DeviceLostError("cable"), never=("connect", "make_safe"))
    clock, traced = SimulatedClock(), []
    rig = Rig({"tester": FakeTester(before=fault)}, clock)
    rig.connect()
    bus, never = Bus([], tracers=[traced.append]), threading.Event()
    run_plan(steps((LOAD, terms)), rig, bus, clock, UnattendedAnswers(), never, "traced")

    assert traced == [fault.error]


@pytest.mark.parametrize("error", [KeyboardInterrupt(), ZeroDivisionError("bug")])
def test_neither_a_person_nor_a_bug_is_tried_again(error):
    fault = NthCall(0, error, never=("connect", "make_safe"))
    summary, listener = done(
        FakeTester(before=fault), (LOAD, Terms(attempts=5, continues=True)), LOAD
    )

    assert summary.error is error
    assert [event.ok for event in listener.of(StepEnded)] == [False]


def test_a_stop_is_no_failure_that_is_passed_over():
    stop = threading.Event()

    def request(call):
        if call == "block":
            stop.set()

    device = FakeTester(before=request)
    summary, _ = done(device, (record("001"), Terms(attempts=5, continues=True)), LOAD, stop=stop)

    assert (summary.outcome, summary.reason) == (Outcome.ABORTED, "stopped on request")


@pytest.mark.parametrize("terms", [Terms(attempts=3), Terms(continues=True)])
def test_samples_that_cannot_be_kept_end_the_run_whatever_the_step_allows(terms):
    full = DataError("cannot write 000001.samples: No space left on device")

    def keep(event):
        if isinstance(event, Samples):
            raise full

    sink = Listener()
    plan = steps((record("001"), terms), LOAD)
    summary = run(FakeTester(), plan, critical=[Listener(keep), sink])

    assert (summary.outcome, summary.error) == (Outcome.ERROR, full)
    assert [event.step for event in sink.of(StepStarted)] == ["main[0]"]
    assert [event.resumable for event in sink.of(RunEnded)] == [True]
    assert [event.source for event in sink.of(Alarm)] == ["main[0]"]


@pytest.mark.parametrize(
    ("error", "resumable"),
    [
        (DeviceTimeoutError("late"), True),
        (DeviceLostError("cable"), True),
        (DeviceRejectedError("no such range"), False),
        (DataError("beyond limits"), False),
        (ZeroDivisionError("bug"), False),
        (KeyboardInterrupt(), False),
    ],
)
def test_a_run_that_a_lost_device_ended_may_be_resumed(error, resumable):
    def refuse(call):
        if call.startswith("read"):
            raise error

    sink = Listener()
    summary = run(FakeTester(before=refuse), steps(LOAD), critical=[sink])
    assert summary.resumable is resumable
    assert [event.resumable for event in sink.of(RunEnded)] == [resumable]


def test_a_run_that_a_device_refused_is_not_one_to_go_on_with_though_it_is_not_kept_either():
    def refuse(call):
        if call.startswith("read"):
            raise DeviceRejectedError("late")

    def keep(event):
        if isinstance(event, StepEnded):
            raise DataError("cannot write events: No space left on device")

    sink = Listener()
    summary = run(FakeTester(before=refuse), steps(LOAD), critical=[Listener(keep), sink])

    assert (summary.outcome, summary.reason) == (Outcome.ERROR, "tester: late")
    assert [event.resumable for event in sink.of(RunEnded)] == [False]


def test_a_critical_sink_that_fails_is_not_passed_over():
    broken = NthCall(3, OSError("disk full"))
    summary = run(
        FakeTester(), steps((LOAD, Terms(attempts=3, continues=True)), LOAD), critical=[broken]
    )

    assert summary.outcome is Outcome.ERROR
    assert "disk full" in summary.reason


def test_a_step_that_takes_too_long_has_failed():
    summary, listener = done(FakeTester(), (Wait(5.0), Terms(timeout_s=2.0)))

    assert summary.outcome is Outcome.ERROR
    assert type(summary.error) is DeviceTimeoutError
    assert "the step is not done within 2 s" in summary.reason
    began, ended = listener.of(StepStarted)[0], listener.of(StepEnded)[0]
    assert 2.0 <= ended.monotonic_s - began.monotonic_s <= 2.2


def test_a_set_that_comes_late_has_failed_though_it_came():
    clock = SimulatedClock()

    def dawdle(call):
        if call.startswith("set load 5"):
            clock.sleep(3.0)

    action = (SetDrive("tester", "load", 5.0, "N"), Terms(timeout_s=2.0))
    summary, _ = done(FakeTester(before=dawdle), action, clock=clock)

    assert "the step is not done within 2 s" in summary.reason


def test_a_time_out_replaces_the_patience_with_a_device_that_hangs():
    hang = threading.Event()

    def hanging(call):
        if call == "set load 5":
            hang.wait(10)

    action = (SetDrive("tester", "load", 5.0, "N"), Terms(timeout_s=0.1))
    summary, _ = done(FakeTester(before=hanging, non_blocking=False), action)
    hang.set()

    assert type(summary.error) is DeviceTimeoutError
    assert "'set load' did not return within 0.1 s" in summary.reason


@pytest.mark.parametrize(
    ("terms", "reason"),
    [
        (between("0 N", "1 kN"), ""),
        (between("1 kN", "2 kN"), ""),
        (between("0 N", "0.9 kN"), "tester.load is 1 kN (limit: 0.9 kN or less)"),
        (between("1001 N", "2000 N"), "tester.load is 1000 N (limit: 1001 N or more)"),
    ],
)
def test_a_value_out_of_limits_is_kept_and_stops_the_run(terms, reason):
    device = FakeTester()
    summary, listener = done(device, (LOAD, terms), SetDrive("tester", "load", 7.0, "N"))

    assert (summary.reason, summary.error) == (reason, None)
    assert summary.outcome is (Outcome.STOPPED_AT_LIMIT if reason else Outcome.COMPLETED)
    ended = listener.of(StepEnded)[0]
    assert (ended.ok, ended.values) == (True, {"tester.load": 1000.0})
    assert [event.text for event in listener.of(LimitMissed)] == ([reason] if reason else [])
    assert ("set load 7" in device.calls) is (not reason)
    assert device.calls.count("make_safe") >= 1
    (row,) = measured(listener.events).rows
    assert row.values == {"tester.load": 1000.0}
    assert [decision.passes for decision in row.decisions] == [not reason]


def test_a_value_is_on_record_before_its_judgement():
    _, listener = done(FakeTester(), (LOAD, between("0 N", "5 N")))
    order = [
        type(event) for event in listener.events if isinstance(event, (StepEnded, Note, RunEnded))
    ]
    assert order[:2] == [StepEnded, LimitMissed]


def test_a_run_goes_on_after_a_value_out_of_limits_where_the_step_says_so():
    device = FakeTester()
    continues = between("0 N", "5 N", continues=True, stops_at_limit=False)
    summary, listener = done(device, (LOAD, continues), SetDrive("tester", "load", 7.0, "N"))

    assert (summary.outcome, summary.reason) == (Outcome.COMPLETED, "")
    assert summary.passed_over == ()
    assert "set load 7" in device.calls
    assert len(listener.of(LimitMissed)) == 1


def test_a_value_out_of_limits_is_not_read_again():
    device = FakeTester()
    summary, listener = done(device, (LOAD, between("0 N", "5 N", attempts=3)))

    assert summary.outcome is Outcome.STOPPED_AT_LIMIT
    assert len(listener.of(StepStarted)) == 1
    assert len(measured(listener.events).rows) == 1


def test_a_device_error_in_the_same_run_goes_before_a_missed_limit():
    fault = NthCall(1, DeviceLostError("cable"), never=("connect", "make_safe"))
    continues = between("0 N", "5 N", stops_at_limit=False)
    summary, listener = done(
        FakeTester(before=fault), (LOAD, continues), SetDrive("tester", "load", 7.0, "N")
    )
    assert summary.outcome is Outcome.ERROR
    assert len(measured(listener.events).rows) == 1


def test_a_stop_at_a_limit_does_the_teardown_and_a_limit_there_stops_nothing():
    last = SetDrive("tester", "load", 7.0, "N")
    stops = between("0 N", "5 N")
    plan = Plan(
        tuple(
            PlannedStep(f"{phase}[{n}]", phase, action, "", 1.0, terms)
            for n, (phase, action, terms) in enumerate(
                [
                    (Phase.MAIN, LOAD, Terms()),
                    (Phase.TEARDOWN, LOAD, stops),
                    (Phase.TEARDOWN, last, Terms()),
                ]
            )
        )
    )
    listener, device = Listener(), FakeTester()
    summary = run(device, plan, critical=[listener])

    assert summary.outcome is Outcome.COMPLETED
    assert "set load 7" in device.calls
    rows = measured(listener.events).rows
    assert [decision.passes for row in rows for decision in row.decisions] == [False]


@pytest.mark.parametrize(
    ("terms", "note"),
    [
        (between("0 N", "1100 N", 100), None),
        (
            between("0 N", "1100 N", 101),
            "tester.load is 1000 N, marginal (limit: 1100 N or less)",
        ),
        (between("900 N", "2 kN", 99), None),
        (
            between("0.9 kN", "2 kN", 101),
            "tester.load is 1 kN, marginal (limit: 0.9 kN or more)",
        ),
    ],
)
def test_a_marginal_value_is_put_on_record_and_passes(terms, note):
    summary, listener = done(FakeTester(), (LOAD, terms))

    assert (summary.outcome, summary.reason) == (Outcome.COMPLETED, "")
    assert [event.text for event in listener.of(Note)] == ([note] if note else [])


def test_limits_of_temperature_are_told_in_the_unit_of_the_limit():
    limit = ValueLimit.between("tester.load", None, parse_quantity("26 °C"))
    _, listener = done(FakeTester(), (LOAD, Terms(limits=(limit,))))

    assert listener.of(LimitMissed)[0].text == "tester.load is 726.9 °C (limit: 26 °C or less)"


def test_all_values_beyond_limits_are_told():
    limits = tuple(
        ValueLimit(f"tester.{name}", maximum=0.0, unit="N") for name in ("load", "torque")
    )
    channels = (Member("tester", "load"), Member("tester", "torque"))
    action = Measure("table", channels, 0.0, {}, dict.fromkeys(channels, "N"))
    summary, _ = done(FakeTester(), (action, Terms(limits=limits)))

    assert summary.reason == (
        "tester.load is 1000 N (limit: 0 N or less); tester.torque is 1000 N (limit: 0 N or less)"
    )


def test_a_recording_whose_conditions_are_out_of_limits_is_whole_and_fails():
    summary, listener = done(FakeTester(), (record("001"), between("0 N", "5 N")))

    assert summary.outcome is Outcome.STOPPED_AT_LIMIT
    assert (listener.of(StepEnded)[0].recording, listener.of(StepEnded)[0].ok) == ("001", True)
    (row,) = measured(listener.events).rows
    assert (row.name, row.recording, row.values) == ("recorded", "001", {"tester.load": 1000.0})


def test_a_zero_has_limits_beside_what_it_may_be():
    limit = ValueLimit("tester.torque", maximum=-0.02, unit="mN·m")
    action = Zero("tester", "torque", "N·m", 0.05, 0.2)
    summary, listener = done(FakeTester(), (action, Terms(limits=(limit,))))

    assert summary.reason.startswith("tester.torque is -9.9")
    assert summary.outcome is Outcome.STOPPED_AT_LIMIT
    (row,) = measured(listener.events).rows
    assert (row.name, [decision.passes for decision in row.decisions]) == ("zeroed", [False])
    assert row.units == {"tester.torque": "N·m"}


def test_single_values_are_a_row_of_a_table():
    _, listener = done(FakeTester(), LOAD)
    (ended,) = listener.of(StepEnded)

    assert (ended.measurement, ended.setpoints) == ("table", {"tester.load": 5.0})
    assert (ended.values, ended.units) == ({"tester.load": 1000.0}, {"tester.load": "N"})


def test_an_average_is_over_all_samples_of_the_stream():
    device = FakeTester()
    _, listener = done(device, MEAN)
    expected = sum(-0.01 + 1e-6 * n for n in range(200)) / 200

    assert listener.of(StepEnded)[0].values == {"tester.torque": pytest.approx(expected)}
    assert "stream" in device.calls


def test_an_average_of_a_device_that_is_read_takes_several_readings():
    device = FakeTester()
    _, listener = done(device, READ_MEAN)
    began, ended = listener.of(StepStarted)[0], listener.of(StepEnded)[0]

    assert device.calls.count("read load") == 5
    assert ended.monotonic_s - began.monotonic_s == pytest.approx(0.5)
    assert ended.values == {"tester.load": 1000.0}


def test_a_ramp_goes_in_small_even_steps_and_ends_on_time():
    device, clock = FakeTester(), SimulatedClock()
    times = []
    device.before = lambda call: (
        times.append(clock.monotonic_s()) if call.startswith("set") else None
    )
    summary, listener = done(device, Ramp("tester", "load", 100.0, 200.0, "N", 2.0), clock=clock)
    values = [float(call.split()[2]) for call in device.calls if call.startswith("set load")]

    assert summary.outcome is Outcome.COMPLETED
    assert values == pytest.approx([100.0, *(100 + 5 * n for n in range(1, 21))])
    assert times == pytest.approx([0.0, *(0.1 * n for n in range(20))])
    ended = listener.of(StepEnded)[0]
    assert ended.values == {"tester.load": 200.0}
    assert ended.monotonic_s == pytest.approx(2.0)


def test_a_long_ramp_is_a_bounded_number_of_steps():
    device = FakeTester()
    done(device, Ramp("tester", "load", 0.0, 100.0, "N", 3600.0))

    assert sum(call.startswith("set load") for call in device.calls) == 1001


def test_a_ramp_is_interrupted_when_the_run_is_to_stop():
    stop, device = threading.Event(), FakeTester()

    def request(call):
        if call.startswith("set load 1"):
            stop.set()

    device.before = request
    summary, _ = done(device, Ramp("tester", "load", 0.0, 10.0, "N", 10.0), stop=stop)

    assert summary.outcome is Outcome.ABORTED
    assert max(float(c.split()[2]) for c in device.calls if c.startswith("set load")) < 1.2


def test_a_ramp_is_interrupted_though_its_drive_takes_longer_than_it_may():
    """Nothing is waited for between two set-points then, and a wait would look as well."""
    clock, stop = SimulatedClock(), threading.Event()

    def slow(call):
        if call.startswith("set"):
            clock.sleep(1.0)
        if call == "set load 2":
            stop.set()

    device = FakeTester(before=slow)
    ramp = Ramp("tester", "load", 0.0, 10.0, "N", 1.0)
    summary, _ = done(device, ramp, stop=stop, clock=clock)
    assert summary.outcome is Outcome.ABORTED
    assert "set load 3" not in device.calls


class Room:
    """A second device, which is only read."""

    non_blocking = True
    channels = (ChannelInfo("room", "K", "Room"),)
    drives = ()

    def connect(self, timeout_s):
        return FakeTester().connect(timeout_s)

    def make_safe(self):
        return {}

    def close(self):
        """Nothing is held."""

    def read(self, channels):
        return dict.fromkeys(channels, 296.0)


def test_channels_of_two_devices_are_measured_together_in_their_order():
    channels = (Member("room", "room"), Member("tester", "load"))
    action = Measure("table", channels, 0.0, {}, {"room.room": "K", "tester.load": "N"})
    listener, clock = Listener(), SimulatedClock()
    rig = Rig({"tester": FakeTester(), "room": Room()}, clock)
    rig.connect()
    bus, never = Bus([listener]), threading.Event()
    run_plan(steps(action), rig, bus, clock, UnattendedAnswers(), never, "two")
    (ended,) = listener.of(StepEnded)
    assert list(ended.values.items()) == [("room.room", 296.0), ("tester.load", 1000.0)]


def test_a_ramp_that_takes_no_time_goes_to_its_end_at_once():
    device = FakeTester()
    done(device, Ramp("tester", "load", 0.0, 10.0, "N", 0.0))
    assert [c for c in device.calls if c.startswith("set load")] == ["set load 0", "set load 10"]
