"""Absurd times, frequencies and counts are refused with their place, written or computed."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, STATION, TESTER, edited, place_of, problems_of
from rigrunner.plan import make_plan
from rigrunner.procedure import parse_procedure
from rigrunner.station import parse_station

TIMES = ["1e300 s", "100000 d", "1e12 h"]
STEPS = [
    "wait: {{time: {}}}",
    "settle: {{time: {}}}",
    "record: {{channels: [tester.torque], duration: {}}}",
    "measure: {{channels: [tester.torque], duration: {}}}",
    "measure: {{channels: [tester.torque], timeout: {}}}",
    "zero: {{channel: tester.torque, within: 1 N·m, duration: {}}}",
    "ramp: {{drive: tester.load, to: 5 N, time: {}}}",
]
FIRST = "  - set: {tester.load: $load}\n"
PATIENCE = "safety: {{patience: {{{}: 1e300 s}}}}\ninstruments:"


def planned(text, station=STATION):
    loaded = parse_procedure(text, "p.yaml")
    bench = parse_station(station, "s.yaml")
    return make_plan(loaded, bench, {"tester": TESTER})


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("step", STEPS)
def test_absurd_time_in_any_step_is_refused(step, time):
    text = edited(PROCEDURE, (FIRST, f"{FIRST}  - {step.format(time)}\n"))
    (problem,) = problems_of(parse_procedure, text, "p.yaml")
    assert str(problem.location) == f"p.yaml:{place_of(text, time)}"
    assert problem.message == f"'{time}' is too large"
    assert problem.hint == "at most 3653 d"


@pytest.mark.parametrize("what", ["connect", "answer"])
def test_absurd_patience_of_a_station_is_refused(what):
    station = edited(STATION, ("instruments:", PATIENCE.format(what)))
    (problem,) = problems_of(parse_station, station, "s.yaml")
    assert "'1e300 s' is too large" in problem.message


@pytest.mark.parametrize("quantity", ["1e300 Hz", "1e30 kHz"])
def test_absurd_frequency_is_refused(quantity):
    text = edited(PROCEDURE, ("[2 Hz, 10 Hz]", f"[2 Hz, {quantity}]"))
    assert any("is too large" in problem.message for problem in problems_of(planned, text))


@pytest.mark.parametrize(("cycles", "step"), [("{cycles: 5}", "settle"), ("cycles: 30", "record")])
def test_cycles_that_take_years_are_refused(cycles, step):
    text = edited(PROCEDURE, ("[2 Hz, 10 Hz]", "[1e-300 Hz]"))
    assert cycles in text
    problems = [problem for problem in problems_of(planned, text) if problem.field.endswith(step)]
    assert "it would take" in problems[0].message
    assert "the limit is 3653 d" in problems[0].message


def test_repetitions_that_take_years_are_refused_once():
    step = "  - repeat: {times: 2000, steps: [{wait: {time: 2 d}}]}\n"
    (problem,) = problems_of(planned, edited(PROCEDURE, (FIRST, f"{FIRST}{step}")))
    assert "the procedure would take 3.46e+08 s; the limit is 3653 d" in problem.message
    assert problem.hint == "check its repetitions"


@pytest.mark.parametrize("count", ["1000000001", "100000000000000000000"])
def test_absurd_counts_are_refused(count):
    for old, new in (("{cycles: 5}", f"{{cycles: {count}}}"), ("cycles: 30", f"cycles: {count}")):
        (problem,) = problems_of(parse_procedure, edited(PROCEDURE, (old, new)), "p.yaml")
        assert "1000000" in problem.message
    times = f"  - repeat: {{times: {count}, steps: [{{wait: {{time: 1 s}}}}]}}\n"
    (problem,) = problems_of(
        parse_procedure, edited(PROCEDURE, (FIRST, f"{FIRST}{times}")), "p.yaml"
    )
    assert "100000" in problem.message
