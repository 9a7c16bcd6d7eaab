"""Plans that lack something for the torque analysis are refused with the location."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, STATION, edited, only_problem, place_of, problems_of
from unit.rigrunner_bearings.torque.helpers_planning import planned


def test_recording_without_torque_is_refused():
    text = edited(PROCEDURE, (", tester.torque]", "]"))
    problem = only_problem(planned, text)

    assert problem.field == "main[1].sweep.steps[1].record.channels"
    assert problem.message == (
        "the analysis needs one channel of torque in each recording, got none"
    )
    assert str(problem.location) == f"p.yaml:{place_of(text, '[tester.angle]')}"


def test_recording_without_set_frequency_is_refused():
    text = edited(
        PROCEDURE,
        ("{cycles: 5}", "{time: 1 s}"),
        ("cycles: 30", "duration: 1 s"),
        ("[2 Hz, 10 Hz]", "[0 Hz]"),
    )
    problem = only_problem(planned, text)

    assert problem.message == "the analysis needs a cycle frequency, and none is set here"


def test_analysis_without_recording_is_refused():
    start, end = PROCEDURE.index("  - sweep:"), PROCEDURE.index("teardown:")
    problem = only_problem(planned, PROCEDURE[:start] + PROCEDURE[end:])

    assert (problem.field, problem.message) == (
        "analysis[0].swing_torque",
        "there is no recording to analyse",
    )


def test_register_must_have_the_torque_channel():
    station = STATION[: STATION.index("instruments:")]
    problem = only_problem(lambda: planned(PROCEDURE, station=station))

    assert problem.message == "there is no instrument for the channel tester.torque"
    assert problem.location.file == "s.yaml"
    assert "it is needed at p.yaml:24:19" in problem.hint


def test_register_must_have_the_low_pass():
    station = edited(STATION, ("    low_pass: {type: butterworth, order: 2, corner: 1 kHz}\n", ""))
    problem = only_problem(lambda: planned(PROCEDURE, station=station))

    assert problem.message == "the low_pass of the instrument for tester.torque is missing"
    assert str(problem.location) == f"s.yaml:{place_of(station, 'channel:')}"


def bench_without(*lines):
    return edited(STATION, *((line, "") for line in lines))


@pytest.mark.parametrize(
    ("line", "key", "part"),
    [
        ("  eccentric: 2 mm\n", "eccentric", "swing_torque:"),
        ("  centre_distance: 45 mm\n", "centre_distance", "swing_torque:"),
    ],
)
def test_missing_key_of_rig_is_reported_with_both_locations(line, key, part):
    station = bench_without(line)
    problem = only_problem(lambda: planned(PROCEDURE, station=station))

    assert problem.field == f"rig.{key}"
    assert problem.message == f"the analysis needs the key '{key}' of the rig, which is missing"
    assert str(problem.location) == f"s.yaml:{place_of(station, 'rig:')}"
    assert problem.hint == f"it is needed at p.yaml:{place_of(PROCEDURE, part)}"


NO_RIG = STATION[: STATION.index("rig:")] + STATION[STATION.index("devices:") :]


def test_procedure_without_torque_needs_no_rig_or_register():
    text = PROCEDURE[: PROCEDURE.index("analysis:")]
    _, _, plan, _ = planned(text, station=NO_RIG[: NO_RIG.index("instruments:")])
    assert plan.recordings


def test_starts_from_rest_need_no_crank():
    start = PROCEDURE.index("  - swing_torque:")
    starts = "  - breakaway: {outliers: mad, fits: [inertia]}\n"
    text = PROCEDURE[:start] + starts
    problems = problems_of(lambda: planned(text, station=NO_RIG))
    assert not any(problem.field.startswith("rig") for problem in problems)


RECORD = "record: {channels: [tester.angle, tester.torque], cycles: 30}"
MIXED = edited(
    PROCEDURE,
    (
        "  - sweep:\n",
        f"""\
  - set: {{tester.frequency: 10 Hz}}
  - group: {{label: {{phase: wear}}, steps: [{{set: {{tester.load: $load}}}}, {{{RECORD}}}]}}
  - sweep:
""",
    ),
)


def test_averaging_over_labels_is_refused_before_the_run():
    problem = only_problem(lambda: planned(MIXED))
    assert problem.field == "analysis[0].swing_torque"
    assert problem.message == (
        "recordings with the same set-points would be averaged: phase wear; no label"
    )
    assert "where" in problem.hint


def chosen(where):
    return edited(MIXED, ("swing_torque:\n", f"swing_torque:\n      where: {where}\n"))


def test_selection_resolves_ambiguous_labels():
    assert planned(chosen("{phase: wear}"))[2].recordings


@pytest.mark.parametrize(
    ("where", "message", "hint"),
    [
        ("{phase: final}", "nothing has phase final", "there are: wear"),
        ("{phas: wear}", "nothing that is recorded or measured has 'phas'", "did you mean 'phase'"),
    ],
)
def test_empty_selection_is_refused_with_its_line(where, message, hint):
    text = chosen(where)
    problem = only_problem(lambda: planned(text))
    assert problem.location.line == text[: text.index("where: {")].count("\n") + 1
    assert problem.message == message
    assert hint in problem.hint
