"""The import of recordings by a mapping, and its checks against procedure, station and files."""

from __future__ import annotations

import hashlib
import json
from datetime import datetime, timedelta

import numpy as np
import pytest

from helpers_cli import call
from rigrunner.api.events import Note, Scanned
from rigrunner.registry import load_registry
from rigrunner.runfile import is_in_progress, read
from rigrunner.tools.importing import run as importing
from rigrunner.tools.importing.mapping import load_mapping
from rigrunner.tools.importing.planning import plan_import

PROCEDURE = """\
rigrunner: procedure/2
id: SHORT
revision: "A"
title: Two set-points
measurand: {symbol: T, name: torque}
inputs: {specimen: {ask: Serial number, unattended: X}}
uses: {tester: swing_tester}
setup:
  - zero: {channel: tester.torque, within: 0.05 N·m}
main:
  - set: {tester.load: 1000 N}
  - sweep:
      set: tester.frequency
      over: [10 Hz, 20 Hz]
      steps: [{record: {channels: [tester.angle, tester.torque], cycles: 10}}]
"""
STATION = """\
rigrunner: station/1
id: bench-2
title: A rig that another program drives
rig:
  mandrel: M-01
  eccentric: 2 mm
  centre_distance: 45 mm
  inertia: 0.002 kg·m²
  support_friction: 0.7 N·m
  support_damping: 0.3 N·m·s/rad
devices:
  tester:
    type: swing_tester
    plugin: other_program
    settings:
      program: Old.vi
      rate: 1 kHz
      channels: {angle: {unit: deg}, torque: {unit: N·m}, force: {unit: N}, oil: {unit: °C}}
      drives:
        frequency: {min: 0 Hz, max: 35 Hz, sets_cycle_frequency: yes}
        load: {min: 0 N, max: 3 kN}
instruments:
  - channel: tester.torque
    serial: TQ-77
    full_scale: 10 N·m
    low_pass: {type: butterworth, order: 2, corner: 200 Hz}
    range: {min: -10 N·m, max: 10 N·m}
    accuracy: {gain: 0.3 %, offset: 0.02 N·m, drift: 0.02 N·m, nonlinearity: 0.05 %}
    certificate: K-1
    calibrated: 2025-06-11
    due: 2026-06-11
  - channel: tester.angle
    measures: angle
    serial: ENC-3
    accuracy: 0.02 deg
    range: {min: -5 deg, max: 5 deg}
    certificate: K-2
    due: 2026-06-12
"""
MAPPING = """\
rigrunner: import/1
procedure: short.yaml
station: bench.yaml
format: csv
program: Old.vi 1.0
by: A. Jones
started: 2026-03-02T09:15:00+01:00
inputs: {specimen: SN-17}
sampling: {rate: 1 kHz}
channels:
  tester.angle: {column: Angle, unit: deg}
  tester.torque: {column: Torque (mNm), unit: mN·m}
zeros: {tester.torque: 10 mN·m}
set_points: {tester.load: 1 kN}
conditions: {tester.oil: 40 °C, tester.force: {column: Force, unit: kN}}
recordings:
  - {file: a.csv, set_points: {tester.frequency: 10 Hz}}
  - {file: b.csv, set_points: {tester.frequency: 20 Hz}}
"""
TIME = np.arange(1200) / 1000
TORQUE_MNM = np.round(500 * np.sin(63 * TIME), 3)


def write_recording(path, count=1200, force=0.998):
    table = np.c_[TIME, np.degrees(0.04 * np.cos(63 * TIME)), TORQUE_MNM, 0 * TIME + force][:count]
    header = "Time,Angle,Torque (mNm),Force"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.9g")


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "short.yaml").write_text(PROCEDURE, encoding="utf-8")
    (tmp_path / "bench.yaml").write_text(STATION, encoding="utf-8")
    (tmp_path / "map.yaml").write_text(MAPPING, encoding="utf-8")
    write_recording(tmp_path / "a.csv")
    write_recording(tmp_path / "b.csv")
    return tmp_path


def run_import(lab, *changes, options=(), file="map.yaml"):
    """Import after changes of a file, each an old and a new text."""
    text = (lab / file).read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (lab / file).write_text(text, encoding="utf-8")
    return call("import", lab / "map.yaml", "--runs", lab / "runs", *options)


def imported(lab):
    (folder,) = (lab / "runs").iterdir()
    return read(folder)


def test_run_file_has_recordings_and_their_origin(lab):
    result = run_import(lab)
    assert result.code == 0, result.err
    run = imported(lab)
    header = run.header
    assert header.run_id == "20260302T081500Z_SHORT_SN-17"
    assert header.started_utc == "2026-03-02T08:15:00.000Z"
    assert header.imported["program"] == "Old.vi 1.0"
    assert header.imported["by"] == "A. Jones"
    assert header.imported["importer"].startswith("csv of rigrunner_plugins")
    digest = hashlib.sha256((lab / "a.csv").read_bytes()).hexdigest()
    assert header.imported["file a.csv"] == digest
    assert header.mapping_text == MAPPING
    assert header.provenance["device tester"] == "recorded by Old.vi 1.0"
    assert (run.info.outcome, run.info.sealed) == ("completed", True)
    assert run.zeros == {"tester.torque": pytest.approx(0.01)}
    first, second = run.recordings
    assert first.setpoints == {"tester.load": 1000.0, "tester.frequency": 10.0}
    assert second.setpoints["tester.frequency"] == 20.0
    assert first.rate_hz == 1000.0
    np.testing.assert_allclose(first.channels["tester.torque"], TORQUE_MNM / 1000, rtol=1e-12)
    expected = 0.04 * np.cos(63 * TIME)
    np.testing.assert_allclose(first.channels["tester.angle"], expected, atol=1e-9)
    assert first.conditions["tester.oil"] == pytest.approx(313.15)
    assert first.conditions["tester.force"] == pytest.approx(998.0)
    assert first.units == {
        "tester.angle": "rad", "tester.torque": "N·m", "tester.oil": "K", "tester.force": "N",
        "tester.load": "N", "tester.frequency": "Hz",
    }  # fmt: skip
    assert second.started_utc == "2026-03-02T08:15:01.200Z"
    assert run.info.ended_utc == "2026-03-02T08:15:02.400Z"


def test_log_and_show_state_that_the_run_was_imported(lab):
    run_import(lab)
    (folder,) = (lab / "runs").iterdir()
    log = (folder / "run.log").read_text(encoding="utf-8")
    assert "Old.vi 1.0 made the recordings, not Rigrunner" in log
    assert "as A. Jones states them" in log
    shown = call("show", folder)
    assert "recorded by Old.vi 1.0; read by csv" in shown.out
    document = json.loads(call("show", folder, "--json").out)
    assert document["imported"]["mapping"] == "map.yaml"


def test_part_of_a_file_is_imported(lab):
    result = run_import(lab, ("{file: a.csv,", "{file: a.csv, from: 50 ms, to: 1.15 s,"))
    assert result.code == 0, result.err
    first, _ = imported(lab).recordings
    np.testing.assert_allclose(first.channels["tester.torque"], TORQUE_MNM[50:1150] / 1000)


def test_parts_of_a_file_may_be_separate_recordings(lab):
    run_import(lab, ("[10 Hz, 20 Hz]", "[20 Hz, 25 Hz]"), file="short.yaml")
    early, late = "{file: b.csv, to: 600 ms,", "{file: b.csv, from: 600 ms,"
    frequencies = (("10 Hz", "25 Hz"),)
    changes = (("{file: b.csv,", early), ("{file: a.csv,", late), *frequencies)
    result = run_import(lab, *changes)
    assert result.code == 0, result.err
    second, third = (recording.channels["tester.torque"] for recording in imported(lab).recordings)
    np.testing.assert_allclose(np.r_[second, third], TORQUE_MNM / 1000)


def test_zero_is_the_mean_of_a_recording_at_rest(lab):
    (lab / "rest.csv").write_text("Torque (mNm)\n19\n21\n23\n25\n")
    result = run_import(lab, ("10 mN·m}", "{file: rest.csv, to: 3 ms}}"))
    assert result.code == 0, result.err
    assert imported(lab).zeros["tester.torque"] == pytest.approx(0.021)
    assert "file rest.csv" in imported(lab).header.imported


def test_recordings_may_be_listed_in_any_order(lab):
    a, b = (f"file: {name}.csv, set_points: {{tester.frequency: " for name in "ab")
    write_recording(lab / "b.csv", force=2.0)
    result = run_import(lab, (a + "10 Hz", a + "20 Hz"), (b + "20 Hz", b + "600 rpm"))
    assert result.code == 0, result.err
    first, second = imported(lab).recordings
    assert first.conditions["tester.force"] == pytest.approx(2000.0)
    assert second.conditions["tester.force"] == pytest.approx(998.0)


WRONG = {
    "rigrunner: import/1 -> rigrunner: import/2": "map.yaml:1:12: error: rigrunner: got 'import/2'",
    "by: A. Jones -> who: A. Jones": "unknown key 'who'",
    "+01:00 -> ": "map.yaml:7:10: error: started: '2026-03-02T09:15:00' is not",
    "short.yaml -> long.yaml": "map.yaml:2:12: error: procedure: there is no procedure 'long.yaml'",
    "bench.yaml -> bank.yaml": "map.yaml:3:10: error: station: there is no station 'bank.yaml'",
    "format: csv -> format: cvs": "map.yaml:4:9: error: format: there is no importer 'cvs'",
    "format: csv -> format: {csv: {delimiter: x}}": "map.yaml:4:27: error: format.csv.delimiter",
    "specimen: SN-17 -> specimin: SN-17": "map.yaml:8:10: error: inputs.specimin: the proced",
    "{specimen: SN-17} -> {}": "map.yaml:8:1: error: inputs: the answer to 'specimen' is missing",
    "tester.angle: { -> tester.angel: {": "map.yaml:11:3: error: channels.tester.angel: the proced",
    "Angle, unit: deg -> Angle, unit: N": "'N' is a unit of force, but tester.angle needs one",
    "column: Angle -> column: Angel": "map.yaml:11:26: error: channels.tester.angle.column: ",
    "zeros: {tester.torque: 10 mN·m} -> zeros: {}": "zeroes 'tester.torque', but its reading",
    "zeros: {tester.torque -> zeros: {tester.angle": "does not zero this channel",
    "10 mN·m} -> 10 N}": "'N' is a unit of force, but tester.torque needs one of torque",
    "10 mN·m} -> 60 mN·m}": "map.yaml:13:24: error: zeros.tester.torque: tester.torque read 0.06",
    "10 mN·m} -> [60 mN·m]}": "map.yaml:13:25: error: zeros.tester.torque[0]: tester.torque read",
    "10 mN·m} -> [10 mN]}": "map.yaml:13:25: error: zeros.tester.torque[0]: 'mN' is a unit of",
    "10 mN·m} -> {file: rest.csv}}": "map.yaml:13:31: error: zeros.tester.torque.file: there is no",
    "10 mN·m} -> [{file: rest.csv}]}": "map.yaml:13:32: error: zeros.tester.torque[0].file: there",
    "{tester.load: 1 kN} -> {}": "the set-point is missing of: tester.load",
    "{tester.load: 1 kN} -> {tester.lode: 1 kN}": "the procedure does not set this drive",
    "tester.oil: 40 -> tester.soil: 40": "the station has no such channel",
    "tester.oil: 40 -> tester.torque: 40": "this channel is recorded already",
    "column: Force, unit: kN -> column: Farce, unit: kN": "conditions.tester.force.column: ",
    "frequency: 20 Hz -> frequency: 21 Hz": "there is no recording at tester.load 1000 N, tes",
    "frequency: 20 Hz -> frequency: 10 Hz": "map.yaml:18:5: error: recordings[1]: the proced",
    "file: b.csv -> file: c.csv": "map.yaml:18:12: error: recordings[1].file: there is",
    "file: b.csv -> file: b.csv, group: x": "map.yaml:18:26: error: recordings[1].group: ",
    "file: b.csv -> file: b.csv, from: 9 s": "map.yaml:18:25: error: recordings[1].from: b.csv is",
    "file: b.csv -> file: b.csv, from: 1 s, to: 1 s": "'from' must be before 'to'",
    "file: b.csv -> file: a.csv": "map.yaml:18:12: error: recordings[1].file: recordings[0] has",
    "by: A. Jones -> by: A. Jones\nended: 2026-03-02T09:14:00+01:00": "ended before it was started",
    "by: A. Jones -> by: A. Jones\nended: 2026-03-02T09:15:01+01:00": "which is later",
    "Torque (mNm), unit: mN·m -> Torque (mNm), unit: N·m": "a.csv states 'mNm' for",
}  # fmt: skip


@pytest.mark.parametrize("change", WRONG)
def test_inconsistent_mapping_is_refused_with_its_location(lab, change):
    old, _, new = change.partition(" -> ")
    result = run_import(lab, (old, new))
    assert result.code == 3, result.err
    assert WRONG[change] in result.err
    assert not list((lab / "runs").glob("*"))


def test_misspelt_column_gets_a_suggestion(lab):
    result = run_import(lab, ("column: Angle", "column: Angel"))
    assert "a.csv:1: the column 'Angel' of 'tester.angle' is not there" in result.err
    assert "did you mean 'Angle'?" in result.err


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda path: write_recording(path, 540), "is only 0.54 s long; asked for is: Record"),
        (lambda path: path.write_text(""), "b.csv"),
        (lambda path: path.write_text(path.read_text()[:-20]), "b.csv:1201:"),
    ],
)
def test_invalid_recording_is_refused_and_leaves_no_run(lab, damage, message):
    damage(lab / "b.csv")
    result = run_import(lab)
    assert result.code in {3, 5}
    assert message in result.err
    assert not list((lab / "runs").iterdir())


def test_second_import_of_a_specimen_is_noted(lab):
    """In trends and capability studies it counts as another specimen."""
    assert "already" not in run_import(lab).err
    (first,) = (lab / "runs").iterdir()
    second = run_import(lab)
    assert second.code == 0
    assert f"note: SN-17 has already been tested: run {first.name}" in second.err


def test_extra_cycle_is_required_only_of_cyclic_motion(lab):
    write_recording(lab / "b.csv", 540)
    assert "needs one cycle more" in run_import(lab).err
    for name, old, new in (
        ("bench.yaml", ", sets_cycle_frequency: yes", ""),
        ("short.yaml", "cycles: 10", "duration: 1 s"),
    ):
        text = (lab / name).read_text(encoding="utf-8")
        (lab / name).write_text(text.replace(old, new), encoding="utf-8")
    refused = run_import(lab).err
    assert "asked for is: Record" in refused
    assert "one cycle more" not in refused


def test_rate_other_than_that_of_the_station_is_refused(lab):
    result = run_import(lab, ("rate: 1 kHz", "rate: 2 kHz"), file="bench.yaml")
    assert result.code == 5
    refusal = "the recording has 1000 samples per second, the station states 2000 for 'tester'"
    assert f"a.csv: error: {refusal}" in result.err
    assert run_import(lab, ("rate: 2 kHz", "rate: 1.005 kHz"), file="bench.yaml").code == 0


def test_gap_in_the_times_names_its_sample(lab):
    change = ("{rate: 1 kHz}", "{time: {column: Time, unit: s}}")
    lines = (lab / "b.csv").read_text().splitlines(keepends=True)
    (lab / "b.csv").write_text("".join(lines[:501] + lines[502:]))
    result = run_import(lab, change)
    assert result.code == 5
    assert "b.csv: error: sample 501 comes 0.002 s after the one before" in result.err


def test_wrong_unit_in_a_file_can_be_overridden(lab):
    change = ("Torque (mNm), unit: mN·m", "Torque (mNm), unit: N·m, file_says: mNm")
    result = run_import(lab, change, ("10 mN·m", "10 mN·m"))
    assert result.code == 0, result.err


def test_calibrations_are_checked_at_the_date_of_the_run(lab):
    late = ("2026-03-02T09:15:00", "2026-07-02T09:15:00")
    result = run_import(lab, late)
    assert result.code == 3
    assert "was due on 2026-06-11, 21 days before this run" in result.err
    words = ["--override", "overdue", "--by", "B. Lee", "--reason", "sent in"]
    result = run_import(lab, options=words)
    assert result.code == 0, result.err
    assert "B. Lee" in str([*imported(lab).events])


def test_approval_after_the_run_does_not_count(lab):
    call("approve", lab / "short.yaml", "--by", "C. Wu", "--date", "2026-03-03")
    assert run_import(lab).code == 0
    approval = imported(lab).header.approval
    assert approval["state"] == "draft"
    assert "approved by C. Wu on 2026-03-03, after the recordings were made" in approval["note"]


def test_approval_before_the_run_counts(lab):
    call("approve", lab / "short.yaml", "--by", "C. Wu", "--date", "2026-03-01")
    assert run_import(lab).code == 0
    assert imported(lab).header.approval["state"] == "approved"


def test_plugins_of_a_mapping_station_are_not_loaded(lab):
    (lab / "plugins").mkdir()
    (lab / "plugins" / "evil.py").write_text("raise SystemExit('code was run')")
    with (lab / "bench.yaml").open("a") as file:
        file.write("plugins: plugins\n")
    result = run_import(lab)
    assert result.code == 2
    assert "has plugins of its own" in result.err
    assert "--station" in result.err


def test_killed_import_cannot_be_resumed(lab, monkeypatch):
    def killed(*_, **__):
        raise SystemExit

    monkeypatch.setattr(importing, "finish", killed)
    checked = plan_import(load_mapping(lab / "map.yaml"), load_registry())
    with pytest.raises(SystemExit):
        importing.import_run(checked, runs=lab / "runs", partners={})
    (folder,) = (lab / "runs").iterdir()
    result = call("resume", folder, "--unattended")
    assert result.code == 2
    assert "is an interrupted import" in result.err


def test_file_changed_while_importing_is_refused(lab, monkeypatch):
    digests = iter("abcd")
    monkeypatch.setattr(importing, "_digest", lambda _: next(digests))
    result = run_import(lab)
    assert result.code == 5
    assert "was changed while it was read" in result.err
    assert not list((lab / "runs").iterdir())


def test_failed_run_folder_is_unlocked_before_removal(lab, monkeypatch):
    """Windows does not remove open files, such as the lock of the folder."""
    in_progress = []

    def look(folder, **_):
        in_progress.append(is_in_progress(folder))

    monkeypatch.setattr(importing, "_check_unchanged", lambda *_: 1 / 0)
    monkeypatch.setattr(importing.shutil, "rmtree", look)
    checked = plan_import(load_mapping(lab / "map.yaml"), load_registry())
    with pytest.raises(ZeroDivisionError):
        importing.import_run(checked, runs=lab / "runs", partners={})
    assert in_progress == [False]


MEASURES = (
    "main:\n",
    """main:
  - zero: {channel: tester.torque, within: 0.05 N·m}
  - measure: {channels: [tester.torque], name: held, limits: {tester.torque: {max: 5 N·m}}}
""",
)
TWICE = ("tester.torque: 10 mN·m}", "tester.torque: [10 mN·m, {file: rest.csv, to: 3 ms}]}")
HELD = "measurements:\n  - {name: held, values: {tester.torque: 415 mN·m}}\n"


def test_single_values_and_several_zeros_are_imported(lab):
    (lab / "rest.csv").write_text("Torque (mNm)\n19\n21\n23\n25\n")
    run_import(lab, MEASURES, file="short.yaml")
    result = run_import(lab, TWICE, ("recordings:\n", f"{HELD}recordings:\n"))
    assert result.code == 0, result.err
    run = imported(lab)
    (row,) = run.measurements
    assert (row.name, row.units["tester.torque"]) == ("held", "N·m")
    assert row.values["tester.torque"] == pytest.approx(0.415)
    assert run.zeros["tester.torque"] == pytest.approx(0.021)  # the last one applies, as in a run
    assert "file rest.csv" in run.header.imported


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "name: held",
            "name: hold",
            "map.yaml:17:12: error: measurements[0].name: the procedure m",
        ),
        ("415 mN·m", "415 N", "'N' is a unit of force, but tester.torque needs one of torque"),
        ("{tester.torque: 41", "{tester.force: 41", "the procedure measures here: tester.torque"),
        (HELD, "", "the measurement 'held' is missing, of tester.torque"),
        (HELD, HELD + HELD.partition("\n")[2], "measurements[1]: the procedure measures nothing"),
        ("[10 mN·m, {file: rest.csv, to: 3 ms}]", "10 mN·m", "zeroes it 2 times, given: 1"),
        ("[10 mN·m, {file: rest.csv, to: 3 ms}]", "[10 mN·m, 5 N]", "'N' is a unit of force"),
        ("[10 mN·m, {file: rest.csv, to: 3 ms}]", "[10 mN·m, 60 mN·m]", "read 0.06 N·m at rest"),
    ],
)
def test_values_that_do_not_match_the_procedure_are_refused(lab, old, new, message):
    (lab / "rest.csv").write_text("Torque (mNm)\n19\n21\n23\n25\n")
    run_import(lab, MEASURES, file="short.yaml")
    result = run_import(lab, TWICE, ("recordings:\n", f"{HELD}recordings:\n"), (old, new))
    assert message in result.err
    assert result.code in (3, 5)


def test_condition_with_a_limit_must_be_stated(lab):
    limits = ", limits: {tester.oil: {max: 41 °C}}}}]"
    run_import(lab, ("cycles: 10}}]", f"cycles: 10{limits}"), file="short.yaml")
    assert run_import(lab).code == 0
    result = run_import(lab, ("tester.oil: 40 °C, ", ""))
    assert result.code == 3
    assert "map.yaml:17:5: error: recordings[0]: tester.oil is not stated, and the" in result.err
    too_hot = run_import(lab, ("{tester.force: {col", "{tester.oil: 42 °C, tester.force: {col"))
    assert too_hot.code == 1
    assert "tester.oil is 42 °C (limit: 41 °C or less)" in too_hot.out


def test_stated_value_beyond_its_limit_fails_the_run(lab):
    run_import(lab, SCANS, file="short.yaml")
    high = ("4.5 N·m", "5.5 N·m")
    result = run_import(lab, ("recordings:\n", f"{STATED}recordings:\n"), high)
    assert result.code == 1, result.err
    run = imported(lab)
    assert run.info.outcome == "completed"
    passes = [decision.passes for row in run.measurements for decision in row.decisions]
    assert passes == [True, False, True]
    text = "tester.torque is 5.5 N·m (limit: 5 N·m or less)"
    assert text in result.out


SCANS = (
    "main:\n",
    """main:
  - scan:
      set: tester.load
      over: [100 N, 200 N, 300 N]
      channels: [tester.torque]
      name: held
      limits: {tester.torque: {max: 5 N·m, marginal: 2 N·m}}
  - measure: {channels: [tester.torque], name: after}
""",
)
STATED = """\
measurements:
  - {name: held, values: {tester.torque: 415 mN·m}}
  - {name: held, values: {tester.torque: 4.5 N·m}}
  - {name: held, values: {tester.torque: 617 mN·m}}
  - {name: after, values: {tester.torque: 7 N·m}}
"""


def import_scan(lab, *changes):
    run_import(lab, SCANS, file="short.yaml")
    return run_import(lab, ("recordings:\n", f"{STATED}recordings:\n"), *changes)


def test_points_of_a_scan_are_imported(lab):
    result = import_scan(lab)
    assert result.code == 0, result.err
    run = imported(lab)
    assert [
        (row.name, row.setpoints["tester.load"], round(row.values["tester.torque"], 9))
        for row in run.measurements
    ] == [("held", 100.0, 0.415), ("held", 200.0, 4.5), ("held", 300.0, 0.617), ("after", 300, 7)]
    assert run.measurements[0].units == {"tester.load": "N", "tester.torque": "N·m"}
    (near,) = [row for row in run.events if isinstance(row, Note) and "marginal" in row.text]
    assert near.step == "main[0].scan"
    assert near.text.startswith("at tester.load 200 N (point 2 of 3): tester.torque is 4.5 N·m")
    scanned = [row.point for row in run.events if isinstance(row, Scanned)]
    assert scanned == [0, 1, 2]


@pytest.mark.parametrize(
    ("line", "replacement", "message"),
    [
        (3, "", "measurements[2].name: the procedure measures 'held' here"),
        (4, "", "the measurement 'after' is missing, of tester.torque"),
        (1, "  - {name: held, values: {tester.load: 5.5 N}}\n",
         "the procedure measures here: tester.torque"),
        (4, STATED[14:], "the procedure measures nothing"),
    ],
)  # fmt: skip
def test_points_that_do_not_match_the_scan_are_refused(lab, line, replacement, message):
    old = STATED.splitlines(keepends=True)[line]
    result = import_scan(lab, (old, replacement))
    assert message in result.err
    assert result.code in (3, 5)


def test_procedure_without_recordings_is_refused(lab):
    measure = ("cycles: 10}}]", "cycles: 10}}, {measure: {channels: [tester.torque]}}]")
    text = (lab / "short.yaml").read_text(encoding="utf-8")
    run_import(lab, measure, file="short.yaml")
    assert "is missing, of" in run_import(lab).err
    wait = (
        "{record: {channels: [tester.angle, tester.torque], cycles: 10}}",
        "{wait: {time: 1 s}}",
    )
    (lab / "short.yaml").write_text(text, encoding="utf-8")
    result = run_import(lab, wait, file="short.yaml")
    assert result.code == 3
    assert "SHORT records nothing" in result.err


def test_import_from_a_simulated_station_is_marked_simulated(lab):
    settings = STATION[STATION.index("    settings:") : STATION.index("instruments:")]
    simulated = "plugin: swing_tester_sim\n    settings: {sensors: {rate: 1 kHz}}\n"
    change = ("plugin: other_program\n" + settings, simulated)
    run_import(lab, change, file="bench.yaml")
    conditions = ("conditions: {tester.oil: 40 °C, tester.force: {column: Force, unit: kN}}\n", "")
    result = run_import(lab, conditions)
    assert result.code == 0, result.err
    assert imported(lab).header.provenance["device tester"] == "recorded by Old.vi 1.0 (simulated)"


def test_rig_of_another_program_cannot_be_run(lab):
    station = ("--station", lab / "bench.yaml", "--runs", lab / "runs")
    result = call("run", lab / "short.yaml", *station, "--unattended",
                  "--override", "overdue", "--by", "x", "--reason", "y")  # fmt: skip
    assert result.code == 4
    assert "Old.vi controls this rig, not Rigrunner" in result.err


def test_dates_of_the_files_must_be_within_the_run(lab):
    from unit.rigrunner_plugins.importers.helpers_importing import lvm_text  # noqa: PLC0415  (npTDMS comes with it)

    angle, torque = np.cos(63 * TIME).tolist(), TORQUE_MNM.tolist()
    for name, day in (("a.lvm", "2026/03/02"), ("b.lvm", "2026/03/05")):
        channels = {"Angle": angle, "Torque (mNm)": torque, "Force": torque}
        text = lvm_text([channels], delta="1.000000E-3", unit="", day=day)
        (lab / name).write_text(text)
    result = run_import(lab, ("csv", "lvm"), (": {column: Force, unit: kN}", ": 1 kN"))
    assert result.code == 3
    assert (
        "map.yaml:18:12: error: recordings[1].file: the file says that it was recorded at"
        in result.err
    )
    assert "2026-03-05T09:15:01.250Z" in result.err  # 10:15:01.25 in the zone of `started`
    result = run_import(lab, ("by: A. Jones", "by: A. Jones\nended: 2026-03-05T12:00:00+01:00"))
    assert result.code == 0, result.err
    first, _ = imported(lab).recordings
    assert first.started_utc == "2026-03-02T09:15:01.250Z"
    ended = datetime.fromisoformat(imported(lab).info.ended_utc)
    assert ended - datetime.fromisoformat(first.started_utc) > timedelta(days=3)


def test_columns_of_unequal_length_are_refused(lab):
    from nptdms import ChannelObject, TdmsWriter  # noqa: PLC0415  (as above)

    for name, count in (("a.tdms", 1200), ("b.tdms", 1199)):
        columns = {"Angle": TIME, "Torque (mNm)": TORQUE_MNM[:count]}
        with TdmsWriter(lab / name) as writer:
            writer.write_segment([ChannelObject("r", *column) for column in columns.items()])
    csv = (": {column: Force, unit: kN}", ": 1 kN")
    result = run_import(lab, ("format: csv", "format: tdms"), (".csv", ".tdms"), csv)
    assert result.code == 5
    text = "b.tdms: error: the columns have different numbers of samples: 1200 of 'Angle', 1199 of"
    assert text in result.err
