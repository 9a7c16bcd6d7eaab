"""Problems that keep a procedure from running on a station: reported together, with places."""

from __future__ import annotations

import pytest

from helpers_language import (
    LOGGER,
    PROCEDURE,
    STATION,
    TESTER,
    THERMOMETER,
    Streamer,
    edited,
    only_problem,
    place_of,
    problems_of,
)
from rigrunner.api.devices import ChannelInfo, DriveInfo
from rigrunner.plan import make_plan
from rigrunner.procedure import parse_procedure
from rigrunner.station import parse_station

DEVICES = {"tester": TESTER, "room": THERMOMETER, "logger": LOGGER}
ROLES = "uses: {tester: swing_tester}"
MORE_ROLES = "uses: {tester: swing_tester, room: thermometer, logger: logger}"
MORE_DEVICES = """\
  room: {type: thermometer, plugin: fake}
  logger: {type: logger, plugin: fake}
instruments:
"""

# old part, new part, where the finger points, field, message, hint
CASES = [
    ("$load}", "5 kN}", "5 kN", "main[0].set.tester.load", "5 kN is out of range (0 to 3 kN)",
     "these are the limits of tester.load"),
    ("$load}", "-1 N}", "-1 N", "main[0].set.tester.load",
     "-1 N is out of range (0 to 3000 N)", ""),
    ("$load}", "5 Hz}", "5 Hz", "main[0].set.tester.load",
     "got '5 Hz', a frequency; tester.load takes a force", "write it in N"),
    ("[2 Hz, 10 Hz]", "[2 Hz, 40 Hz]", "$frequencies", "main[1].sweep.over[1]",
     "40 Hz is out of range (0 to 35 Hz)", "it is written at p.yaml:11:23"),
    ("[2 Hz, 10 Hz]", "[2 Hz, 10 N]", "$frequencies", "main[1].sweep.over[1]",
     "got '10 N', a force; tester.frequency takes a frequency", "it is written at p.yaml:11:23"),
    ("set: tester.frequency\n", "set: tester.freqency\n", "tester.freqency", "main[1].sweep.set",
     "the device in the role 'tester' has no drive 'freqency'", "did you mean 'frequency'?"),
    ("{tester.load: $load}", "{tester.zzz: $load}", "tester.zzz", "main[0].set.tester.zzz",
     "the device in the role 'tester' has no drive 'zzz'", "drives: load, frequency"),
    ("{tester.load: $load}", "{testre.load: $load}", "testre", "main[0].set.testre.load",
     "'testre.load': the procedure uses no role 'testre'", "did you mean 'tester'?"),
    ("channel: tester.torque", "channel: tester.torqe", "tester.torqe", "setup[3].zero.channel",
     "the device in the role 'tester' has no channel 'torqe'", "did you mean 'torque'?"),
    ("within: 0.05 N·m", "within: 0.05 N", "0.05 N", "setup[3].zero.within",
     "got '0.05 N', a force; tester.torque takes a torque", "write it in N·m"),
    ("within: 0.05 N·m", "within: 0 N·m", "0 N·m", "setup[3].zero.within",
     "got '0 N·m', expected more than 0", ""),
    ("tester.frequency: 0 Hz}\n  - zero", "tester.frequency: 2 Hz}\n  - zero", "{channel: tester",
     "setup[3].zero", "zero is read at rest, but tester.frequency is at 2 Hz here",
     "set tester.frequency to 0 Hz before"),
    ("tester.angle,", "tester.angel,", "tester.angel", "main[1].sweep.steps[1].record.channels[0]",
     "the device in the role 'tester' has no channel 'angel'", "did you mean 'angle'?"),
    ("tester.angle,", "tester.torque,", "[tester.torque", "main[1].sweep.steps[1].record.channels",
     "a channel is listed twice", "name it once"),
    ("tester: swing_tester", "tester: press", "press", "uses.tester",
     "a press is needed, station 'bench-1' has a swing_tester",
     "the role is assigned at s.yaml:13:11"),
]  # fmt: skip


def planned(text, *, station=STATION, devices=DEVICES):
    return make_plan(parse_procedure(text, "p.yaml"), parse_station(station, "s.yaml"), devices)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case[1][:30])
def test_mismatch_with_the_station_is_refused(case):
    old, new, finger, field, message, hint = case
    text = edited(PROCEDURE, (old, new))
    problem = only_problem(planned, text)

    assert problem.message == message
    assert problem.field == field
    assert hint in problem.hint
    assert str(problem.location) == f"p.yaml:{place_of(text, finger)}"


def test_cycles_need_a_frequency():
    text = edited(PROCEDURE, ("[2 Hz, 10 Hz]", "[2 Hz, 0 Hz]"))
    settle, record = problems_of(planned, text)

    message = "cycles need a frequency, but tester.frequency is not set above 0 Hz here"
    assert settle.message == record.message == message
    assert str(settle.location) == f"p.yaml:{place_of(text, '5}')}"
    assert str(record.location) == f"p.yaml:{place_of(text, '30}')}"


def test_missing_role_is_reported_once():
    text = PROCEDURE.replace("tester", "rig")
    text = text.replace("swing_rig", "swing_tester")
    problem = only_problem(planned, text)

    assert problem.message == "station 'bench-1' has no device in the role 'rig'"
    assert str(problem.location) == f"p.yaml:{place_of(text, 'rig: swing')}"
    assert problem.hint == "roles: tester"


def test_device_of_another_type_is_the_only_problem_reported():
    """A step that this device cannot do says nothing about the procedure."""
    text = edited(
        PROCEDURE, ("tester: swing_tester", "tester: press"), ("tester.angle,", "tester.force,")
    )
    problem = only_problem(planned, text)

    assert problem.message == "a press is needed, station 'bench-1' has a swing_tester"


def test_recording_channels_of_two_devices_is_refused():
    text = edited(PROCEDURE, (ROLES, MORE_ROLES), ("tester.angle,", "logger.torque,"))
    station = edited(STATION, ("instruments:\n", MORE_DEVICES))
    problem = only_problem(lambda: planned(text, station=station))

    assert problem.message == "channels of two devices in one recording: logger, tester"
    assert str(problem.location) == f"p.yaml:{place_of(text, '[logger.torque')}"


def test_a_device_that_cannot_record_is_named():
    record = "main:\n  - record: {channels: [room.room], duration: 1 s}\n"
    text = edited(PROCEDURE, (ROLES, MORE_ROLES), ("main:\n", record))
    station = edited(STATION, ("instruments:\n", MORE_DEVICES))
    problems = problems_of(lambda: planned(text, station=station))

    assert problems[0].message == "the device in the role 'room' cannot record"
    assert problems[0].field == "main[0].record"


def test_cycles_need_a_drive_that_sets_their_frequency():
    plain_tester = Streamer(TESTER.channels, TESTER.drives[:1])
    text = PROCEDURE.replace("tester.frequency: 0 Hz", "tester.load: 1 N")
    text = edited(
        text.replace("set: {tester.load: 0 N, tester.load: 1 N}", "set: {tester.load: 0 N}"),
        ("set: tester.frequency", "set: tester.load"),
        ("[2 Hz, 10 Hz]", "[2 N]"),
    )
    problems = problems_of(lambda: planned(text, devices={"tester": plain_tester}))

    assert {p.message for p in problems} >= {
        "no device here has a drive that sets a cycle frequency"
    }
    assert [p.field for p in problems][:2] == [
        "main[1].sweep.steps[0].settle.cycles",
        "main[1].sweep.steps[1].record.cycles",
    ]


def test_two_cyclic_drives_make_cycles_ambiguous_where_no_role_decides():
    second = DriveInfo("speed", "Hz", "", 0.0, 50.0, sets_cycle_frequency=True)
    both = Streamer(TESTER.channels, (*TESTER.drives, second))
    problem = problems_of(lambda: planned(PROCEDURE, devices={"tester": both}))[0]

    assert problem.message == "several drives set a cycle frequency: tester.frequency, tester.speed"
    assert problem.hint == "give a time"


def test_unknown_unit_is_attributed_to_the_plugin_author():
    odd = Streamer((ChannelInfo("angle", "gon", ""), *TESTER.channels[1:]), TESTER.drives)
    problem = problems_of(lambda: planned(PROCEDURE, devices={"tester": odd}))[0]

    assert problem.message == "the device gives channel 'angle' in 'gon', which is not a known unit"
    assert "author of the device's plugin" in problem.hint


def test_too_many_actions_are_refused_before_expansion():
    values = ", ".join(["1 Hz"] * 400)
    nested = f"sweep: {{set: tester.frequency, over: [{values}], steps: [settle: {{time: 1 s}}]}}"
    text = edited(PROCEDURE, ("settle: {cycles: 5}", nested), ("[2 Hz, 10 Hz]", f"[{values}]"))
    problem = only_problem(planned, text)

    assert problem.message == "the procedure has 320,807 actions, more than 100,000"


def test_all_problems_are_reported_together_and_once():
    text = edited(
        PROCEDURE,
        ("{tester.load: $load}", "{tester.load: 9 kN}"),
        ("channel: tester.torque", "channel: tester.torqe"),
        ("tester.angle,", "tester.angel,"),
    )
    fields = [problem.field for problem in problems_of(planned, text)]

    assert fields == [
        "setup[3].zero.channel",
        "main[0].set.tester.load",
        "main[1].sweep.steps[1].record.channels[0]",
    ]


def test_cycles_need_a_frequency_that_was_set_before():
    text = edited(PROCEDURE, ("tester.frequency: 0 Hz}\n  - zero", "tester.load: 0 N}\n  - zero"),
                  ("{tester.load: 0 N, tester.load: 0 N}", "{tester.load: 0 N}"),
                  ("  - sweep:", "  - settle: {cycles: 5}\n  - sweep:"))  # fmt: skip
    problem = only_problem(planned, text)
    assert problem.message == (
        "cycles need a frequency, but tester.frequency is not set above 0 Hz here"
    )
