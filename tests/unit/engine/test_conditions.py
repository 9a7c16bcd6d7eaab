"""Loops that end at a value, and steps that depend on an answer; also in resumed runs."""

from __future__ import annotations

import threading

import pytest

from helpers_devices import FakeTester, Listener, run
from helpers_language import STATION, edited, only_problem
from rigrunner.api.data import Estimate
from rigrunner.api.events import Note, Outcome, StepEnded, StepStarted
from rigrunner.clock import SimulatedClock
from rigrunner.engine import find_resume_point, streams_before
from rigrunner.engine.points import may_be_skipped
from rigrunner.plan import make_plan
from rigrunner.procedure import parse_procedure
from rigrunner.station import parse_station

HEAD = """\
rigrunner: procedure/2
id: TEST-1
revision: "A"
title: A test
measurand: {symbol: Td, name: torque}
inputs:
  side: {ask: Which side, choices: [left, right], unattended: left}
  room: {ask: Temperature, unit: °C, unattended: 20 °C}
uses: {tester: swing_tester}
"""
LOOP = """\
main:
  - repeat:
      until: {channel: tester.load, above: 1 kN}
      at_most: 4
      as: block
      steps:
        - set: {tester.frequency: 10 Hz}
        - record: {channels: [tester.angle, tester.torque], duration: 0.2 s}
  - measure: {channels: [tester.load], name: last}
"""


class Loaded(FakeTester):
    """A tester that reads these loads one after the other, and then always the last one."""

    def __init__(self, *loads):
        super().__init__()
        self.loads = list(loads)

    def read(self, channels):
        value = self.loads.pop(0) if len(self.loads) > 1 else self.loads[0]
        return dict.fromkeys(channels, value)


def plan_of(text):
    station = parse_station(STATION, "s.yaml")
    return make_plan(parse_procedure(HEAD + text, "p.yaml"), station, {"tester": FakeTester()})


def run_events(plan, device=None, resume_at=None, **inputs):
    listener = Listener()
    summary = run(
        device or FakeTester(), plan, guarded=[listener], resume_at=resume_at, inputs=inputs
    )
    assert summary.outcome is Outcome.COMPLETED, summary.reason
    return listener.events


def steps_of(events):
    return [event.step for event in events if isinstance(event, StepStarted)]


def notes_of(events):
    return [event.text for event in events if isinstance(event, Note)]


def passes(events):
    return [event.coordinates["block"] for event in events
            if isinstance(event, StepStarted) and event.action == "record"]  # fmt: skip


@pytest.mark.parametrize(
    ("loads", "blocks", "text"),
    [
        ((1500.0,), [1], "tester.load is 1.5 kN: above 1 kN after 1 of 4 times"),
        ((900.0, 1000.0, 1001.0), [1, 2, 3], "tester.load is 1.001 kN: above 1 kN after 3 of 4"),
        ((900.0,), [1, 2, 3, 4], "tester.load is 0.9 kN: not above 1 kN after all 4 times"),
    ],
)
def test_loop_ends_once_channel_exceeds_value(loads, blocks, text):
    """Each recording reads the load too, so each value is given twice."""
    device = Loaded(*(reading for load in loads for reading in (load, load)))
    events = run_events(plan_of(LOOP), device)
    assert passes(events) == blocks
    assert steps_of(events)[-1] == "main[1].measure"
    (note,) = notes_of(events)
    assert text in note


def test_loop_ends_once_channel_is_below_value():
    plan = plan_of(LOOP.replace("above: 1 kN", "below: 500 N"))
    assert passes(run_events(plan, Loaded(600.0, 600.0, 499.0))) == [1, 2]


def test_plan_contains_every_possible_pass():
    plan = plan_of(LOOP)
    assert plan.has_conditions
    assert len(plan.recordings) == 4
    conditions = [step for step in plan.steps if step.leaves]
    assert [step.leaves for step in conditions] == [9, 6, 3]
    assert conditions[0].text == "Until tester.load is above 1 kN: 1 of at most 4 times"
    assert not plan_of("main:\n  - wait: {time: 1 s}\n").has_conditions


BY_RESULT = LOOP.replace("channel: tester.load, above: 1 kN", "result: wear, above: 0.3 mm")


class Wear:
    """A result of 0.1 mm, 0.2 mm and so on; its calculation calls `begins`, then `ends`."""

    def __init__(self, begins=lambda: None, ends=lambda: None):
        self.count = 0
        self.begins, self.ends = begins, ends

    def __call__(self, name):
        assert name == "wear"
        self.count += 1
        self.begins()
        self.ends()
        return Estimate(100.0 * self.count, 1.0, unit="µm")


def test_loop_ends_once_result_exceeds_value():
    listener = Listener()
    summary = run(FakeTester(), plan_of(BY_RESULT), guarded=[listener], results=Wear())
    assert summary.outcome is Outcome.COMPLETED, summary.reason
    assert passes(listener.events) == [1, 2, 3, 4]
    assert notes_of(listener.events)[-1] == "wear is 0.4 mm: above 0.3 mm after 4 of 4 times"
    assert notes_of(listener.events)[2] == "wear is 0.3 mm: not above 0.3 mm after 3 of 4 times"


def test_run_can_be_stopped_during_calculation_of_result():
    stop, end, listener = threading.Event(), threading.Event(), Listener()
    wear = Wear(stop.set, lambda: end.wait(60))
    summary = run(FakeTester(), plan_of(BY_RESULT), guarded=[listener], results=wear, stop=stop)
    end.set()
    assert summary.outcome is Outcome.ABORTED
    assert (passes(listener.events), wear.count) == ([1], 1)


class Progress(SimulatedClock):
    """A clock that sets an event when it is used without waiting."""

    def __init__(self):
        super().__init__()
        self.made = threading.Event()

    def sleep(self, seconds):
        super().sleep(seconds)
        if not seconds:
            self.made.set()


def test_long_calculation_of_result_is_progress_for_guardian():
    """The guardian makes a rig safe whose run does not use its clock any more."""
    clock, made = Progress(), []
    wear = Wear(ends=lambda: made.append(clock.made.wait(60)))
    run(FakeTester(), plan_of(BY_RESULT.replace("0.3 mm", "0.05 mm")), clock=clock, results=wear)
    assert made == [True]


def test_condition_on_result_fails_without_calculation():
    summary = run(FakeTester(), plan_of(BY_RESULT))
    assert "'wear': no results are computed here" in summary.reason


KILLED = ["main[0].repeat[1].steps[0].set.tester.frequency", "main[0].repeat[1].steps[1].record"]


@pytest.mark.parametrize("killed", KILLED)
def test_interrupted_loop_resumes_with_same_pass(killed):
    plan = plan_of(LOOP)
    loads = (900.0, 900.0, 900.0, 1200.0)
    events = run_events(plan, Loaded(*loads))
    at = next(n for n, event in enumerate(events)
              if isinstance(event, StepStarted) and event.step == killed)  # fmt: skip
    resume_at = find_resume_point(plan.steps, events[: at + 1], "Ada")
    assert plan.steps[resume_at.start].path == KILLED[0]
    assert passes(run_events(plan, Loaded(1200.0), resume_at)) == [2]


def test_completed_loop_is_not_repeated_on_resume():
    plan = plan_of(LOOP)
    events = run_events(plan, Loaded(1200.0))
    at = next(n for n, event in enumerate(events)
              if isinstance(event, StepStarted) and event.step == "main[1].measure")  # fmt: skip
    resume_at = find_resume_point(plan.steps, events[: at + 1], "Ada")
    assert plan.steps[resume_at.start].path == "main[1].measure"
    assert resume_at.left_out == frozenset(range(3, 12))
    resumed = run_events(plan, Loaded(1200.0), resume_at)
    assert passes(resumed) == []
    assert len(streams_before(plan.steps, resume_at)["tester"]) == 1


def test_interrupted_loop_condition_is_checked_again_without_its_pass():
    plan = plan_of(LOOP)
    events = run_events(plan, Loaded(900.0, 900.0, 1200.0))
    at = next(n for n, event in enumerate(events) if isinstance(event, StepStarted)
              and event.step == "main[0].repeat[0].until")  # fmt: skip
    resume_at = find_resume_point(plan.steps, events[: at + 1], "Ada")
    assert plan.steps[resume_at.start].path == "main[0].repeat[0].until"
    assert passes(run_events(plan, Loaded(1200.0), resume_at)) == []


ANY = """\
setup:
  - wait: {time: 1 s, when: {input: side, is: right}}
main:
  - group:
      when: {input: side, is: [left]}
      steps:
        - set: {tester.load: 100 N}
        - wait: {time: 1 s}
        - set: {tester.load: 0 N}
  - measure: {channels: [tester.load], when: {input: side, is_not: left}}
  - wait: {time: 2 s}
"""


@pytest.mark.parametrize(
    ("side", "kinds"),
    [
        ("left", ["when", "when", "set", "wait", "set", "when", "wait"]),
        ("right", ["when", "wait", "when", "when", "measure", "wait"]),
    ],
)
def test_answer_selects_steps(side, kinds):
    events = run_events(plan_of(ANY), side=side)
    assert [event.action for event in events if isinstance(event, StepStarted)] == kinds


def test_step_is_left_out_if_its_question_was_not_asked():
    assert notes_of(run_events(plan_of(ANY)))[0] == (
        "side was not asked: the steps that hang on it are left out"
    )


def test_setup_step_left_out_by_condition_stays_out_after_resume():
    plan = plan_of(ANY)
    events = run_events(plan, side="left")
    at = next(n for n, event in enumerate(events)
              if isinstance(event, StepStarted) and event.step == "main[2].wait")  # fmt: skip
    resume_at = find_resume_point(plan.steps, events[: at + 1], "Ada")
    restored = "main[0].group.steps[2].set.tester.load"
    assert steps_of(run_events(plan, resume_at=resume_at, side="left")) == [
        restored,
        "main[2].wait",
    ]


def test_confirmation_can_be_a_condition():
    text = """\
main:
  - confirm: {text: Is it warm, into: warm, unattended: no}
  - wait: {time: 1 s, when: {input: warm, is: yes}}
  - wait: {time: 2 s, when: {input: warm, is: no}}
"""
    events = run_events(plan_of(text))
    waited = [event.step for event in events
              if isinstance(event, StepEnded) and event.action == "wait"]  # fmt: skip
    assert waited == ["main[2].wait"]


def test_set_point_is_not_skippable_if_condition_changes_drive_of_reading():
    """Only with the group would the load be at 0 N for the reading."""
    text = """\
main:
  - sweep:
      set: tester.load
      over: [100 N, 0 N]
      steps: [{wait: {time: 1 s}}]
  - group:
      when: {input: side, is: left}
      steps: [{set: {tester.load: 50 N}}, {set: {tester.load: 0 N}}]
  - measure: {channels: [tester.load]}
"""
    plan = plan_of(text)
    (at,) = (n for n, step in enumerate(plan.steps) if step.path == "main[0].sweep[1].set")
    assert not may_be_skipped(plan.steps, at, lambda _role, _drive: 100.0)
    assert may_be_skipped(plan.steps, at, lambda _role, _drive: 0.0)


WAIT = "main:\n  - wait: {time: 1 s, when: {input: side, is: left}}\n"
CASES = [
    (WAIT, ("input: side", "input: sid"), "main[0].wait.when.input",
     "no input 'sid' is asked by then", "did you mean 'side'?"),
    (WAIT, ("is: left", "is: lefft"), "main[0].wait.when.is",
     "'lefft' is not an answer to 'side'", "did you mean 'left'?"),
    (WAIT, ("input: side, is: left", "input: room, is: warm"), "main[0].wait.when.is",
     "'room' is a number with a unit, and compared with a text", "choices"),
    (WAIT, ("main:", "teardown:\n  - wait: {time: 1 s, when: {input: side, is: left}}\nmain:"),
     "teardown[0].wait.when", "the teardown is always executed", "remove the condition"),
    (ANY, ("        - set: {tester.load: 0 N}\n", ""), "main[0].group.when",
     "tester.load is at 100 N after this step, or at its safe value without it", "set it back"),
    (LOOP, ("tester.load, above", "tester.laod, above"), "main[0].repeat.until.channel",
     "has no channel 'laod'", "did you mean 'load'?"),
    (LOOP, ("1 kN", "1 Hz"), "main[0].repeat.until.above",
     "got '1 Hz', a frequency; tester.load takes a force", "write it in N"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "change", "field", "message", "hint"), CASES)
def test_invalid_condition_is_refused_in_the_plan(text, change, field, message, hint):
    problem = only_problem(plan_of, edited(text, change))
    assert problem.field == field
    assert message in problem.message
    assert hint in problem.hint


@pytest.mark.parametrize(
    ("step", "message"),
    [
        ("repeat: {steps: [{wait: {time: 1 s}}]}", "got neither, expected one of: times, until"),
        ("repeat: {until: {channel: a.b, above: 1 N}, steps: [{wait: {time: 1 s}}]}",
         "the key 'at_most' is missing"),
        ("repeat: {times: 2, at_most: 3, steps: [{wait: {time: 1 s}}]}",
         "the key 'until' is missing"),
        ("repeat: {until: {above: 1 N·m}, at_most: 3, steps: [{wait: {time: 1 s}}]}",
         "expected one of: channel, result"),
        ("repeat: {until: {channel: a.b}, at_most: 3, steps: [{wait: {time: 1 s}}]}",
         "expected one of: above, below"),
        ("wait: {time: 1 s, when: {input: side}}", "expected one of: is, is_not"),
        ("wait: {time: 1 s, when: {input: side, is: 5}}", "expected a text"),
    ],
)  # fmt: skip
def test_wrongly_written_condition_is_refused(step, message):
    problem = only_problem(lambda: parse_procedure(f"{HEAD}main:\n  - {step}\n", "p.yaml"))
    assert message in problem.message
    assert problem.location.line == HEAD.count("\n") + 2
