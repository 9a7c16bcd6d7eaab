"""Counters and labels of steps: on each action of the plan, in names of recordings, checked."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, STATION, TESTER, edited, only_problem
from rigrunner.plan import make_plan
from rigrunner.procedure import load_procedure, parse_procedure
from rigrunner.station import parse_station

MARK = "  - sweep:\n"
RECORD = "record: {channels: [tester.angle, tester.torque], cycles: 30}"
ALONE = PROCEDURE[: PROCEDURE.index("analysis:")]
"""Without analysis and acceptance."""


def plan_of(text, devices=None):
    procedure = parse_procedure(text, "p.yaml")
    return make_plan(procedure, parse_station(STATION, "s.yaml"), devices or {"tester": TESTER})


def with_steps(steps, text=ALONE):
    return edited(text, (MARK, f"  - set: {{tester.frequency: 10 Hz}}\n  - {steps}\n{MARK}"))


def coordinates(steps):
    plan = plan_of(with_steps(steps))
    return [(dict(step.coordinates), dict(step.coordinate_units)) for step in plan.steps
            if step.path.startswith("main[2]")]  # fmt: skip


def test_repeated_blocks_get_distinct_coordinates_and_names():
    plan = plan_of(with_steps(
        f"repeat: {{times: 6, as: block, label: {{phase: wear}}, steps: [{{{RECORD}}}]}}"
    ))  # fmt: skip
    names = [recording.record.name for recording in plan.recordings]
    assert names[:6] == [f"00{n}_10Hz_wear_block{n}" for n in range(1, 7)]
    assert names[6:] == ["007_2Hz", "008_10Hz"]
    assert [recording.coordinates for recording in plan.recordings[:2]] == [
        {"phase": "wear", "block": 1}, {"phase": "wear", "block": 2},
    ]  # fmt: skip


def test_labels_apply_to_inner_steps_only():
    inner = "group: {label: {part: x}, steps: [{wait: {time: 1 s, label: {dwell: 2 min}}}]}"
    steps = f"group: {{label: {{phase: wear}}, steps: [{{{inner}}}, {{wait: {{time: 1 s}}}}]}}"
    assert coordinates(steps) == [
        ({"phase": "wear", "part": "x", "dwell": 120.0}, {"dwell": "s"}),
        ({"phase": "wear"}, {}),
    ]


def test_set_and_sweep_accept_labels():
    over = "over: [1 N, 2 N], label: {stroke: up}, steps: [{note: {text: here}}]"
    assert [labels for labels, _ in coordinates(f"sweep: {{set: tester.load, {over}}}")] == [
        {"stroke": "up"}
    ] * 4
    ((labels, _),) = coordinates("set: {tester.load: 1 N, label: {aged: true}}")
    assert labels == {"aged": True}


def test_a_called_procedure_inherits_labels(tmp_path):
    (tmp_path / "inner.yaml").write_text(ALONE, encoding="utf-8")
    text = with_steps("call: {procedure: inner.yaml, label: {phase: final}}")
    (tmp_path / "outer.yaml").write_text(text, encoding="utf-8")
    procedure = load_procedure(tmp_path / "outer.yaml")
    plan = make_plan(procedure, parse_station(STATION, "s.yaml"), {"tester": TESTER})
    called = [step for step in plan.steps if step.path.startswith("main[2].call")]
    assert len(called) > 6
    assert all(step.coordinates == {"phase": "final"} for step in called)


# the step, where the finger points, field, message, hint
CASES = [
    ("group: {steps: [{wait: {time: 1 s, label: {x: 60 s}}}, {wait: {time: 1 s, label: {x: a}}}]}",
     "a}}}", "main[2].group.steps[1].wait.label.x", "of 'x' is text here and time at p.yaml",
     "two names"),
    ("repeat: {times: 2, as: x, steps: [{wait: {time: 1 s, label: {x: 1}}}]}",
     "1}}}", "main[2].repeat.steps[0].wait.label.x", "of 'x' is number here and counter at",
     "two names"),
    ("repeat: {times: 2, as: b, steps: [{repeat: {times: 2, as: b, steps: [{note: {text: x}}]}}]}",
     "b, steps: [{note", "main[2].repeat.steps[0].repeat.as",
     "a step around this one gives 'b' already", "choose another name"),
    ("group: {label: {x: a}, steps: [{wait: {time: 1 s, label: {x: b}}}]}",
     "b}}}", "main[2].group.steps[0].wait.label.x",
     "a step around this one gives 'x' already", "choose another name"),
]  # fmt: skip


@pytest.mark.parametrize(("step", "finger", "field", "message", "hint"), CASES)
def test_conflicting_label_names_are_refused(step, finger, field, message, hint):
    text = with_steps(step)
    problem = only_problem(lambda: plan_of(text))
    assert problem.location.line == text[: text.index(finger)].count("\n") + 1
    assert problem.field == field
    assert message in problem.message
    assert hint in problem.hint


@pytest.mark.parametrize(
    ("label", "message"),
    [
        ("{tester.load: 5}", "'tester.load' names a set-point"),
        ("{dwell: '1,5 s'}", "decimal comma"),
        ("{utc: x}", "tables have a column 'utc' already"),
    ],
)
def test_invalid_label_is_refused_with_its_line(label, message):
    text = with_steps(f"wait: {{time: 1 s, label: {label}}}")
    problem = only_problem(lambda: parse_procedure(text, "p.yaml"))
    assert problem.location.line == text[: text.index("time: 1 s, label")].count("\n") + 1
    assert message in problem.message
