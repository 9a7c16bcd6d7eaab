"""Spoiled steps of every kind: line, column, field, what was got, what is allowed."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, edited, only_problem, place_of, problems_of
from rigrunner.procedure import parse_procedure

AT = "main[1].sweep.steps[0]"
MARK = "settle: {cycles: 5}"

# the step, where the finger points, field below the step, message, hint (None: others follow)
CASES = [
    ("ramp: {to: 5 N, time: 1 s}", "ramp", ".ramp.drive", "the key 'drive' is missing", ""),
    ("ramp: {drive: tester.load, time: 1 s}", "ramp", ".ramp.to", "the key 'to' is missing", ""),
    ("ramp: {drive: tester.load, to: 5 N}", "{drive", ".ramp",
     "got neither, expected one of: rate, time", ""),
    ("ramp: {drive: tester.load, to: 5 N, time: 1 s, rate: 1 N/s}", "{drive", ".ramp",
     "got both, expected one of: rate, time", ""),
    ("ramp: {drive: tester.load, to: 5, time: 1 s}", "5, time", ".ramp.to",
     "5 is not a number with a unit", "such as '10 Hz'"),
    ("ramp: {drive: tester.load, to: 5 N, rate: 5 N/sec}", "5 N/sec", ".ramp.rate",
     "unknown unit 'N/sec'", "did you mean 'N/s'?"),
    ("ramp: {drive: tester.load, to: 5 N, time: 5 N}", "5 N}", ".ramp.time",
     "'5 N' is a force, not a time", "units of time: s, ms, min, h, d"),
    ("ramp: {drive: tester.load, to: 5 N, over: 5 s}", "over", ".ramp.over",
     "unknown key 'over'", "known keys: label, when, drive, from, to, rate, time"),
    ("wait: 5 s", "5 s", ".wait", "got '5 s', expected a mapping of names to values", ""),
    ("wait: {time: 0 s}", "0 s}", ".wait.time", "got '0 s', expected more than 0", ""),
    ("wait: {time: 1:30}", "1:30", ".wait.time", "'1:30' has more than one number", ""),
    ("wait: {tiem: 1 s}", "wait", ".wait.time", "the key 'time' is missing", None),
    ("note: Watch out", "Watch", ".note",
     "got 'Watch out', expected a mapping of names to values", ""),
    ("note: {text: 5}", "5}", ".note.text", "got 5, expected a text", "put it in quotes: '5'"),
    ("repeat: {times: 0, steps: [wait: {time: 1 s}]}", "0, steps", ".repeat.times",
     "got 0, expected 1 or more", ""),
    ("repeat: {times: 2.5, steps: [wait: {time: 1 s}]}", "2.5", ".repeat.times",
     "got 2.5, expected a whole number", ""),
    ("repeat: {times: 2, steps: []}", "[]}", ".repeat.steps",
     "got a list of 0, expected 1 or more", ""),
    ("repeat: {times: 2, steps: [wiat: {time: 1 s}]}", "wiat", ".repeat.steps[0]",
     "unknown step 'wiat'", "did you mean 'wait'?"),
    ("measure: {channels: []}", "[]}", ".measure.channels",
     "got a list of 0, expected 1 or more", ""),
    ("measure: {channels: [tester.torque], name: my table}", "my table", ".measure.name",
     "'my table' is not a name: letters, digits and _", ""),
    ("measure: {channels: [tester.torque], cycles: 5}", "cycles: 5", ".measure.cycles",
     "unknown key 'cycles'", "known keys: label, when, channels, name, duration, limits"),
    ("call: other.yaml", "other.yaml", ".call",
     "got 'other.yaml', expected a mapping of names to values", ""),
    ("call: {file: other.yaml}", "call", ".call.procedure", "the key 'procedure' is missing", None),
    ("call: {procedure: other.yaml, with: [a]}", "[a]", ".call.with",
     "got a list of 1, expected a mapping of names to values", ""),
    ("call: {procedure: other.yaml, with: {my load: 5 N}}", "my load", ".call.with.my load",
     "'my load' is not a name", ""),
    ("ask: {text: Side, into: side, choices: [left]}", "{text: Side", ".ask",
     "'left' alone is not a choice", ""),
    ("ask: {text: Side, into: side, choices: [left, Left]}", "{text: Side", ".ask",
     "a choice is listed twice", ""),
    ("ask: {text: Side, into: side, choices: [left, 5]}", "5]", ".ask.choices[1]",
     "got 5, expected a text", "put it in quotes: '5'"),
    ("ask: {text: Side, into: side, choices: [left, right], unattended: up}", "{text: Side",
     ".ask", "the unattended answer: got 'up', expected one of: left, right", ""),
    ("ask: {text: Room, into: room, unit: °X}", "°X", ".ask.unit", "unknown unit '°X'", ""),
    ("ask: {text: Room, into: room, unit: °C, choices: [a, b]}", "{text: Room", ".ask",
     "got both, expected one of: choices, unit", ""),
    ("ask: {text: Room, into: room, min: 5 °C}", "{text: Room", ".ask",
     "the limit '5 °C' needs a unit: 'unit: °C'", ""),
    ("ask: {text: Room, into: room, unit: °C, min: 5 N}", "{text: Room", ".ask",
     "the limit '5 N' is a force, but the unit is °C", ""),
    ("ask: {text: Room, into: room, unit: °C, min: 30 °C, max: 20 °C}", "{text: Room", ".ask",
     "min (30 °C) must be below max (20 °C)", ""),
    ("ask: {text: Room, into: room, unit: °C, max: 30 °C, unattended: 31 °C}", "{text: Room",
     ".ask", "the unattended answer: 31 °C is out of range (30 °C or less)", ""),
    ("ask: {text: Room, into: room, unit: °C, unattended: 5 N}", "{text: Room", ".ask",
     "the unattended answer: '5 N' is a force, not a temperature", ""),
    ("confirm: {text: Ready, picture: 5}", "5}", ".confirm.picture", "got 5, expected a text",
     ""),
    ("confirm: {text: Ready, choices: [a, b]}", "choices: [a", ".confirm.choices",
     "unknown key 'choices'", "known keys: label, when, text, into, picture, unattended"),
    ("set: {tester.load: 5 N, timeout: 5}", "5}", ".set.timeout",
     "5 is not a number with a unit", "write it as '5 s'"),
    ("set: {tester.load: 5 N, retries: -1}", "-1", ".set.retries",
     "got -1, expected 0 or more", ""),
    ("set: {tester.load: 5 N, on_fail: continue}", "on_fail: continue", ".set.on_fail",
     "'on_fail' is not of the form role.name, such as tester.torque", None),
    ("set: {timeout: 5 s}", "{timeout", ".set",
     "got a mapping of nothing, expected 1 or more", ""),
    ("measure: {channels: [tester.load], retries: 101}", "101", ".measure.retries",
     "got 101, expected 100 or less", ""),
    ("measure: {channels: [tester.load], retries: twice}", "twice", ".measure.retries",
     "got 'twice', expected a whole number", ""),
    ("measure: {channels: [tester.load], on_fail: no}", "no}", ".measure.on_fail",
     "got 'no', expected 'stop' or 'continue'", ""),
    ("measure: {channels: [tester.load], on_fail: contniue}", "contniue", ".measure.on_fail",
     "expected 'stop' or 'continue'", "did you mean 'continue'?"),
    ("measure: {channels: [tester.load], limits: {load: {max: 5 N}}}", "load: {max",
     ".measure.limits.load", "'load' is not of the form role.name", ""),
    ("measure: {channels: [tester.load], limits: {tester.load: 5 N}}", "5 N}}",
     ".measure.limits.tester.load", "got '5 N', expected a mapping of names to values", ""),
    ("measure: {channels: [tester.load], limits: {tester.load: {}}}", "{}}}",
     ".measure.limits.tester.load", "a limit needs max, min, or both", ""),
    ("measure: {channels: [tester.load], limits: {tester.load: {min: 9 N, max: 5 N}}}", "{min",
     ".measure.limits.tester.load", "min (9 N) must be below max (5 N)", ""),
    ("measure: {channels: [tester.load], limits: {tester.load: {min: 5 N, max: 5 N}}}", "{min",
     ".measure.limits.tester.load", "min (5 N) must be below max (5 N)", ""),
    ("measure: {channels: [tester.load], limits: {tester.load: {min: 9 N, max: 5 Hz}}}", "{min",
     ".measure.limits.tester.load", "'9 N' is a force, but '5 Hz' is a frequency", ""),
    ("measure: {channels: [tester.load], limits: {tester.load: {min: 9 N, max: 5 rad}}}", "{min",
     ".measure.limits.tester.load", "'9 N' is a force, but '5 rad' is an angle", ""),
    ("measure: {channels: [tester.load], limits: {tester.load: {maxi: 5 N}}}", "maxi",
     ".measure.limits.tester.load.maxi", "unknown key 'maxi'",
     "did you mean 'max'? known keys: min, max, marginal"),
    ("measure: {channels: [tester.load], limits: {tester.load: {max: 9 N, marginal: 0 N}}}", "0 N}",
     ".measure.limits.tester.load.marginal", "got '0 N', expected more than 0", ""),
    ("measure: {channels: [a.b], limits: {a.b: {min: 1 N, max: 2 N, marginal: 0.5 N}}}", "{min",
     ".measure.limits.a.b", "marginal (0.5 N) leaves nothing between 1 N and 2 N", ""),
    ("measure: {channels: [room.t], limits: {room.t: {max: 26 °C, marginal: 1 °C}}}", "1 °C",
     ".measure.limits.room.t.marginal", "'1 °C' is a temperature, not a difference of two",
     "write it in K: '1 K'"),
    ("record: {channels: [tester.torque], cycles: 5, limit: {}}", "limit", ".record.limit",
     "unknown key 'limit'", "did you mean 'limits'?"),
    ("zero: {channel: tester.torque, within: 1 N·m, timeout: 0 s}", "0 s}", ".zero.timeout",
     "got '0 s', expected more than 0", ""),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: case[0][:50])
def test_a_spoiled_step(case):
    step, finger, field, message, hint = case
    text = edited(PROCEDURE, (MARK, step))
    before = text.index(step)
    problem, *others = problems_of(parse_procedure, text, "p.yaml")

    assert message in problem.message
    assert problem.field == AT + field
    assert (hint or "") in problem.hint
    assert not others or hint is None
    place = place_of(text, text[before + step.index(finger) :])
    assert str(problem.location) == f"p.yaml:{place}"


INPUTS = [
    ("choices: [DEMO, S-1, s-1]", "a choice is listed twice"),
    ("choices: [DEMO, TEST]", "the unattended answer: got 'S-1', expected one of: DEMO, TEST"),
    ("unit: kg", "the unattended answer: 'S-1' is not a number with a unit"),
]


@pytest.mark.parametrize(("more", "message"), INPUTS)
def test_a_spoiled_input(more, message):
    text = edited(PROCEDURE, ("unattended: S-1", f"unattended: S-1, {more}"))
    problem = only_problem(parse_procedure, text, "p.yaml")

    assert (problem.field, problem.message) == ("inputs.specimen", message)
    assert str(problem.location) == f"p.yaml:{place_of(text, '{ask')}"
