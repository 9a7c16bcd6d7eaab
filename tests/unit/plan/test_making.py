"""From a procedure to explicit actions: order, values, times, names."""

from __future__ import annotations

import json
from dataclasses import fields

import pytest
from pydantic_core import to_json

from helpers_language import (
    LOGGER,
    PROCEDURE,
    STATION,
    TESTER,
    THERMOMETER,
    Streamer,
    edited,
)
from rigrunner.api.devices import DriveInfo
from rigrunner.plan import make_plan, making, plan_text
from rigrunner.plan.actions import Phase, Plan
from rigrunner.procedure import parse_procedure
from rigrunner.station import parse_station
from rigrunner.steps.ask import Ask
from rigrunner.steps.confirm import Confirm
from rigrunner.steps.measure import Measure
from rigrunner.steps.record import Record
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.settle import Settle
from rigrunner.steps.zero import Zero

DEVICES = {"tester": TESTER, "room": THERMOMETER, "logger": LOGGER}


def plan_of(*changes, station=STATION):
    procedure = parse_procedure(edited(PROCEDURE, *changes), "p.yaml")
    return make_plan(procedure, parse_station(station, "s.yaml"), DEVICES)


def test_every_action_in_order_with_its_values():
    actions = [step.action for step in plan_of().steps]
    setpoints = {"tester.load": 1000.0, "tester.frequency": 2.0}
    units = {
        "tester.load": "N",
        "tester.frequency": "Hz",
        "tester.angle": "rad",
        "tester.torque": "N·m",
    }

    assert actions[:7] == [
        Confirm("Guards closed", unattended=True),
        Ask("Remarks", "remarks", "none"),
        SetDrive("tester", "load", 0.0, "N"),
        SetDrive("tester", "frequency", 0.0, "Hz"),
        Zero("tester", "torque", "N·m", 0.05, 1.0),
        SetDrive("tester", "load", 1000.0, "N"),
        SetDrive("tester", "frequency", 2.0, "Hz"),
    ]
    assert actions[7] == Settle(2.5)
    assert actions[8] == Record(
        name="001_2Hz",
        role="tester",
        channels=("angle", "torque"),
        duration_s=15.5,
        setpoints=setpoints,
        units=units,
        cycle_frequency_hz=2.0,
        sample_rate_hz=1000.0,
    )
    assert actions[9:11] == [SetDrive("tester", "frequency", 10.0, "Hz"), Settle(0.5)]
    assert actions[11].name == "002_10Hz"
    assert actions[11].duration_s == pytest.approx(3.1)
    assert actions[12:] == [SetDrive("tester", "frequency", 0.0, "Hz")]


def test_phases_paths_and_texts():
    steps = plan_of().steps

    assert [step.phase for step in steps] == [Phase.SETUP] * 5 + [Phase.MAIN] * 7 + [Phase.TEARDOWN]
    assert [step.path for step in steps[4:9]] == [
        "setup[3].zero",
        "main[0].set.tester.load",
        "main[1].sweep[0].set",
        "main[1].sweep[0].steps[0].settle",
        "main[1].sweep[0].steps[1].record",
    ]
    assert len({step.path for step in steps}) == len(steps)
    assert [step.text for step in steps[4:9]] == [
        "Zero tester.torque, within 0.05 N·m",
        "Set tester.load to 1000 N",
        "Set tester.frequency to 2 Hz",
        "Settle for 5 cycles (2.5 s)",
        "Record angle, torque of tester, 30 cycles at 2 Hz (15.5 s)",
    ]


def test_times_count_cycles_and_the_rates_of_drives():
    plan = plan_of()
    load_s, zero_s = 1000 / 500, 1.0
    frequency_s = (2 + 8 + 10) / 10
    cycles_s = (5 + 31) / 2 + (5 + 31) / 10

    assert plan.estimated_s == pytest.approx(load_s + zero_s + frequency_s + cycles_s)


def test_rpm_and_times_serve_as_well():
    steps = plan_of(
        ("[2 Hz, 10 Hz]", "[120 rpm]"),
        ("settle: {cycles: 5}", "settle: {time: 3 s}"),
        ("cycles: 30", "duration: 0.5 min"),
    ).steps

    assert steps[6].action.value == pytest.approx(2.0)
    assert steps[6].text == "Set tester.frequency to 120 rpm"
    assert steps[7].action == Settle(3.0)
    assert (steps[8].action.name, steps[8].action.duration_s) == ("001_2Hz", 30.0)


def test_names_of_recordings_sort_in_order():
    values = ", ".join(f"{1 + index * 0.02:.2f} Hz" for index in range(1200))
    records = [
        step.action.name
        for step in plan_of(("[2 Hz, 10 Hz]", f"[{values}]")).steps
        if isinstance(step.action, Record)
    ]

    assert records[0] == "0001_1Hz"
    assert records[1] == "0002_1.02Hz"
    assert records == sorted(set(records))
    assert len(records) == 1200


def test_sweeps_nest():
    nested = (
        "sweep: {set: tester.load, over: [10 N, 20 N], steps:"
        " [record: {channels: [tester.angle, tester.torque], cycles: 4}]}"
    )
    steps = plan_of(("settle: {cycles: 5}", nested)).steps
    records = [step for step in steps if isinstance(step.action, Record)]

    assert [record.action.name for record in records] == [
        "001_2Hz", "002_2Hz", "003_2Hz", "004_10Hz", "005_10Hz", "006_10Hz",
    ]  # fmt: skip
    assert [record.action.setpoints["tester.load"] for record in records] == [10, 20, 20] * 2
    assert records[0].path == "main[1].sweep[0].steps[0].sweep[0].steps[0].record"


def test_a_recording_without_motion():
    start = PROCEDURE.index("main:")
    text = (
        edited(PROCEDURE[:start], ("  - set: {tester.load: 0 N, tester.frequency: 0 Hz}\n", ""))
        + "main: [record: {channels: [tester.torque], duration: 2 s}]\n"
    )
    station = parse_station(STATION, "s.yaml")
    (*_, step) = make_plan(parse_procedure(text, "p.yaml"), station, DEVICES).steps

    assert step.action.name == "001"
    assert (step.action.cycle_frequency_hz, step.action.setpoints) == (None, {})
    assert step.text == "Record torque of tester, for a time (2 s)"


def test_cycles_are_counted_by_the_recorded_device_s_own_drive():
    shaker = Streamer(
        LOGGER.channels, (DriveInfo("speed", "Hz", "", 0.0, 50.0, sets_cycle_frequency=True),)
    )
    procedure = edited(
        PROCEDURE,
        ("uses: {tester: swing_tester}", "uses: {shaker: shaker, tester: swing_tester}"),
        ("- set: {tester.load: $load}", "- set: {shaker.speed: 50 Hz, tester.load: $load}"),
        ("settle: {cycles: 5}", "settle: {time: 1 s}"),
    )
    station = edited(STATION, ("devices:\n", "devices:\n  shaker: {type: shaker, plugin: fake}\n"))
    plan = make_plan(
        parse_procedure(procedure, "p.yaml"),
        parse_station(station, "s.yaml"),
        {"tester": TESTER, "shaker": shaker},
    )
    records = [step.action for step in plan.steps if isinstance(step.action, Record)]

    assert [record.name for record in records] == ["001_2Hz", "002_10Hz"]
    assert records[0].duration_s == 15.5
    assert records[0].setpoints["shaker.speed"] == 50.0


def test_the_text_of_a_plan_is_json():
    plan = plan_of()
    steps = json.loads(b"".join(plan_text(plan)))

    assert len(steps) == len(plan.steps)
    assert (steps[8]["do"], steps[8]["action"]["name"]) == ("Record", "001_2Hz")
    assert (steps[8]["phase"], steps[8]["path"]) == ("main", plan.steps[8].path)


@pytest.mark.parametrize("piece", [1, 5, 13, 1000])
def test_the_text_of_a_plan_is_that_of_all_its_steps_at_once(monkeypatch, piece):
    """Resuming compares it with the stored one, which may have been written otherwise."""
    monkeypatch.setattr(making, "_PIECE", piece)
    steps = plan_of().steps
    listed = [
        {
            "do": type(step.action).__name__,
            "path": step.path,
            **{field.name: getattr(step, field.name) for field in fields(step)[1:]},
        }
        for step in steps
    ]
    assert len(steps) == 13
    assert b"".join(plan_text(Plan(steps))) == to_json(listed, indent=1)
    assert b"".join(plan_text(Plan(()))) == b"[]"


REPEATED = """\
  - repeat:
      times: 3
      steps:
        - measure: {channels: [tester.torque], duration: 1 s, limits: {tester.torque: {max: 3 N·m}}}
        - measure: {channels: [tester.torque], duration: 1 s, limits: {tester.torque: {max: 4 N·m}}}
        - set: {tester.load: 2 kN}
teardown:
"""


def test_what_a_repeated_step_has_each_time_is_held_once_and_what_changes_is_kept():
    steps = plan_of(("teardown:\n", REPEATED)).steps
    measured = [step for step in steps if isinstance(step.action, Measure)]
    first, second, third = measured[::2]
    assert first.terms is second.terms is third.terms
    assert [step.terms.limits[0].maximum for step in measured] == [3.0, 4.0] * 3
    assert first.action.units is second.action.units is third.action.units
    # The load is set in kN at the end of the first time.
    assert [step.written_in for step in (first, second)] == [{}, {"tester.load": "kN"}]
    assert second.written_in is third.written_in


SWEPT = """\
  - repeat:
      times: 2
      steps:
        - sweep:
            set: tester.load
            over: [1 kN, 2 kN]
            steps:
              - measure: {channels: [tester.torque], duration: 1 s}
teardown:
"""


def test_a_sweep_within_a_loop_has_what_it_sets_once_and_each_pass_its_place():
    all_steps = plan_of(("teardown:\n", SWEPT)).steps
    steps = [step for step in all_steps if ".repeat" in step.path]
    assert [step.path.partition(".")[2] for step in steps] == [
        f"repeat[{time}].steps[0].sweep[{value}].{what}"
        for time in range(2)
        for value in range(2)
        for what in ("set", "steps[0].measure")
    ]
    assert [step.points[-1] for step in steps[::2]] == [step.points[-1] for step in steps[1::2]]
    for first, second in zip(steps[:4:2], steps[4::2], strict=True):
        assert first.action is second.action
        assert first.text is second.text
    assert [step.action.value for step in steps[::2]] == [1000.0, 2000.0] * 2
    assert [step.action.setpoints["tester.load"] for step in steps[1::2]] == [1e3, 2e3] * 2
    assert len({id(step.text) for step in steps[1::2]}) == 1
