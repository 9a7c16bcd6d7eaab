"""What the station says of safety: about devices, drives and channels that are there."""

from __future__ import annotations

import pytest

from helpers_language import (
    PROCEDURE,
    STATION,
    TESTER,
    Streamer,
    edited,
    only_problem,
    place_of,
    problems_of,
)
from rigrunner.api.devices import ChannelInfo
from rigrunner.plan import make_plan
from rigrunner.procedure import parse_procedure
from rigrunner.station import parse_station

# what stands under `safety:`, where the finger points, field, message, hint
CASES = [
    ("order: [testre.load]", "testre", "safety.order[0]", "there is no device in the role 'testre'",
     "did you mean 'tester'?"),
    ("order: [tester.load, tester.laod]", "tester.laod", "safety.order[1]",
     "the device in the role 'tester' has no drive 'laod'", "did you mean 'load'?"),
    ("order: [oven]", "oven", "safety.order[0]", "there is no device in the role 'oven'",
     "roles: tester"),
]  # fmt: skip


def with_safety(safety: str) -> str:
    return edited(STATION, ("instruments:\n", f"safety: {{{safety}}}\ninstruments:\n"))


def planned(station: str, procedure: str = PROCEDURE):
    loaded = parse_station(station, "s.yaml")
    return make_plan(parse_procedure(procedure, "p.yaml"), loaded, {"tester": TESTER})


@pytest.mark.parametrize(("safety", "pointed", "field", "message", "hint"), CASES)
def test_what_does_not_fit_the_devices_is_told_with_its_place(
    safety, pointed, field, message, hint
):
    station = with_safety(safety)
    problem = only_problem(planned, station)
    assert str(problem.location) == f"s.yaml:{place_of(station, pointed)}"
    assert (problem.field, problem.message) == (field, message)
    assert hint in problem.hint


def test_drives_and_devices_may_be_ordered():
    assert planned(with_safety("order: [tester.frequency, tester]")).steps


def test_patience_is_a_positive_time():
    problem = only_problem(parse_station, with_safety("patience: {answer: 0 s}"), "s.yaml")
    assert problem.field == "safety.patience.answer"
    assert problem.message == "got '0 s', expected more than 0"


def test_a_place_in_the_order_is_a_role_or_a_drive():
    problem = only_problem(parse_station, with_safety("order: [all of it]"), "s.yaml")
    assert "'all of it' is neither a role nor role.drive" in problem.message


CORNERS = (
    "combinations: [{reason: the motor, allowed: ["
    "{tester.load: 500 N, tester.frequency: 35 Hz}, {tester.load: 1 kN, tester.frequency: 5 Hz}]}]"
)
LIMITS = [
    ("drives: {tester.load: {max: 900 N}}", "$load}", "main[0].set.tester.load",
     "1000 N is out of range (0 to 900 N)", ""),
    ("drives: {tester.load: {max: 9 kN}}", None, "", "", ""),  # the device's own limit stays
    ("drives: {tester.frequency: {min: 3 Hz, rate: 1 Hz/s}}", "0 Hz}\n  - zero",
     "setup[2].set.tester.frequency", "0 Hz is out of range (3 to 35 Hz)", ""),
    (CORNERS, "$frequencies", "main[1].sweep.over[1]",
     "got '10 Hz', not allowed with tester.load at 1000 N",
     ("expected tester.load up to 500 N with tester.frequency up to 35 Hz or"
      " tester.load up to 1 kN with tester.frequency up to 5 Hz")),
    (CORNERS.replace("500", "1000"), None, "", "", ""),
]  # fmt: skip


@pytest.mark.parametrize(("safety", "pointed", "field", "message", "hint"), LIMITS)
def test_the_stations_limits_hold_in_the_plan(safety, pointed, field, message, hint):
    station = with_safety(safety)
    if pointed is None:
        assert planned(station).steps
        return
    procedure = PROCEDURE
    if "min: 3 Hz" in safety:
        procedure = edited(procedure, ("[2 Hz, 10 Hz]", "[3 Hz, 10 Hz]"))
        procedure = edited(procedure, ("teardown:\n  - set: {tester.frequency: 0 Hz}\n", ""))
    problem = only_problem(planned, station, procedure)
    assert (problem.field, problem.message) == (field, message)
    assert hint in problem.hint
    assert problem.location.line == int(place_of(procedure, pointed).split(":")[0])


def test_a_drive_that_could_not_be_set_is_no_reason_against_another_one():
    """Where the load stands is not known: only its own mistake is a problem."""
    old, new = "main:\n  - set: {tester.load: $load}\n", "main:\n  - set: {tester.load: 5 Hz}\n"
    loaded = ("load: 0 N, tester.frequency: 0 Hz}", "load: 1 kN, tester.frequency: 0 Hz}")
    procedure = edited(PROCEDURE, (old, new), loaded)
    problem = only_problem(planned, with_safety(CORNERS), procedure)
    assert problem.field == "main[0].set.tester.load"


MISFITS = [
    ("drives: {tester.laod: {max: 1 N}}", "safety.drives.tester.laod",
     "the device in the role 'tester' has no drive 'laod'"),
    ("drives: {tester.load: {max: 5 Hz}}", "safety.drives.tester.load.max",
     "got '5 Hz', a frequency; tester.load takes a force"),
    ("drives: {tester.load: {rate: 5 N}}", "safety.drives.tester.load.rate",
     "got '5 N', a force; tester.load takes a force rate"),
    ("combinations: [{allowed: [{tester.load: 5 N, tester.frequency: 5 N}]}]",
     "safety.combinations[0].allowed[0].tester.frequency",
     "got '5 N', a force; tester.frequency takes a frequency"),
    ("interlocks: [{name: hot, channel: tester.heat, above: 5 N}]", "safety.interlocks[0].channel",
     "the device in the role 'tester' has no channel 'heat'"),
    ("interlocks: [{name: hot, channel: oven.heat, above: 5 N}]", "safety.interlocks[0].channel",
     "the station has no device in the role 'oven'"),
    ("interlocks: [{name: hot, channel: tester.load, above: 5 K}]", "safety.interlocks[0].above",
     "got '5 K', a temperature; tester.load takes a force"),
    ("interlocks: [{name: hot, channel: tester.load, outside: [5 N, 5 Hz]}]",
     "safety.interlocks[0].outside[1]", "got '5 Hz', a frequency; tester.load takes a force"),
    ("interlocks: [{name: hot, channel: tester.load, rate: 5 N}]", "safety.interlocks[0].rate",
     "got '5 N', a force; tester.load takes a force rate"),
    ("interlocks: [{name: hot, channel: tester.load, above: 5 N, forbids: [tester.x]}]",
     "safety.interlocks[0].forbids[0]", "the device in the role 'tester' has no drive 'x'"),
    (("interlocks: [{name: a, channel: tester.load, above: 5 N},"
      " {name: a, channel: tester.load, below: 1 N}]"), "safety.interlocks[1].name",
     "another interlock is called 'a'"),
]  # fmt: skip


@pytest.mark.parametrize(("safety", "field", "message"), MISFITS)
def test_limits_and_interlocks_that_fit_nothing_are_told(safety, field, message):
    problem = only_problem(planned, with_safety(safety))
    assert (problem.field, problem.message) == (field, message)


def test_all_limits_of_a_drive_that_do_not_fit_are_told_at_once():
    station = with_safety("drives: {tester.load: {min: 1 K, max: 5 Hz, rate: 5 N}}")
    problems = problems_of(planned, station)
    at = "safety.drives.tester.load"
    assert [problem.field for problem in problems] == [f"{at}.min", f"{at}.max", f"{at}.rate"]


REFUSED = [
    ("interlocks: [{name: hot, channel: tester.load}]", "safety.interlocks[0]",
     "got none, expected one of: above, below, outside, rate, stale"),
    ("interlocks: [{name: hot, channel: tester.load, above: 5 N, below: 1 N}]",
     "safety.interlocks[0]", "got above and below, expected one of"),
    ("interlocks: [{name: hot, channel: tester.load, outside: [5 N, 1 N]}]",
     "safety.interlocks[0]", "5 N must be below 1 N"),
    ("interlocks: [{name: hot, channel: tester.load, outside: [5 N, 5 N]}]",
     "safety.interlocks[0]", "5 N must be below 5 N"),
    ("interlocks: [{name: hot, channel: tester.load, above: 5 N, does: forbid}]",
     "safety.interlocks[0]", "'does: forbid' needs the drives that it forbids"),
    ("interlocks: [{name: hot, channel: tester.load, above: 5 K, hysteresis: 5 °C}]",
     "safety.interlocks[0].hysteresis", "'5 °C' is a temperature, not a difference of two"),
    ("interlocks: [{name: hot, channel: tester.load, rate: -5 N/s}]", "safety.interlocks[0]",
     "rate: got '-5 N/s', expected more than 0; it trips at a change up or down"),
    ("interlocks: [{name: hot, channel: tester.load, outside: [5 N, 9 N], hysteresis: 2 N}]",
     "safety.interlocks[0]", "got a hysteresis of 2 N, expected less than half of 5 N to 9 N"),
    ("interlocks: [{name: hot, channel: tester.load, stale: 5 s, hysteresis: 5 N}]",
     "safety.interlocks[0]", "hysteresis is a distance from above, below or outside"),
    ("combinations: [{allowed: [{tester.load: 5 N}]}]", "safety.combinations[0].allowed[0]",
     "expected 2 or more"),
    ("combinations: [{allowed: [{a.b: 5 N, a.c: 1 N}, {a.b: 5 N, a.d: 1 N}]}]",
     "safety.combinations[0]", "a corner is about a.b, a.d, the first one about a.b, a.c"),
    ("drives: {tester.load: {}}", "safety.drives.tester.load", "a limit needs min, max or rate"),
]  # fmt: skip


@pytest.mark.parametrize(("safety", "field", "message"), REFUSED)
def test_what_contradicts_itself_is_refused(safety, field, message):
    problem = only_problem(parse_station, with_safety(safety), "s.yaml")
    assert problem.field == field
    assert message in problem.message


def test_interlocks_come_from_station_and_procedure_in_si_units():
    station = with_safety(
        "interlocks: [{name: hot, channel: tester.load, above: 2 kN, debounce: 50 ms}]"
    )
    cold = "interlocks:\n  - {name: cold, channel: tester.torque, below: -5 N·m, does: pause}\n"
    procedure = edited(PROCEDURE, ("setup:\n", f"{cold}setup:\n"))
    hot, cold = planned(station, procedure).interlocks
    assert (hot.maximum, hot.debounce_s, hot.does) == (2000.0, 0.05, "abort")
    assert hot.condition == "above 2 kN"
    assert (cold.member, cold.minimum, cold.does) == ("tester.torque", -5.0, "pause")
    # what it does not say: at once, looked at ten times a second, until it has cleared
    assert (cold.debounce_s, cold.every_s, cold.hysteresis) == (0.0, 0.1, 0.0)
    assert (cold.latched, cold.overridable) == (False, False)


def test_points_and_what_cannot_be_repeated_are_in_the_plan():
    procedure = edited(PROCEDURE, ("cycles: 30}", "cycles: 30, repeatable: no}"))
    records = [step for step in planned(STATION, procedure).steps if "record" in step.path]
    assert [record.terms.repeatable for record in records] == [False, False]
    assert [record.points for record in records] == [
        ("main[1].sweep[0]",), ("main[1].sweep[1]",),
    ]  # fmt: skip


def test_a_step_that_is_tried_again_must_be_repeatable():
    text = edited(PROCEDURE, ("cycles: 30}", "cycles: 30, repeatable: no, retries: 1}"))
    problem = only_problem(parse_procedure, text, "p.yaml")
    assert problem.field == "main[1].sweep.steps[1].record.retries"
    assert problem.message == "the step has retries, but is not repeatable"


def test_a_hysteresis_of_a_power_level_is_a_level():
    meter = Streamer((ChannelInfo("power", "dBm", "power"),), ())
    rule = "interlocks: [{name: x, channel: meter.power, above: 3 dBm, hysteresis: 1 dB}]"
    loaded = parse_station(with_safety(rule), "s.yaml")
    procedure = parse_procedure(PROCEDURE, "p.yaml")
    (interlock,) = make_plan(procedure, loaded, {"tester": TESTER, "meter": meter}).interlocks
    assert (interlock.maximum, interlock.hysteresis) == (3.0, 1.0)


def test_an_interlock_outside_of_two_values_may_have_a_hysteresis():
    rule = "interlocks: [{name: room, channel: tester.load, outside: [5 N, 9 N], hysteresis: 1 N}]"
    (interlock,) = planned(with_safety(rule)).interlocks
    assert (interlock.minimum, interlock.maximum, interlock.hysteresis) == (5.0, 9.0, 1.0)


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        ("above: 60 N", "above 60 N"),
        ("below: 0 N", "below 0 N"),
        ("above: 0 N", "above 0 N"),
        ("outside: [5 N, 9 N]", "outside 5 N to 9 N"),
        ("rate: 2 N/s", "faster than 2 N/s"),
        ("stale: 500 ms", "not read for 0.5 s"),
        ("above: 60 N, hysteresis: 1 N", "above 60 N"),
    ],
)
def test_an_interlock_says_what_trips_it(rule, words):
    station = with_safety(f"interlocks: [{{name: hot, channel: tester.load, {rule}}}]")
    assert [interlock.condition for interlock in planned(station).interlocks] == [words]
