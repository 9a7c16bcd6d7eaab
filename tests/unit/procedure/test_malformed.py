"""Malformed procedures are refused with line, column, field, what was got, what is allowed."""

from __future__ import annotations

import pytest

from helpers_language import (
    PROCEDURE,
    TorqueSettings,
    edited,
    only_problem,
    place_of,
    problems_of,
)
from helpers_measurand import Hardness, LimitOfColour, analysis, kinds
from rigrunner.api.findings import ResultDefinition
from rigrunner.procedure import check_result_limits, parse_procedure

STEPS = (
    "expected one of: ask, call, confirm, group, measure, note, ramp, record, repeat, scan, set,"
    " settle, sweep, wait, zero"
)
KEYS = "known keys: "

# old part, new part, where the finger points, field, message, hint
LIMIT = "acceptance.limits[0]"
CASES = [
    ("procedure/2", "procedure/3", "procedure/3", "rigrunner",
     "got 'procedure/3', expected 'procedure/2'",
     "a newer version of the language needs a newer Rigrunner"),
    ("procedure/2", "procedure/1", "procedure/1", "rigrunner",
     "got 'procedure/1', an older form of the language, expected 'procedure/2'",
     "type 'rigrunner upgrade p.yaml'"),
    ("procedure/2", "station/1", "station/1", "rigrunner", "expected 'procedure/2'", ""),
    ("id: TEST-1\n", "", "rigrunner", "id", "the key 'id' is missing", ""),
    ("TEST-1", "../../etc", "../../etc", "id", "'../../etc' is not an id: letters, digits", ""),
    ("TEST-1", "1", "1\nrev", "id", "got 1, expected a text", "put it in quotes: '1'"),
    ('"A"', "1", "1\ntitle", "revision", "got 1, expected a text", "put it in quotes: '1'"),
    ('"A"', "", " \ntitle", "revision", "got nothing, expected a text", ""),
    ("title: A test", 'title: ""', '""', "title", "got '', expected a text of 1 or more", ""),
    ("title: A test", "title: A test\ntitel: B", "titel", "titel", "unknown key 'titel'",
     "did you mean 'title'?"),
    ("unit: N·m}", "unit: Nm2}", "Nm2", "measurand.unit", "unknown unit 'Nm2'",
     "did you mean 'N·m'"),
    ("symbol: Td, ", "", "measurand", "measurand.symbol", "the key 'symbol' is missing", ""),
    ("{symbol: Td, name: torque, unit: N·m}", "torque", "torque", "measurand",
     "got 'torque', expected a mapping of names to values", ""),
    ("  specimen:", "  my specimen:", "my specimen", "inputs.my specimen",
     "'my specimen' is not a name: letters, digits and _", ""),
    ("unattended: S-1", "unattended: 5", "5}", "inputs.specimen.unattended",
     "got 5, expected a text", "put it in quotes: '5'"),
    ("unattended: S-1", "unattended: 0001", "0001", "inputs.specimen.unattended",
     "0001 has a leading zero", "write 1 for the number, or '0001' in quotes for the text"),
    ("ask: Serial number, ", "", "specimen", "inputs.specimen.ask", "the key 'ask' is missing", ""),
    ("uses: {tester: swing_tester}", "uses: {}", "{}", "uses", "expected 1 or more", ""),
    ("uses: {tester: swing_tester}", "uses: swing_tester", "swing_tester", "uses",
     "got 'swing_tester', expected a mapping of names to values", ""),
    ("unattended: yes", "unattended: on", "on}", "setup[0].confirm.unattended",
     "got 'on', expected yes or no", ""),
    ("unattended: yes", "unattended: 1", "1}\n  - ask", "setup[0].confirm.unattended",
     "got '1', expected yes or no", ""),
    ("{text: Guards closed, unattended: yes}", "Guards closed", "Guards closed", "setup[0].confirm",
     "got 'Guards closed', expected a mapping of names to values", ""),
    ("into: remarks, ", "", "ask: {text", "setup[1].ask.into", "the key 'into' is missing", ""),
    ("into: remarks", "into: specimen", "specimen, una", "setup[1].ask.into",
     "the input 'specimen' is already asked at the start", "choose another name"),
    ("confirm:", "confrim:", "confrim", "setup[0]", f"unknown step 'confrim'; {STEPS}",
     "did you mean 'confirm'?"),
    ("- zero:", "- zzz: 1\n    zero:", "zzz", "setup[3]",
     f"a step has one key, got 'zzz' and 'zero'; {STEPS}", "begin each step with its own '-'"),
    ("setup:\n  - confirm", "setup:\n  - {}\n  - confirm", "{}", "setup[0]",
     f"a step has one key, got none; {STEPS}", ""),
    ("setup:\n  - confirm", "setup:\n  - settle\n  - confirm", "settle\n", "setup[0]",
     f"a step is a mapping with one key, such as 'settle: ...'; {STEPS}", ""),
    ("setup:\n  - confirm", "setup:\n  -\n  - confirm", "\n  - confirm", "setup[0]",
     f"a step is a mapping with one key, such as 'settle: ...'; {STEPS}", ""),
    ("tester.load: 0 N", "load: 0 N", "load: 0 N", "setup[2].set.load",
     "'load' is not of the form role.name, such as tester.torque", ""),
    ("tester.load: 0 N", "tester.load: 0", "0, tester", "setup[2].set.tester.load",
     "0 is not a number with a unit", "such as '10 Hz'"),
    ("tester.load: 0 N", "tester.load: 0,5 N", "5 N", "setup[2].set",
     "there is a decimal comma before '5 N'", "write a point: '0.5 N'"),
    ("tester.load: 0 N", "tester.load: [0 N]", "[0 N]", "setup[2].set.tester.load",
     "got a list, expected a number with a unit", ""),
    ("tester.load: 0 N", "tester.load: ~", "~", "setup[2].set.tester.load",
     "got nothing, expected a number with a unit", ""),
    ("tester.load: 0 N", "tester.load: 0 Newton", "0 Newton", "setup[2].set.tester.load",
     "unknown unit 'Newton'", ""),
    ("{tester.load: $load}", "{}", "{}", "main[0].set",
     "got a mapping of nothing, expected 1 or more", ""),
    ("channel: tester.torque, ", "", "zero", "setup[3].zero.channel",
     "the key 'channel' is missing", ""),
    ("within: 0.05 N·m", "within: 0,05 N·m", "05 N·m", "setup[3].zero",
     "there is a decimal comma before '05 N·m'", "write a point: '0.05 N·m'"),
    ("within: 0.05 N·m", 'within: "0,05 N·m"', '"0,05', "setup[3].zero.within",
     "'0,05 N·m' has a decimal comma", "write '0.05 N·m'"),
    ("within: 0.05 N·m", "within: 0.05 N·m, duration: 1 m", "1 m}", "setup[3].zero.duration",
     "'1 m' is a length, not a time", "units of time: s, ms, min, h, d"),
    ("within: 0.05 N·m", "within: 0.05 N·m, duration: 0 s", "0 s", "setup[3].zero.duration",
     "got '0 s', expected more than 0", ""),
    ("over: $frequencies", "over: []", "[]", "main[1].sweep.over",
     "got a list of 0, expected 1 or more", ""),
    ("over: $frequencies", "over: $load", "$load\n      steps", "main[1].sweep.over",
     "got '1000 N', expected a list", "it is written at p.yaml:10:9"),
    ("over: $frequencies", "over: [1 Hz,5 Hz, 5]", "5]", "main[1].sweep.over[2]",
     "5 is not a number with a unit", ""),
    ("set: tester.frequency\n", "set: [tester.frequency]\n", "[tester.f", "main[1].sweep.set",
     "got a list of 1, expected a text", ""),
    ("      over: $frequencies\n", "", "sweep", "main[1].sweep.over",
     "the key 'over' is missing", ""),
    ("{cycles: 5}", "{cylces: 5}", "cylces", "main[1].sweep.steps[0].settle.cylces",
     "unknown key 'cylces'", "did you mean 'cycles'? known keys: label, when, cycles, time"),
    ("{cycles: 5}", "{cycles: 5.5}", "5.5", "main[1].sweep.steps[0].settle.cycles",
     "got 5.5, expected a whole number", ""),
    ("{cycles: 5}", "{cycles: five}", "five", "main[1].sweep.steps[0].settle.cycles",
     "got 'five', expected a whole number", ""),
    ("{cycles: 5}", "{cycles: 0}", "0}", "main[1].sweep.steps[0].settle.cycles",
     "got 0, expected 1 or more", ""),
    ("{cycles: 5}", "{cycles: 05}", "05}", "main[1].sweep.steps[0].settle.cycles",
     "05 has a leading zero", "write 5 for the number"),
    ("{cycles: 5}", "{cycles: 10:30}", "10:30", "main[1].sweep.steps[0].settle.cycles",
     "got '10:30', expected a whole number", ""),
    ("{cycles: 5}", "{cycles: 1_000}", "1_000", "main[1].sweep.steps[0].settle.cycles",
     "got '1_000', expected a whole number", ""),
    ("{cycles: 5}", "{cycles: .inf}", ".inf", "main[1].sweep.steps[0].settle.cycles",
     ".inf is not a finite number", "write a finite number"),
    ("{cycles: 5}", "{cycles: 5, time: 1 s}", "{cycles: 5,", "main[1].sweep.steps[0].settle",
     "got both, expected one of: cycles, time", ""),
    ("{cycles: 5}", "{}", "{}", "main[1].sweep.steps[0].settle",
     "got neither, expected one of: cycles, time", ""),
    ("{cycles: 5}", "{time: 5}", "5}", "main[1].sweep.steps[0].settle.time",
     "5 is not a number with a unit", "write it as '5 s'"),
    ("{cycles: 5}", "{time: 10:30}", "10:30", "main[1].sweep.steps[0].settle.time",
     "'10:30' has more than one number", ""),
    ("{cycles: 5}", "{cycles: 5, cycles: 6}", "cycles: 6", "main[1].sweep.steps[0].settle",
     "the key 'cycles' is given twice; first at p.yaml:23:20", ""),
    (", cycles: 30}", "}", "{channels", "main[1].sweep.steps[1].record",
     "got neither, expected one of: cycles, duration", ""),
    ("[tester.angle, tester.torque]", "[]", "[]", "main[1].sweep.steps[1].record.channels",
     "got a list of 0, expected 1 or more", ""),
    ("[tester.angle, tester.torque]", "tester.torque", "tester.torque, cyc",
     "main[1].sweep.steps[1].record.channels", "got 'tester.torque', expected a list", ""),
    ("tester.angle,", "tester.,", "tester., ", "main[1].sweep.steps[1].record.channels[0]",
     "'tester.' is not of the form role.name", ""),
    ("      max: 0.95 N·m\n", "", "of: torque", f"{LIMIT}",
     "a limit needs max, min, or both", ""),
    ("max: 0.95 N·m", "max: 0.95 N·m\n      min: 1 N·m", "of: torque", f"{LIMIT}",
     "min (1 N·m) must be below max (0.95 N·m)", ""),
    ("max: 0.95 N·m", "max: 0.95", "0.95\n", f"{LIMIT}.max",
     "0.95 is not a number with a unit", "such as '10 Hz'"),
    ("      source: nobody\n", "", "of: torque", f"{LIMIT}.source",
     "the key 'source' is missing", ""),
    ("rule: guard_band_u", "rule: [guard_band_u]", "[guard_band_u]", "acceptance.rule",
     "a plugin is written as 'name', or as 'name: {setting: value}'", ""),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: (case[1] or case[0])[:30])
def test_malformed_procedure_is_refused(case):
    old, new, finger, field, message, hint = case
    text = edited(PROCEDURE, (old, new))
    problem = only_problem(parse_procedure, text, "p.yaml")

    assert message in problem.message
    assert problem.field == field
    assert hint in problem.hint
    assert str(problem.location) == f"p.yaml:{place_of(text, finger)}"


def test_a_wrong_section_is_both_unknown_and_missing():
    text = edited(PROCEDURE, ("main:\n", "mian:\n"))
    missing, unknown = problems_of(parse_procedure, text, "p.yaml")

    assert (missing.field, missing.message) == ("main", "the key 'main' is missing")
    assert (unknown.field, unknown.message) == ("mian", "unknown key 'mian'")
    assert "did you mean 'main'?" in unknown.hint


def test_all_problems_are_reported_together():
    text = edited(
        PROCEDURE,
        ("id: TEST-1\n", ""),
        ("0.05 N·m", "0.05"),
        ("cycles: 5", "cycels: 5"),
        ("guard_band_u", "[none]"),
    )

    fields = {problem.field for problem in problems_of(parse_procedure, text, "p.yaml")}
    assert fields >= {
        "id",
        "setup[3].zero.within",
        "main[1].sweep.steps[0].settle.cycels",
        "acceptance.rule",
    }


WRITTEN = "{nature: load_induced, condition: at_reversal}"
OF_HARDNESS = edited(PROCEDURE, (WRITTEN, "{scale: HRC}"))
KINDS = kinds(analysis("swing_torque", settings=TorqueSettings))
"""The analysis of the procedure reads another key."""


def parsed(text):
    return parse_procedure(text, "p.yaml", kinds=KINDS)


@pytest.mark.parametrize(
    ("written", "finger", "field", "message"),
    [
        ("{scale: HRA}", "HRA", ".scale", "got 'HRA', expected 'HRB' or 'HRC'"),
        ("{}", "measurand: {}", ".scale", "the key 'scale' is missing"),
        ("{scale: HRC, sclae: B}", "sclae", ".sclae", "unknown key 'sclae'"),
        ("{scale: HRC, load: 71}", "71}", ".load", "71 is not a number with a unit"),
        ("HRC", "HRC", "", "got 'HRC', expected a mapping of names to values"),
    ],
)
def test_malformed_measurand_is_refused(written, finger, field, message):
    text = edited(PROCEDURE, (WRITTEN, written))
    problem = only_problem(parsed, text)

    assert message in problem.message
    assert problem.field == f"{LIMIT}.measurand{field}"
    assert str(problem.location) == f"p.yaml:{place_of(text, finger)}"


HRC = Hardness("HRC")


class NamedResult:
    """The analysis of the procedure names a result, and which quantity it is."""

    def __init__(self, measurand=HRC):
        self.measurand = measurand

    def definitions(self, _name, _settings):
        definition = {"name": "torque", "unit": "N·m", "per": ("frequency",)}
        return (ResultDefinition(**definition, measurand=self.measurand),)


class NoResult:
    """No analysis names a result."""

    def definitions(self, _name, _settings):
        return ()


def test_limit_without_any_result_is_refused():
    problem = only_problem(check_result_limits, parse_procedure(PROCEDURE, "p.yaml"), NoResult())

    assert problem.field == "acceptance.limits[0].of"
    assert problem.message == "there is no result 'torque'"
    assert problem.hint == "results: none, as no analysis names one"


def test_limit_must_state_the_measurand_of_its_result():
    text = edited(OF_HARDNESS, ("      measurand: {scale: HRC}\n", ""))
    problem = only_problem(check_result_limits, parsed(text), NamedResult())

    assert problem.field == "acceptance.limits[0]"
    assert problem.message == "'torque' is the hardness HRC, and the key 'measurand' is missing"


def test_a_limit_of_another_quantity_is_refused():
    check_result_limits(parsed(OF_HARDNESS), NamedResult())
    problem = only_problem(check_result_limits, parsed(OF_HARDNESS), NamedResult(Hardness("HRB")))

    assert problem.field == "acceptance.limits[0].measurand"
    assert problem.message == "it is hardness HRB, not hardness HRC"
    assert problem.hint == "a limit applies only to results of the same measurand"


def test_limit_measurand_is_refused_if_the_result_has_none():
    problem = only_problem(check_result_limits, parsed(OF_HARDNESS), NamedResult(None))

    assert problem.field == "acceptance.limits[0].measurand"
    assert problem.message == "'torque' does not say whether it is the hardness HRC"
    assert problem.hint == "leave 'measurand' out"


def test_measurand_that_no_analysis_reads_is_refused():
    text = edited(OF_HARDNESS, ("{scale: HRC}", "{grade: 7}"))
    loaded = parse_procedure(text, "p.yaml", kinds=kinds())
    problem = only_problem(check_result_limits, loaded, NamedResult())

    assert problem.field == "acceptance.limits[0].measurand"
    assert problem.message == (
        "no analysis here can read the limit's measurand {grade: 7}, and the result is the "
        "hardness HRC"
    )


def test_measurand_is_read_by_the_requested_analysis():
    others = kinds(analysis("another", LimitOfColour), KINDS.analyses["swing_torque"])
    text = edited(PROCEDURE, (WRITTEN, "{scale: HRA}"))
    problem = only_problem(lambda: parse_procedure(text, "p.yaml", kinds=others))
    assert problem.field == f"{LIMIT}.measurand.scale"


@pytest.mark.parametrize(
    ("old", "new", "field", "message"),
    [
        ("of: torque", "of: torqe", "of", "there is no result 'torqe'"),
        ("0.95 N·m", "0.95 N", "max", "'0.95 N' is a force; torque is a torque, in N·m"),
        ("mean: yes", "each: speed", "each", "'torque' has no coordinate 'speed'"),
        ("mean: yes", "except: {sped: 1 Hz}\n      each: frequency", "except.sped",
         "'torque' has no coordinate 'sped'"),
        ("      mean: yes\n", "", "of", "there is a result 'torque' for each frequency"),
        ("mean: yes", "where: {frequency: [1 Hz, 2 Hz]}", "of",
         "there is a result 'torque' for each frequency"),
    ],
)  # fmt: skip
def test_limit_of_an_unknown_result_is_refused(old, new, field, message):
    text = edited(OF_HARDNESS, (old, new))
    problem = problems_of(check_result_limits, parsed(text), NamedResult())[0]

    assert (problem.field, problem.message) == (f"acceptance.limits[0].{field}", message)


def test_problem_within_a_nested_sweep_has_its_place():
    sweep = "sweep: {set: tester.load, over: [1 N], steps: [settle: {sweep: 1}]}"
    text = edited(PROCEDURE, ("settle: {cycles: 5}", sweep))
    problems = problems_of(parse_procedure, text, "p.yaml")

    assert problems[0].field == "main[1].sweep.steps[0].sweep.steps[0].settle.sweep"
    assert str(problems[0].location) == f"p.yaml:{place_of(text, 'sweep: 1}')}"
