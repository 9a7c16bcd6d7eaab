from __future__ import annotations

import threading

import pytest

from helpers_devices import SETUP, FakeTester, Listener, NthCall, plan_of, record, run
from rigrunner.api.errors import AbortedError, DeviceLostError, UsageError
from rigrunner.api.events import (
    Alarm,
    Answer,
    Intervention,
    MadeSafe,
    Outcome,
    Prompt,
    RunEnded,
    RunStarted,
    Samples,
    StepEnded,
    StepStarted,
)
from rigrunner.engine import StopNow, UnattendedAnswers
from rigrunner.plan.actions import Phase, Plan, PlannedStep
from rigrunner.procedure.answers import Expected
from rigrunner.rig.safe_state import NoRigError
from rigrunner.steps.ask import Ask
from rigrunner.steps.confirm import Confirm
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.settle import Settle

CALLS = 40
"""More than the device calls of the plan's setup and main."""
STANDSTILL = {"load": 0.0, "frequency": 0.0}
TEARDOWN_CALLS = ("set frequency 0", "set load 0")


def calls_of_main() -> list[str]:
    device = FakeTester()
    run(device)
    end = device.calls.index("set frequency 0")
    return device.calls[1:end]


def assert_safe_and_torn_down(device: FakeTester) -> None:
    assert device.drives_at == STANDSTILL
    assert device.calls[-1] == "make_safe"
    ended = [call for call in device.calls if call in TEARDOWN_CALLS]
    assert ended[-2:] == list(TEARDOWN_CALLS)


def test_completed_run_reports_start_steps_and_end():
    device, listener = FakeTester(), Listener()
    summary = run(device, critical=[listener])
    assert (summary.outcome, summary.reason, summary.error) == (Outcome.COMPLETED, "", None)
    assert summary.safe
    assert_safe_and_torn_down(device)
    assert [event.seq for event in listener.events] == list(range(len(listener.events)))
    (started,), (ended,) = listener.of(RunStarted), listener.of(RunEnded)
    assert listener.events[0] is started
    assert listener.events[-1] is ended
    assert (started.run_id, started.steps, started.estimated_s) == ("test-run", 12, 12.0)
    assert ended.outcome is Outcome.COMPLETED
    assert ended.read_back == {"tester.load": 0.0, "tester.frequency": 0.0}


def test_every_step_begins_and_ends_in_order():
    listener = Listener()
    run(FakeTester(), critical=[listener])
    started = [(event.index, event.step, event.action) for event in listener.of(StepStarted)]
    assert started == [(event.index, event.step, event.action) for event in listener.of(StepEnded)]
    assert [action for _, _, action in started] == [
        "confirm", "ask", "set", "zero", "set", "set", "settle", "record", "set", "record",
        "set", "set",
    ]  # fmt: skip
    assert all(event.ok for event in listener.of(StepEnded))


def test_settle_takes_simulated_time():
    listener = Listener()
    run(FakeTester(), critical=[listener])
    (started,) = (event for event in listener.of(StepStarted) if event.action == "settle")
    (ended,) = (event for event in listener.of(StepEnded) if event.action == "settle")
    assert ended.monotonic_s - started.monotonic_s == pytest.approx(0.3)


def test_questions_and_answers_are_recorded():
    listener = Listener()
    run(FakeTester(), critical=[listener])
    assert [event.text for event in listener.of(Prompt)] == ["Guards closed?", "Serial number?"]
    confirmed, answered = listener.of(Answer)
    assert (confirmed.text, confirmed.into) == ("yes", "")
    assert (answered.text, answered.into) == ("DEMO-0001", "specimen")
    assert answered.by == "unattended answer of the procedure"


def test_recording_carries_samples_conditions_setpoints_and_truth():
    listener = Listener()
    run(FakeTester(), critical=[listener])
    blocks = [event.block for event in listener.of(Samples) if event.recording == "001_10Hz"]
    assert [block.first_sample for block in blocks] == [0, 100, 200]
    assert set(blocks[0].channels) == {"tester.angle", "tester.torque"}
    (started,) = (event for event in listener.of(StepStarted) if event.recording == "001_10Hz")
    (ended,) = (event for event in listener.of(StepEnded) if event.recording == "001_10Hz")
    assert started.setpoints == {"tester.load": 1000.0, "tester.frequency": 10.0}
    assert ended.values == {"tester.load": 1000.0}
    assert ended.units["tester.torque"] == "N·m"
    assert ended.truth == {"starting_torque_nm": 0.7262}


def test_zero_is_mean_of_stream():
    listener = Listener()
    run(FakeTester(), critical=[listener])
    (ended,) = (event for event in listener.of(StepEnded) if event.action == "zero")
    ramp = [-0.01 + 1e-6 * number for number in range(200)]
    assert ended.values == {"tester.torque": pytest.approx(sum(ramp) / 200)}


@pytest.mark.parametrize("number", range(CALLS))
def test_error_at_any_call_ends_safe_and_torn_down(number):
    fault = NthCall(number, DeviceLostError("cable"), never=("connect", "make_safe"))
    device, listener = FakeTester(before=fault), Listener()
    summary = run(device, critical=[listener])
    if number < len(calls_of_main()):
        assert fault.raised_at == calls_of_main()[number]
        assert summary.outcome is Outcome.ERROR
        assert summary.reason == "tester: cable"
        assert summary.error is fault.error
        failed = [event for event in listener.of(StepEnded) if not event.ok]
        assert [event.source for event in listener.of(Alarm)] == [failed[0].step]
        assert_safe_and_torn_down(device)
    assert summary.safe
    assert device.drives_at == STANDSTILL
    assert listener.of(RunEnded)[0].outcome is summary.outcome
    assert listener.events[-1] is listener.of(RunEnded)[0]


def test_the_faults_above_reach_every_call():
    assert len(calls_of_main()) < CALLS


@pytest.mark.parametrize("number", range(CALLS))
@pytest.mark.parametrize("error", [KeyboardInterrupt(), SystemExit(1), ZeroDivisionError("bug")])
def test_anything_raised_at_any_call_ends_safe(number, error):
    device = FakeTester(before=NthCall(number, error, never=("connect", "make_safe")))
    listener = Listener()
    summary = run(device, critical=[listener])
    assert device.drives_at == STANDSTILL
    assert summary.safe
    if summary.error is not None:
        outcome = Outcome.ABORTED if isinstance(error, KeyboardInterrupt) else Outcome.ERROR
        assert summary.outcome is outcome
        assert error in (summary.error, summary.error.__cause__)
        assert listener.of(RunEnded)[0].outcome is outcome
    else:
        assert summary.outcome is Outcome.COMPLETED


def test_interrupt_is_recorded_as_intervention_from_keyboard():
    listener = Listener()
    summary = run(FakeTester(before=NthCall(3, KeyboardInterrupt())), critical=[listener])
    assert summary.reason == "interrupted from the keyboard"
    (intervention,) = listener.of(Intervention)
    assert (intervention.action, intervention.by) == ("abort", "keyboard")


@pytest.mark.parametrize("number", range(CALLS))
def test_stop_request_at_any_call_ends_aborted(number):
    stop = threading.Event()

    def request(_call: str, left: list[int] = [number]) -> None:  # noqa: B006  (counts down)
        left[0] -= 1
        if left[0] == -1:
            stop.set()

    device, listener = FakeTester(before=request), Listener()
    summary = run(device, critical=[listener], stop=stop)
    assert device.drives_at == STANDSTILL
    if number < len(calls_of_main()):
        assert (summary.outcome, summary.reason) == (Outcome.ABORTED, "stopped on request")
        assert listener.of(Intervention)[0].by == "stop request"
        assert_safe_and_torn_down(device)


def test_stop_request_ends_settling_within_a_tenth_of_a_second():
    stop, listener = threading.Event(), Listener()

    def request(event: object) -> None:
        if getattr(event, "action", "") == "settle":
            stop.set()

    listener.before = request
    summary = run(FakeTester(), critical=[listener], stop=stop)
    assert summary.outcome is Outcome.ABORTED
    (started,) = (event for event in listener.of(StepStarted) if event.action == "settle")
    (ended,) = (event for event in listener.of(StepEnded) if event.action == "settle")
    assert ended.monotonic_s - started.monotonic_s <= 0.1


def test_teardown_is_not_shortened_after_a_stop():
    stop, listener = threading.Event(), Listener()
    stop.set()
    teardown = (Settle(0.5), record("after", seconds=0.1))
    run(FakeTester(), plan_of((), (), teardown), critical=[listener], stop=stop)
    assert [event.ok for event in listener.of(StepEnded)] == [True, True]


def test_stop_request_ends_stream_between_blocks_even_if_device_ignores_it():
    class Stubborn(FakeTester):
        def stream(self, channels, duration_s, stop):  # noqa: ARG002
            return super().stream(channels, duration_s, threading.Event())

    stop, listener = threading.Event(), Listener()

    def request(event: object) -> None:
        if isinstance(event, Samples):
            stop.set()

    listener.before = request
    summary = run(Stubborn(), plan_of((), [record("one")], ()), critical=[listener], stop=stop)
    assert summary.outcome is Outcome.ABORTED
    assert len(listener.of(Samples)) == 1


def test_failing_teardown_step_does_not_stop_the_next():
    def refuse(call: str) -> None:
        if call == "set frequency 0":
            raise DeviceLostError("cable")

    device, listener = FakeTester(before=refuse), Listener()
    summary = run(device, critical=[listener])
    assert (summary.outcome, summary.reason) == (Outcome.ERROR, "tester: cable")
    assert device.calls[-3:] == ["set load 0", "read_back load", "make_safe"]
    assert [event.source for event in listener.of(Alarm)] == ["teardown[0]"]


def test_summary_lists_first_error_and_what_is_not_safe():
    def refuse(call: str) -> None:
        if call in ("stream", "set load 0", "make_safe"):
            raise DeviceLostError(f"no {call}")

    listener = Listener()
    plan = plan_of(setup=SETUP[3:])
    summary = run(FakeTester(before=refuse), plan, critical=[listener])
    failed = "tester: make safe failed: no make_safe"
    unsafe = f"{failed}; tester: load cannot be made safe: no set load 0"
    assert summary.reason == f"tester: no stream; the rig is not safe: {unsafe}"
    assert summary.unsafe == unsafe
    assert [(event.source, event.text) for event in listener.of(Alarm)] == [
        ("setup[0]", "tester: no stream"),
        ("teardown[1]", "tester: no set load 0"),
        ("make safe", "tester: make safe failed: no make_safe"),
        ("make safe", "tester: load cannot be made safe: no set load 0"),
    ]


def test_completed_run_with_unsafe_rig_is_an_error():
    def refuse(call: str) -> None:
        if call == "make_safe":
            raise DeviceLostError("cable")

    summary = run(FakeTester(before=refuse))
    assert (summary.outcome, summary.safe) == (Outcome.ERROR, False)
    assert summary.reason == "the rig is not safe: tester: make safe failed: cable"


@pytest.mark.parametrize("ending", [KeyboardInterrupt(), StopNow(), AbortedError("stop", by="me")])
def test_stopped_run_with_unsafe_rig_is_an_error(ending):
    def refuse(call: str) -> None:
        if call == "stream":
            raise ending
        if call == "make_safe":
            raise DeviceLostError("cable")

    listener = Listener()
    summary = run(FakeTester(before=refuse), critical=[listener])
    (ended,) = listener.of(RunEnded)
    assert (summary.outcome, summary.error) == (Outcome.ERROR, ending)
    assert ended.outcome is Outcome.ERROR
    assert ended.reason == summary.reason
    assert summary.reason.endswith("; the rig is not safe: tester: make safe failed: cable")


def count_events() -> int:
    listener = Listener()
    run(FakeTester(), critical=[listener])
    return len(listener.events)


@pytest.mark.parametrize("number", range(38))
def test_critical_sink_that_fails_at_any_event_stops_the_run_safely(number):
    full = NthCall(number, OSError("disk full"))
    device, guarded = FakeTester(), Listener()
    summary = run(device, critical=[full], guarded=[guarded])
    assert summary.outcome is (Outcome.ERROR if full.raised_at else Outcome.COMPLETED)
    assert summary.safe
    assert device.drives_at == STANDSTILL
    assert [call for call in device.calls if call in TEARDOWN_CALLS][-2:] == list(TEARDOWN_CALLS)
    assert len(guarded.of(RunEnded)) == 1
    if full.raised_at:
        assert "disk full" in summary.reason


def test_the_failures_above_reach_every_event():
    assert count_events() < 38


def test_guarded_sink_that_fails_does_not_stop_the_run():
    critical = Listener()
    summary = run(FakeTester(), critical=[critical], guarded=[NthCall(5, ValueError("screen"))])
    assert summary.outcome is Outcome.COMPLETED
    assert "dropped: ValueError: screen" in critical.of(Alarm)[0].text


def test_negative_confirmation_aborts():
    listener = Listener()
    plan = plan_of(setup=[Confirm("Guards closed?", unattended=False)])
    summary = run(FakeTester(), plan, critical=[listener])
    assert summary.outcome is Outcome.ABORTED
    assert summary.reason == "setup[0]: 'Guards closed?' was answered with no"
    assert listener.of(Answer)[0].text == "no"
    assert listener.of(Intervention)[0].by == "operator"


@pytest.mark.parametrize("question", [Confirm("Ready?", None), Ask("Name?", "operator", None)])
def test_unattended_run_without_answer_names_the_step(question):
    device = FakeTester()
    summary = run(device, plan_of(setup=[question]))
    assert isinstance(summary.error, UsageError)
    assert "setup[0]: there is nobody to answer" in summary.reason
    assert_safe_and_torn_down(device)


def test_operator_answers_are_used():
    class Operator(UnattendedAnswers):
        by = "operator"

        def ask(self, step: str, question: Ask) -> str:
            return f"{step} {question.text} {question.unattended}"

    listener = Listener()
    run(FakeTester(), critical=[listener], answers=Operator())
    assert listener.of(Answer)[1].text == "setup[1] Serial number? DEMO-0001"
    assert listener.of(Answer)[1].by == "operator"


def test_answer_is_recorded_as_its_choice():
    class Operator(UnattendedAnswers):
        def ask(self, step: str, question: Ask) -> str:  # noqa: ARG002
            return " LEFT"

    listener = Listener()
    question = Ask("Side?", "side", None, "rig.png", Expected(("left", "right")))
    run(FakeTester(), plan_of((), [question], ()), critical=[listener], answers=Operator())
    assert [(event.text, event.into) for event in listener.of(Answer)] == [("left", "side")]
    (prompt,) = listener.of(Prompt)
    assert (prompt.choices, prompt.picture) == (("left", "right"), "rig.png")
    assert prompt.expected == "left / right"


def test_set_records_the_read_back():
    listener = Listener()
    plan = plan_of((), [SetDrive("tester", "load", 1000.0, "N")], ())
    run(FakeTester(read_back_offset=0.1), plan, critical=[listener])
    assert listener.of(StepEnded)[0].values == {"tester.load": 1000.1}
    assert listener.of(StepEnded)[0].units == {"tester.load": "N"}


def test_safe_read_back_of_each_device_is_recorded():
    listener = Listener()
    run(FakeTester(), critical=[listener])
    (event,) = listener.of(MadeSafe)
    assert (event.what, event.problems) == ("tester", ())
    assert event.read_back == {"tester.load": 0.0, "tester.frequency": 0.0}


def test_device_not_made_safe_is_recorded():
    listener = Listener()
    run(FakeTester(read_back_offset=0.5), plan_of((), (), ()), critical=[listener])
    (event,) = listener.of(MadeSafe)
    assert event.problems == ("frequency reads back 0.5 Hz, safe is 0 Hz",)


class Impatient:
    """A stop token with a Ctrl-C at each event, until it is asked to stop interrupting."""

    is_quiet = False

    def __init__(self, *, at_the_last_moment: bool = False) -> None:
        self._late = at_the_last_moment

    def is_set(self) -> bool:
        return False

    def stop_interrupting(self) -> None:
        self.is_quiet = not self._late
        if self._late:
            self._late = False
            raise StopNow

    def press(self, event: object) -> None:
        if isinstance(event, (MadeSafe, RunEnded)) and not self.is_quiet:
            raise StopNow


def test_ctrl_c_while_making_safe_loses_no_event():
    device, stop = FakeTester(), Impatient()
    listener = Listener(before=stop.press)
    summary = run(device, critical=[listener], stop=stop)
    assert (summary.outcome, summary.safe) == (Outcome.COMPLETED, True)
    assert isinstance(listener.events[-1], RunEnded)


def test_failing_stop_token_does_not_prevent_making_safe():
    class Broken(Impatient):
        def stop_interrupting(self) -> None:
            raise RuntimeError("a bug of whoever made it")

    device = FakeTester()
    summary = run(device, stop=Broken())
    assert (summary.outcome, summary.safe) == (Outcome.ERROR, True)
    assert "a bug of whoever made it" in summary.reason
    assert device.drives_at == STANDSTILL


def test_ctrl_c_just_before_making_safe_aborts_and_leaves_rig_safe():
    device, listener = FakeTester(), Listener()
    summary = run(device, critical=[listener], stop=Impatient(at_the_last_moment=True))
    assert (summary.outcome, summary.safe) == (Outcome.ABORTED, True)
    assert device.drives_at == STANDSTILL
    assert isinstance(listener.events[-1], RunEnded)


def test_differing_replay_is_an_error_without_unsafe_rig():
    def lose(call):
        if call == "make_safe":
            raise NoRigError("the tape has no answer")

    summary = run(FakeTester(before=lose), plan_of((), (), ()))
    assert (summary.outcome, summary.safe) == (Outcome.ERROR, True)
    assert summary.reason == "tester: make safe failed: the tape has no answer"


class Interrupted(threading.Event):
    """A stop token that a second Ctrl-C interrupts just before the rig is made safe."""

    def stop_interrupting(self):
        raise KeyboardInterrupt


def test_interrupt_just_before_making_safe_does_not_prevent_it():
    device = FakeTester()
    summary = run(device, stop=Interrupted())
    assert device.calls[-1] == "make_safe"
    assert device.drives_at == {"load": 0.0, "frequency": 0.0}
    assert summary.outcome is Outcome.ABORTED
    assert summary.safe


def test_called_teardown_tries_each_step_once_despite_failures():
    def fail(call):
        if call == "set frequency 0":
            raise DeviceLostError("cable")

    device, within = FakeTester(before=fail), ("main[0].call",)
    actions = (
        (Phase.MAIN, SetDrive("tester", "load", 100.0, "N"), within),
        (Phase.TEARDOWN, SetDrive("tester", "load", 50.0, "N"), within),
        (Phase.TEARDOWN, SetDrive("tester", "frequency", 0.0, "Hz"), within),
        (Phase.TEARDOWN, SetDrive("tester", "load", 20.0, "N"), within),
        (Phase.MAIN, SetDrive("tester", "load", 500.0, "N"), ()),
        (Phase.TEARDOWN, SetDrive("tester", "load", 10.0, "N"), ()),
    )
    steps = (
        PlannedStep(f"step[{at}]", phase, action, "", 1.0, calls=calls)
        for at, (phase, action, calls) in enumerate(actions)
    )
    summary = run(device, Plan(tuple(steps)))
    assert summary.outcome is Outcome.ERROR
    sets = [call.removeprefix("set ") for call in device.calls if call.startswith("set ")]
    assert sets == ["load 100", "load 50", "frequency 0", "load 20", "load 10"]
