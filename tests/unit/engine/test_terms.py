"""Attempts, time-outs and limits of steps: what is repeated, tolerated, or ends the run."""

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


def execute(device, *actions, **more):
    listener = Listener()
    return run(device, steps(*actions), critical=[listener], **more), listener


def between(low, high, marginal=0.0, **more):
    limit = ValueLimit.between("tester.load", parse_quantity(low), parse_quantity(high), marginal)
    return Terms(limits=(limit,), **more)


def test_failed_attempt_is_recorded_and_repeated():
    fault = NthCall(0, DeviceLostError("cable"), never=("connect", "make_safe"))
    summary, listener = execute(FakeTester(before=fault), (LOAD, Terms(attempts=2)))

    assert (summary.outcome, summary.reason) == (Outcome.COMPLETED, "")
    assert [event.ok for event in listener.of(StepEnded)] == [False, True]
    assert len(listener.of(StepStarted)) == 2
    assert [event.text for event in listener.of(Alarm)] == ["tester: cable; try 1 of 2"]


def test_each_attempt_of_a_recording_has_its_own_name():
    fault = NthCall(2, DeviceTimeoutError("late"), never=("connect", "make_safe"))
    summary, listener = execute(FakeTester(before=fault), (record("001"), Terms(attempts=3)))

    assert summary.outcome is Outcome.COMPLETED
    assert [(event.recording, event.ok) for event in listener.of(StepEnded)] == [
        ("001", False),
        ("001_try2", True),
    ]


def test_last_failed_attempt_ends_run():
    def refuse(call):
        if call.startswith("read"):
            raise DeviceTimeoutError("late")

    summary, listener = execute(FakeTester(before=refuse), (LOAD, Terms(attempts=3)), LOAD)

    assert (summary.outcome, summary.reason) == (Outcome.ERROR, "tester: late")
    assert [event.ok for event in listener.of(StepEnded)] == [False] * 3
    assert len(listener.of(Alarm)) == 3


def test_run_continues_after_failure_if_step_allows_it():
    fault = NthCall(0, DeviceLostError("cable"), never=("connect", "make_safe"))
    summary, listener = execute(FakeTester(before=fault), (LOAD, Terms(continues=True)), LOAD)

    assert (summary.outcome, summary.error) == (Outcome.COMPLETED, None)
    assert summary.passed_over == ("main[0]: tester: cable",)
    assert summary.reason == "passed over: main[0]: tester: cable"
    assert [event.ok for event in listener.of(StepEnded)] == [False, True]
    assert [event.text for event in listener.of(Alarm)] == ["tester: cable; the run continues"]


@pytest.mark.parametrize("terms", [Terms(attempts=2), Terms(continues=True)])
def test_traceback_of_tolerated_failure_is_kept(terms):
    fault = NthCall(0, DeviceLostError("cable"), never=("connect", "make_safe"))
    clock, traced = SimulatedClock(), []
    rig = Rig({"tester": FakeTester(before=fault)}, clock)
    rig.connect()
    bus, never = Bus([], tracers=[traced.append]), threading.Event()
    run_plan(steps((LOAD, terms)), rig, bus, clock, UnattendedAnswers(), never, "traced")

    assert traced == [fault.error]


def test_message_of_driver_precedes_the_failure_that_it_explains():
    clock, listener = SimulatedClock(), Listener()

    def lose(call):
        if call.startswith("read"):
            rig.messages.take("tester", "warning", "low voltage")
            raise DeviceLostError("cable")

    rig = Rig({"tester": FakeTester(before=lose)}, clock)
    rig.connect()
    never = threading.Event()
    run_plan(steps(LOAD), rig, Bus([listener]), clock, UnattendedAnswers(), never, "logged")
    alarms = [(event.source, event.text) for event in listener.of(Alarm)]
    assert alarms == [("device tester", "warning: low voltage"), ("main[0]", "tester: cable")]


@pytest.mark.parametrize("error", [KeyboardInterrupt(), ZeroDivisionError("bug")])
def test_interrupts_and_bugs_are_not_retried(error):
    fault = NthCall(0, error, never=("connect", "make_safe"))
    summary, listener = execute(
        FakeTester(before=fault), (LOAD, Terms(attempts=5, continues=True)), LOAD
    )

    assert summary.error is error
    assert [event.ok for event in listener.of(StepEnded)] == [False]


def test_stop_request_is_not_a_tolerated_failure():
    stop = threading.Event()

    def request(call):
        if call == "block":
            stop.set()

    device = FakeTester(before=request)
    summary, _ = execute(
        device, (record("001"), Terms(attempts=5, continues=True)), LOAD, stop=stop
    )

    assert (summary.outcome, summary.reason) == (Outcome.ABORTED, "stopped on request")


@pytest.mark.parametrize("terms", [Terms(attempts=3), Terms(continues=True)])
def test_unwritable_samples_end_run_whatever_the_terms(terms):
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
def test_only_runs_ended_by_lost_devices_are_resumable(error, resumable):
    def refuse(call):
        if call.startswith("read"):
            raise error

    sink = Listener()
    summary = run(FakeTester(before=refuse), steps(LOAD), critical=[sink])
    assert summary.resumable is resumable
    assert [event.resumable for event in sink.of(RunEnded)] == [resumable]


def test_refused_run_is_not_resumable_even_if_writing_fails_too():
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


def test_failing_critical_sink_is_not_tolerated():
    broken = NthCall(3, OSError("disk full"))
    summary = run(
        FakeTester(), steps((LOAD, Terms(attempts=3, continues=True)), LOAD), critical=[broken]
    )

    assert summary.outcome is Outcome.ERROR
    assert "disk full" in summary.reason


def test_step_exceeding_its_timeout_fails():
    summary, listener = execute(FakeTester(), (Wait(5.0), Terms(timeout_s=2.0)))

    assert summary.outcome is Outcome.ERROR
    assert type(summary.error) is DeviceTimeoutError
    assert "the step is not done within 2 s" in summary.reason
    began, ended = listener.of(StepStarted)[0], listener.of(StepEnded)[0]
    assert 2.0 <= ended.monotonic_s - began.monotonic_s <= 2.2


def test_late_set_fails_although_it_succeeded():
    clock = SimulatedClock()

    def dawdle(call):
        if call.startswith("set load 5"):
            clock.sleep(3.0)

    action = (SetDrive("tester", "load", 5.0, "N"), Terms(timeout_s=2.0))
    summary, _ = execute(FakeTester(before=dawdle), action, clock=clock)

    assert "the step is not done within 2 s" in summary.reason


def test_timeout_of_step_applies_to_hanging_device():
    hang = threading.Event()

    def hanging(call):
        if call == "set load 5":
            hang.wait(10)

    action = (SetDrive("tester", "load", 5.0, "N"), Terms(timeout_s=0.1))
    summary, _ = execute(FakeTester(before=hanging, non_blocking=False), action)
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
def test_value_out_of_limits_is_kept_and_stops_run(terms, reason):
    device = FakeTester()
    summary, listener = execute(device, (LOAD, terms), SetDrive("tester", "load", 7.0, "N"))

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


def test_value_is_recorded_before_it_is_judged():
    _, listener = execute(FakeTester(), (LOAD, between("0 N", "5 N")))
    order = [
        type(event) for event in listener.events if isinstance(event, (StepEnded, Note, RunEnded))
    ]
    assert order[:2] == [StepEnded, LimitMissed]


def test_run_continues_after_value_out_of_limits_if_step_allows_it():
    device = FakeTester()
    continues = between("0 N", "5 N", continues=True, stops_at_limit=False)
    summary, listener = execute(device, (LOAD, continues), SetDrive("tester", "load", 7.0, "N"))

    assert (summary.outcome, summary.reason) == (Outcome.COMPLETED, "")
    assert summary.passed_over == ()
    assert "set load 7" in device.calls
    assert len(listener.of(LimitMissed)) == 1


def test_value_out_of_limits_is_not_read_again():
    device = FakeTester()
    summary, listener = execute(device, (LOAD, between("0 N", "5 N", attempts=3)))

    assert summary.outcome is Outcome.STOPPED_AT_LIMIT
    assert len(listener.of(StepStarted)) == 1
    assert len(measured(listener.events).rows) == 1


def test_device_error_outranks_missed_limit():
    fault = NthCall(1, DeviceLostError("cable"), never=("connect", "make_safe"))
    continues = between("0 N", "5 N", stops_at_limit=False)
    summary, listener = execute(
        FakeTester(before=fault), (LOAD, continues), SetDrive("tester", "load", 7.0, "N")
    )
    assert summary.outcome is Outcome.ERROR
    assert len(measured(listener.events).rows) == 1


def test_missed_limit_in_teardown_does_not_stop_it():
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
def test_marginal_value_is_noted_and_passes(terms, note):
    summary, listener = execute(FakeTester(), (LOAD, terms))

    assert (summary.outcome, summary.reason) == (Outcome.COMPLETED, "")
    assert [event.text for event in listener.of(Note)] == ([note] if note else [])


def test_temperature_is_shown_in_unit_of_its_limit():
    limit = ValueLimit.between("tester.load", None, parse_quantity("26 °C"))
    _, listener = execute(FakeTester(), (LOAD, Terms(limits=(limit,))))

    assert listener.of(LimitMissed)[0].text == "tester.load is 726.9 °C (limit: 26 °C or less)"


def test_every_value_out_of_limits_is_reported():
    limits = tuple(
        ValueLimit(f"tester.{name}", maximum=0.0, unit="N") for name in ("load", "torque")
    )
    channels = (Member("tester", "load"), Member("tester", "torque"))
    action = Measure("table", channels, 0.0, {}, dict.fromkeys(channels, "N"))
    summary, _ = execute(FakeTester(), (action, Terms(limits=limits)))

    assert summary.reason == (
        "tester.load is 1000 N (limit: 0 N or less); tester.torque is 1000 N (limit: 0 N or less)"
    )


def test_recording_with_conditions_out_of_limits_is_complete_and_fails():
    summary, listener = execute(FakeTester(), (record("001"), between("0 N", "5 N")))

    assert summary.outcome is Outcome.STOPPED_AT_LIMIT
    assert (listener.of(StepEnded)[0].recording, listener.of(StepEnded)[0].ok) == ("001", True)
    (row,) = measured(listener.events).rows
    assert (row.name, row.recording, row.values) == ("recorded", "001", {"tester.load": 1000.0})


def test_zero_can_have_limits():
    limit = ValueLimit("tester.torque", maximum=-0.02, unit="mN·m")
    action = Zero("tester", "torque", "N·m", 0.05, 0.2)
    summary, listener = execute(FakeTester(), (action, Terms(limits=(limit,))))

    assert summary.reason.startswith("tester.torque is -9.9")
    assert summary.outcome is Outcome.STOPPED_AT_LIMIT
    (row,) = measured(listener.events).rows
    assert (row.name, [decision.passes for decision in row.decisions]) == ("zeroed", [False])
    assert row.units == {"tester.torque": "N·m"}


def test_single_values_form_a_table_row():
    _, listener = execute(FakeTester(), LOAD)
    (ended,) = listener.of(StepEnded)

    assert (ended.measurement, ended.setpoints) == ("table", {"tester.load": 5.0})
    assert (ended.values, ended.units) == ({"tester.load": 1000.0}, {"tester.load": "N"})


def test_average_covers_all_samples_of_stream():
    device = FakeTester()
    _, listener = execute(device, MEAN)
    expected = sum(-0.01 + 1e-6 * n for n in range(200)) / 200

    assert listener.of(StepEnded)[0].values == {"tester.torque": pytest.approx(expected)}
    assert "stream" in device.calls


def test_average_without_stream_takes_several_readings():
    device = FakeTester()
    _, listener = execute(device, READ_MEAN)
    began, ended = listener.of(StepStarted)[0], listener.of(StepEnded)[0]

    assert device.calls.count("read load") == 5
    assert ended.monotonic_s - began.monotonic_s == pytest.approx(0.5)
    assert ended.values == {"tester.load": 1000.0}


def test_ramp_takes_even_steps_and_ends_on_time():
    device, clock = FakeTester(), SimulatedClock()
    times = []
    device.before = lambda call: (
        times.append(clock.monotonic_s()) if call.startswith("set") else None
    )
    summary, listener = execute(device, Ramp("tester", "load", 100.0, 200.0, "N", 2.0), clock=clock)
    values = [float(call.split()[2]) for call in device.calls if call.startswith("set load")]

    assert summary.outcome is Outcome.COMPLETED
    assert values == pytest.approx([100.0, *(100 + 5 * n for n in range(1, 21))])
    assert times == pytest.approx([0.0, *(0.1 * n for n in range(20))])
    ended = listener.of(StepEnded)[0]
    assert ended.values == {"tester.load": 200.0}
    assert ended.monotonic_s == pytest.approx(2.0)


def test_long_ramp_has_limited_number_of_steps():
    device = FakeTester()
    execute(device, Ramp("tester", "load", 0.0, 100.0, "N", 3600.0))

    assert sum(call.startswith("set load") for call in device.calls) == 1001


def test_stop_request_interrupts_ramp():
    stop, device = threading.Event(), FakeTester()

    def request(call):
        if call.startswith("set load 1"):
            stop.set()

    device.before = request
    summary, _ = execute(device, Ramp("tester", "load", 0.0, 10.0, "N", 10.0), stop=stop)

    assert summary.outcome is Outcome.ABORTED
    assert max(float(c.split()[2]) for c in device.calls if c.startswith("set load")) < 1.2


def test_stop_request_interrupts_ramp_of_slow_drive():
    """There is then no wait between two set-points, which would notice the stop."""
    clock, stop = SimulatedClock(), threading.Event()

    def slow(call):
        if call.startswith("set"):
            clock.sleep(1.0)
        if call == "set load 2":
            stop.set()

    device = FakeTester(before=slow)
    ramp = Ramp("tester", "load", 0.0, 10.0, "N", 1.0)
    summary, _ = execute(device, ramp, stop=stop, clock=clock)
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


def test_channels_of_two_devices_are_measured_in_requested_order():
    channels = (Member("room", "room"), Member("tester", "load"))
    action = Measure("table", channels, 0.0, {}, {"room.room": "K", "tester.load": "N"})
    listener, clock = Listener(), SimulatedClock()
    rig = Rig({"tester": FakeTester(), "room": Room()}, clock)
    rig.connect()
    bus, never = Bus([listener]), threading.Event()
    run_plan(steps(action), rig, bus, clock, UnattendedAnswers(), never, "two")
    (ended,) = listener.of(StepEnded)
    assert list(ended.values.items()) == [("room.room", 296.0), ("tester.load", 1000.0)]


def test_ramp_of_zero_duration_goes_to_its_end():
    device = FakeTester()
    execute(device, Ramp("tester", "load", 0.0, 10.0, "N", 0.0))
    assert [c for c in device.calls if c.startswith("set load")] == ["set load 0", "set load 10"]
