"""The plan of each kind of step: its action, its time, its terms; and refused steps."""

from __future__ import annotations

import re

import pytest

from helpers_language import (
    LOGGER,
    PROCEDURE,
    STATION,
    TESTER,
    THERMOMETER,
    Reader,
    edited,
    only_problem,
    place_of,
    problems_of,
)
from rigrunner.api.devices import ChannelInfo, DriveInfo
from rigrunner.api.limits import ValueLimit
from rigrunner.api.quantity import parse_quantity
from rigrunner.plan import make_plan
from rigrunner.plan.actions import Phase, Terms
from rigrunner.procedure import load_procedure, parse_procedure
from rigrunner.procedure.answers import Expected
from rigrunner.station import parse_station
from rigrunner.steps.ask import Ask
from rigrunner.steps.confirm import Confirm
from rigrunner.steps.measure import Measure
from rigrunner.steps.note import Note
from rigrunner.steps.ramp import Ramp
from rigrunner.steps.record import Record
from rigrunner.steps.scan import Scan
from rigrunner.steps.set_drives import SetDrive, SetStep
from rigrunner.steps.settle import Settle
from rigrunner.steps.wait import Wait

MARK = "settle: {cycles: 5}"
AT = "main[1].sweep.steps[0]"
ROOM = Reader(THERMOMETER.channels, ())
DEVICES = {"tester": TESTER, "room": ROOM, "logger": LOGGER}
ROLES = (
    "uses: {tester: swing_tester}",
    "uses: {tester: swing_tester, room: thermometer, logger: l}",
)
BENCH = edited(
    STATION,
    (
        "instruments:\n",
        """\
  room: {type: thermometer, plugin: fake}
  logger: {type: l, plugin: fake}
instruments:
""",
    ),
)


def planned(step, devices=DEVICES):
    text = edited(PROCEDURE, (MARK, step), ROLES)
    plan = make_plan(parse_procedure(text, "p.yaml"), parse_station(BENCH, "s.yaml"), devices)
    return [step for step in plan.steps if step.path.startswith("main[1].sweep[0].steps[0]")]


def only_step(step, devices=DEVICES):
    (planned_step,) = planned(step, devices)
    return planned_step


def test_ramp_at_a_rate_takes_the_time_of_its_distance():
    step = only_step("ramp: {drive: tester.load, from: 100 N, to: 0.6 kN, rate: 100 N/s}")

    assert step.action == Ramp("tester", "load", 100.0, 600.0, "N", pytest.approx(5.0))
    way_to_start_s = (1000 - 100) / 500
    assert step.estimated_s == pytest.approx(way_to_start_s + 5.0)
    assert step.text == "Ramp tester.load to 0.6 kN in 5 s"


def test_ramp_over_a_time_starts_at_the_current_set_point():
    step = only_step("ramp: {drive: tester.load, to: 0 N, time: 1 min}")

    assert step.action == Ramp("tester", "load", 1000.0, 0.0, "N", 60.0)
    assert step.estimated_s == 60.0


def test_ramp_changes_the_set_point_of_later_steps():
    steps = make_plan(
        parse_procedure(
            edited(PROCEDURE, (MARK, "ramp: {drive: tester.load, to: 7 N, time: 9 s}")), "p.yaml"
        ),
        parse_station(STATION, "s.yaml"),
        {"tester": TESTER},
    ).steps
    (record, _) = [step.action for step in steps if isinstance(step.action, Record)]

    assert record.setpoints["tester.load"] == 7.0


def test_wait_and_note():
    assert only_step("wait: {time: 2 min, text: warm up}").action == Wait(120.0)
    assert only_step("wait: {time: 2 min, text: warm up}").text == "Wait for 120 s: warm up"
    assert only_step("note: {text: Grease seen}").action == Note("Grease seen")


def test_a_question_with_choices_and_one_with_a_unit():
    side = only_step(
        "ask: {text: Side, into: side, choices: [left, right], unattended: LEFT}"
    ).action
    assert side == Ask("Side", "side", "LEFT", expected=Expected(("left", "right")))
    room = only_step("ask: {text: Room, into: room, unit: degC, min: 15 °C}").action
    assert room.expected == Expected(unit="°C", minimum=parse_quantity("15 °C"))


def test_single_values_of_several_devices():
    step = only_step("measure: {channels: [room.room, tester2.x]}".replace(", tester2.x", ""))
    assert step.action == Measure(
        name="measured",
        channels=("room.room",),
        duration_s=0.0,
        setpoints={"tester.load": 1000.0, "tester.frequency": 2.0},
        units={"tester.load": "N", "tester.frequency": "Hz", "room.room": "K"},
    )
    assert step.text == "Measure room.room, once"


def test_an_average_is_streamed_where_the_device_streams():
    streamed = only_step("measure: {channels: [tester.torque], name: mean, duration: 2 s}")
    assert (streamed.action.name, streamed.action.sample_rate_hz) == ("mean", 1000.0)
    assert streamed.estimated_s == 2.0
    read = only_step("measure: {channels: [room.room], duration: 2 s}")
    assert read.action.sample_rate_hz is None
    assert read.text == "Measure room.room, mean over 2 s"


SCAN = "scan: {set: tester.load, over: [0.1 kN, 50 N, 300 N], channels: [room.room], name: warm}"


def scan_with(more):
    return SCAN.replace("name: warm", more)


def test_plan_of_a_scan():
    step = only_step(SCAN)
    assert step.action == Scan(
        name="warm",
        role="tester",
        drive="load",
        values=(100.0, 50.0, 300.0),
        channels=("room.room",),
        settle_s=0.0,
        setpoints={"tester.frequency": 2.0},
        units={"tester.load": "N", "tester.frequency": "Hz", "room.room": "K"},
    )
    way_n, n_per_s = (1000 - 100) + (100 - 50) + (300 - 50), 500
    assert step.estimated_s == pytest.approx(way_n / n_per_s)
    assert step.path == "main[1].sweep[0].steps[0].scan"
    assert step.text == "Scan tester.load between 50 N and 300 N, 3 points, reading room.room"
    assert step.terms == Terms()
    assert only_step(scan_with("name: a").replace("0.1 kN, 50 N, ", "")).text == (
        "Scan tester.load at 300 N, 1 point, reading room.room"
    )


def test_scan_settles_and_has_limits_at_each_point():
    limits = "{room.room: {min: 20 °C, max: 26 °C, marginal: 0.5 K}}"
    step = only_step(scan_with(f"settle: 2 s, retries: 1, timeout: 9 s, limits: {limits}"))
    low, high = parse_quantity("20 °C"), parse_quantity("26 °C")
    assert (step.action.settle_s, step.estimated_s) == (2.0, pytest.approx(2.4 + 3 * 2.0))
    assert step.action.limits == (ValueLimit.between("room.room", low, high, 0.5),)
    assert step.terms == Terms(9.0, 2)  # the limits are those of each point


def test_steps_after_a_scan_have_its_last_set_point():
    text = edited(PROCEDURE, (MARK, SCAN), ROLES)
    plan = make_plan(parse_procedure(text, "p.yaml"), parse_station(BENCH, "s.yaml"), DEVICES)
    scan, record = [s.action for s in plan.steps if s.path.startswith("main[1].sweep[1].steps")]
    assert record.setpoints == {"tester.load": 300.0, "tester.frequency": 10.0}
    assert scan.setpoints == {"tester.frequency": 10.0}
    (second,) = [s for s in plan.steps if s.path == "main[1].sweep[1].steps[0].scan"]
    assert second.estimated_s == pytest.approx((300 - 100 + 100 - 50 + 300 - 50) / 500)


def test_scan_of_a_frequency_counts_as_motion():
    scan = "scan: {set: tester.frequency, over: [3 Hz, 4 Hz], channels: [room.room]}"
    text = edited(PROCEDURE, (MARK, scan), ROLES)
    plan = make_plan(parse_procedure(text, "p.yaml"), parse_station(BENCH, "s.yaml"), DEVICES)
    records = [s.action for s in plan.steps if isinstance(s.action, Record)]
    assert [record.cycle_frequency_hz for record in records] == [4.0, 4.0]
    turning = edited(
        PROCEDURE, (MARK, scan), ROLES,
        ("record: {channels: [tester.angle, tester.torque], cycles: 30}",
         "zero: {channel: tester.torque, within: 1 N·m}"),
        (PROCEDURE[PROCEDURE.index("analysis:") :], ""),
    )  # fmt: skip
    problem = only_problem(
        make_plan, parse_procedure(turning, "p.yaml"), parse_station(BENCH, "s.yaml"), DEVICES
    )
    assert problem.message == "zero is read at rest, but tester.frequency is at 4 Hz here"


def test_repeat_expands_to_its_number_of_times():
    steps = planned("repeat: {times: 3, steps: [wait: {time: 1 s}, settle: {time: 2 s}]}")

    assert [step.action for step in steps] == [Wait(1.0), Settle(2.0)] * 3
    assert [step.path for step in steps][::2] == [
        f"main[1].sweep[0].steps[0].repeat[{n}].steps[0].wait" for n in range(3)
    ]


def test_samples_of_every_third_recording_are_kept():
    record = (
        "record: {channels: [tester.angle, tester.torque], cycles: 5, keep_every: 3,"
        " statistics: {tester.torque: [mean]}}"
    )
    steps = planned(f"repeat: {{times: 7, steps: [{record}]}}")
    assert [step.action.kept for step in steps] == [True, False, False] * 2 + [True]


def test_keys_of_a_set_step_are_its_drives():
    schema = SetStep.model_json_schema()
    assert set(schema["properties"]).isdisjoint({"drives"})
    (pattern,) = schema["patternProperties"]
    assert re.fullmatch(pattern, "tester.load")
    assert schema["minProperties"] == 1


def test_the_terms_of_a_step():
    limits = "{room.room: {min: 20 °C, max: 26 °C, marginal: 0.5 K}}"
    step = only_step(
        f"measure: {{channels: [room.room], limits: {limits}, timeout: 3 s, retries: 2,"
        " on_fail: continue}"
    )
    low, high = parse_quantity("20 °C"), parse_quantity("26 °C")

    limit = ValueLimit("room.room", low.si, high.si, "°C", 0.5)
    expected = Terms(3.0, 3, continues=True, limits=(limit,), stops_at_limit=False)
    assert step.terms == expected
    assert only_step("set: {tester.load: 1 N, retries: 1}").terms == Terms(None, 2)
    assert only_step("set: {tester.load: 1 N}").terms == Terms()


def test_recording_may_limit_other_channels():
    record = "record: {channels: [tester.angle, tester.torque], cycles: 5, limits: LIMITS}"
    step = only_step(record.replace("LIMITS", "{room.room: {max: 26 °C}}"))
    assert step.terms.limits == (ValueLimit.between("room.room", None, parse_quantity("26 °C")),)


def test_limit_of_a_streamed_channel_applies_to_its_maximum():
    class StreamingReader(type(TESTER), Reader):
        """Streams and is read."""

    devices = DEVICES | {"tester": StreamingReader(TESTER.channels, TESTER.drives)}
    record = "record: {channels: [tester.angle, tester.torque], cycles: 5, limits: LIMITS}"
    step = only_step(record.replace("LIMITS", "{tester.load: {max: 5 N}}"), devices)
    assert step.terms.limits == (ValueLimit("tester.load", None, 5.0, "N"),)

    streamed = only_step(record.replace("LIMITS", "{tester.torque: {max: 5 N·m}}"), devices)
    assert streamed.terms.limits == (ValueLimit("tester.torque.maximum", None, 5.0, "N·m"),)
    assert streamed.action.statistics == ("tester.torque.maximum",)


# step, where the finger points, field below the step, message, hint
CASES = [
    ("ramp: {drive: tester.load, to: 5 kN, time: 9 s}", "5 kN", "ramp.to",
     "5 kN is out of range (0 to 3 kN)", "these are the limits of tester.load"),
    ("ramp: {drive: tester.load, from: 5 Hz, to: 5 N, time: 9 s}", "5 Hz", "ramp.from",
     "got '5 Hz', a frequency; tester.load takes a force", "write it in N"),
    ("ramp: {drive: tester.laod, to: 5 N, time: 9 s}", "tester.laod", "ramp.drive",
     "the device in the role 'tester' has no drive 'laod'", "did you mean 'load'?"),
    ("ramp: {drive: tester.load, to: 5 N, rate: 5 Hz/s}", "5 Hz/s", "ramp.rate",
     "got '5 Hz/s', a frequency rate; tester.load takes a force rate", "write it in N/s"),
    ("ramp: {drive: tester.load, to: 5 N, rate: 0 N/s}", "0 N/s", "ramp.rate",
     "got '0 N/s', expected more than 0", ""),
    ("ramp: {drive: tester.load, to: 0 N, rate: 900 N/s}", "900", "ramp.rate",
     "tester.load moves by 500 N in a second at most", "it needs 2 s for this ramp"),
    ("ramp: {drive: tester.load, to: 0 N, time: 1 s}", "1 s}", "ramp.time",
     "tester.load moves by 500 N in a second at most", "it needs 2 s for this ramp"),
    ("measure: {channels: [tester.torque]}", "{channels: [tester.torque]}", "measure",
     "the device in the role 'tester' gives no single values", "give a duration to average"),
    ("measure: {channels: [tester.torqe], duration: 1 s}", "tester.torqe", "measure.channels[0]",
     "the device in the role 'tester' has no channel 'torqe'", "did you mean 'torque'?"),
    ("measure: {channels: [room.room, room.room]}", "[room.room, r", "measure.channels",
     "a channel is listed twice", "name it once"),
    ("measure: {channels: [tester.torque, logger.torque], duration: 1 s}", "[tester.torque, l",
     "measure.channels", "channels of two devices in one average: logger, tester",
     "a measure step for each device, or no duration"),
    ("measure: {channels: [room.room], limits: {room.rom: {max: 5 K}}}", "room.rom: {",
     "measure.limits.room.rom", "the device in the role 'room' has no channel 'rom'",
     "did you mean 'room'?"),
    ("measure: {channels: [room.room], limits: {tester.load: {max: 5 N}}}", "tester.load: {max",
     "measure.limits.tester.load", "the step finds no value of tester.load",
     "it finds: room.room"),
    ("measure: {channels: [room.room], limits: {room.room: {max: 5 N}}}", "5 N}}",
     "measure.limits.room.room.max", "got '5 N', a force; room.room takes a temperature",
     "write it in K"),
    ("measure: {channels: [room.room], duration: 5 s, timeout: 2 s}", "2 s}", "measure.timeout",
     "got 2 s, but the step takes 5 s", ""),
    ("set: {tester.load: 0 N, timeout: 1 s}", "1 s}", "set.timeout",
     "got 1 s, but the step takes 2 s", ""),
    (SCAN.replace("tester.load", "tester.laod"), "tester.laod", "scan.set",
     "the device in the role 'tester' has no drive 'laod'", "did you mean 'load'?"),
    (SCAN.replace("tester.load", "teser.load"), "teser.load", "scan.set",
     "'teser.load': the procedure uses no role 'teser'", "did you mean 'tester'?"),
    (SCAN.replace("50 N", "50 Hz"), "50 Hz", "scan.over[1]",
     "got '50 Hz', a frequency; tester.load takes a force", "write it in N"),
    (SCAN.replace("300 N", "3.1 kN"), "3.1 kN", "scan.over[2]",
     "3.1 kN is out of range (0 to 3 kN)", "these are the limits of tester.load"),
    (SCAN.replace("[room.room]", "[room.rom]"), "room.rom", "scan.channels[0]",
     "the device in the role 'room' has no channel 'rom'", "did you mean 'room'?"),
    (SCAN.replace("[room.room]", "[room.room, room.room]"), "[room.room, r", "scan.channels",
     "a channel is listed twice", "name it once"),
    (SCAN.replace("room.room", "tester.torque"), "{set: tester.load", "scan",
     "the device in the role 'tester' gives no single values", ""),
    (scan_with("limits: {tester.torque: {max: 5 N·m}}"), "tester.torque: {max",
     "scan.limits.tester.torque", "the step finds no value of tester.torque",
     "it finds: room.room"),
    (scan_with("limits: {room.room: {max: 5 N}}"), "5 N}}", "scan.limits.room.room.max",
     "got '5 N', a force; room.room takes a temperature", "write it in K"),
    (scan_with("settle: 2 s, timeout: 8 s"), "8 s}", "scan.timeout",
     "got 8 s, but the step takes 8.4 s", ""),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: case[0][:50])
def test_invalid_step_is_refused(case):
    step, finger, field, message, hint = case
    text = edited(PROCEDURE, (MARK, step), ROLES)
    problem = only_problem(planned, step)

    assert problem.message == message
    assert problem.field == f"{AT}.{field}"
    assert hint in problem.hint
    within = text[text.index(step) :]
    assert str(problem.location) == f"p.yaml:{place_of(text, within[within.index(finger) :])}"


def test_all_problems_of_a_scan_are_reported_together():
    scan = scan_with("limits: {room.room: {max: 5 N}}").replace("50 N, 300 N", "5 kN, 2 K, 3 Hz")
    problems = problems_of(planned, scan)
    assert [problem.field for problem in problems] == [
        f"{AT}.scan.{field}" for field in ("over[1]", "over[2]", "over[3]", "limits.room.room.max")
    ]


def test_scan_point_outside_allowed_combinations_is_refused():
    rule = """\
safety:
  combinations:
    - reason: power of the motor
      allowed:
        - {tester.load: 200 N, tester.frequency: 35 Hz}
        - {tester.load: 250 N, tester.frequency: 2 Hz}
devices:
"""
    scan = SCAN.replace("50 N, 300 N", "300 N, 50 N")
    at_rest = ("main:\n  - set: {tester.load: $load}", "main:\n  - set: {tester.load: 0 N}")
    procedure = parse_procedure(edited(PROCEDURE, (MARK, scan), ROLES, at_rest), "p.yaml")
    station = parse_station(edited(BENCH, ("devices:\n", rule)), "s.yaml")
    problems = problems_of(make_plan, procedure, station, DEVICES)
    assert [problem.message for problem in problems] == [
        f"got '300 N', not allowed with tester.frequency at {hz} Hz" for hz in (2, 10)
    ]
    assert {problem.field for problem in problems} == {f"{AT}.scan.over[1]"}


def test_too_many_scans_are_refused_before_expansion():
    times = f"repeat: {{times: 20000, steps: [{SCAN}]}}"
    problem = only_problem(planned, times)
    actions = 5 + 1 + 2 * (20_000 * 3 + 1 + 1) + 1
    assert problem.message == f"the procedure has {actions:,} actions, more than 100,000"


def test_rate_of_another_quantity_is_refused():
    valve = Reader((ChannelInfo("u", "V", ""),), (DriveInfo("u", "V", "", 0.0, 10.0),))
    step = "ramp: {drive: room.u, to: 5 V, rate: 5 N/s}"
    problem = only_problem(planned, step, DEVICES | {"room": valve})

    assert (problem.message, problem.hint) == (
        "got '5 N/s', a force rate; room.u takes a voltage rate",
        "write it in V/s",
    )


def test_rate_of_a_power_level_is_refused():
    generator = Reader((ChannelInfo("p", "dBm", ""),), (DriveInfo("p", "dBm", "", -60.0, 10.0),))
    step = "ramp: {drive: room.p, to: 5 dBm, rate: 5 N/s}"
    problem = only_problem(planned, step, DEVICES | {"room": generator})

    assert (problem.message, problem.hint) == (
        "there is no unit for the rate of a power level",
        "give a time",
    )


INNER = """\
rigrunner: procedure/2
id: INNER
revision: "A"
title: Inner
measurand: {symbol: T, name: torque}
uses: {tester: swing_tester}
parameters: {load: 10 N}
setup: [confirm: {text: Ready, picture: ready.png}]
main:
  - set: {tester.load: $load}
  - record: {channels: [tester.angle, tester.torque], cycles: 4}
teardown: [set: {tester.load: 1 N}]
"""


def called(tmp_path, changes=(), inner=INNER):
    (tmp_path / "inner.yaml").write_text(inner, encoding="utf-8")
    (tmp_path / "ready.png").write_bytes(b"\x89PNG")
    (tmp_path / "p.yaml").write_text(edited(PROCEDURE, *changes), encoding="utf-8")
    procedure = load_procedure(tmp_path / "p.yaml")
    return make_plan(procedure, parse_station(STATION, "s.yaml"), {"tester": TESTER}).steps


def test_called_procedure_is_expanded_in_place(tmp_path):
    call = (MARK, "call: {procedure: inner.yaml, with: {load: 20 N}}")
    steps = [step for step in called(tmp_path, [call]) if step.calls]
    first, second = "main[1].sweep[0].steps[0].call", "main[1].sweep[1].steps[0].call"

    assert [step.calls for step in steps] == [(first,)] * 4 + [(second,)] * 4
    assert [step.path for step in steps[:4]] == [
        f"{first}.setup[0].confirm",
        f"{first}.main[0].set.tester.load",
        f"{first}.main[1].record",
        f"{first}.teardown[0].set.tester.load",
    ]
    assert [step.phase for step in steps[:4]] == [Phase.MAIN] * 3 + [Phase.TEARDOWN]
    assert steps[0].action == Confirm("Ready", None, str(tmp_path / "ready.png"))
    assert steps[1].action == SetDrive("tester", "load", 20.0, "N")
    assert steps[2].action.name == "001_2Hz"
    assert steps[2].action.setpoints == {"tester.load": 20.0, "tester.frequency": 2.0}


def test_steps_after_a_call_have_its_set_points(tmp_path):
    steps = called(tmp_path, [(MARK, "call: {procedure: inner.yaml}")])
    (recorded, _) = [s.action for s in steps if isinstance(s.action, Record) and not s.calls]

    assert recorded.name == "002_2Hz"
    assert recorded.setpoints["tester.load"] == 1.0


def test_call_in_a_teardown_is_all_teardown(tmp_path):
    change = ("teardown:\n", "teardown:\n  - call: {procedure: inner.yaml}\n")
    steps = called(tmp_path, [change, ("tester.frequency: 0 Hz}\nan", "tester.load: 0 N}\nan")])
    inside = [step for step in steps if step.path.startswith("teardown[0].call")]

    assert len(inside) == 4
    assert {(step.phase, step.calls) for step in inside} == {(Phase.TEARDOWN, ())}


def test_problem_within_a_call_has_its_own_file(tmp_path):
    inner = edited(INNER, ("tester.angle", "tester.angel"))
    call = (MARK, "call: {procedure: inner.yaml}")
    problem = only_problem(called, tmp_path, [call], inner)

    assert str(problem.location) == f"{tmp_path / 'inner.yaml'}:{place_of(inner, 'tester.angel')}"
    assert problem.field == "main[1].record.channels[0]"


def test_too_many_calls_are_refused_before_expansion(tmp_path):
    times = "repeat: {times: 20000, steps: [call: {procedure: inner.yaml}]}"
    problem = only_problem(called, tmp_path, [(MARK, times)])

    each_time, others = 4, 1 + 1
    actions = 5 + 1 + 2 * (20_000 * each_time + others) + 1
    assert problem.message == f"the procedure has {actions:,} actions, more than 100,000"
