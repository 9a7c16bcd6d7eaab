"""A scan from the command line: planned, run, shown, interrupted, resumed, replayed."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass

import h5py
import pytest

from e2e.helpers_resume import Snapshot
from helpers_cli import call
from helpers_workflow import run, station_file
from rigrunner.api.events import Intervention, Scanned, StepEnded, StepStarted
from rigrunner.run.locate import find_procedure
from rigrunner.runfile import read

HEAD = """\
rigrunner: procedure/2
id: SCAN
revision: "A"
title: Load cell over the range of the press
measurand: {symbol: F, name: force on the bearing}
uses: {tester: swing_tester}
"""
LOADS = (100.0, 200.0, 500.0, 1000.0)
MAIN = """\
main:
  - set: {tester.frequency: 5 Hz}
  - scan:
      set: tester.load
      over: [100 N, 200 N, 0.5 kN, 1 kN]
      settle: 2 s
      channels: [tester.load, tester.temperature]
      name: cell
"""
AFTER = """\
  - settle: {time: 3 s}
  - record: {channels: [tester.angle, tester.torque], cycles: 5}
"""
TEARDOWN = "teardown:\n  - set: {tester.load: 0 N}\n"


@dataclass
class Lab:
    """A folder with a procedure and its runs."""

    folder: object

    def write(self, text=HEAD + MAIN + AFTER + TEARDOWN, name="scan.yaml"):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    @property
    def runs(self):
        return self.folder / "runs"

    def run(self, text=HEAD + MAIN + AFTER + TEARDOWN, *options, station="simulated"):
        words = ("--station", station, "--unattended", "--runs", self.runs)
        called = call("run", self.write(text), *words, *options)
        assert called.code == 0, called.err
        return self.last()

    def last(self):
        return read(max(self.runs.iterdir(), key=lambda folder: folder.stat().st_mtime_ns))

    def folder_of(self, stored):
        return stored.info.path.parent


@pytest.fixture
def lab(tmp_path):
    return Lab(tmp_path)


def loads(measurements):
    return [one.setpoints["tester.load"] for one in measurements]


def test_scan_is_planned_as_one_step(lab):
    procedure = lab.write()
    shown = call("plan", procedure, "--station", "simulated").out
    assert re.search(r"main +Scan tester.load between 100 N and 1 kN, 4 points, \S+ +10.0 s", shown)
    assert re.search(r"tester.load +0 to 1000 N +0 to 3000 N", shown)
    plan = json.loads(call("plan", procedure, "--station", "simulated", "--json").out)
    (scan,) = [step for step in plan["steps"] if step["do"] == "scan"]
    assert scan["action"]["values"] == list(LOADS)
    assert (scan["path"], scan["action"]["settle_s"]) == ("main[1].scan", 2.0)


def test_points_of_a_scan_are_rows_of_a_table(lab):
    stored = lab.run()
    rows = stored.measurements
    assert loads(rows) == list(LOADS)
    assert {one.setpoints["tester.frequency"] for one in rows} == {5.0}
    for one in rows:
        assert one.values["tester.load"] == pytest.approx(one.setpoints["tester.load"], abs=3)
        assert 290 < one.values["tester.temperature"] < 300
    (record,) = stored.recordings
    assert record.setpoints["tester.load"] == 1000.0
    shown = call("show", lab.folder_of(stored)).out
    assert "Measured: cell" in shown
    assert re.findall(r"^ +5 +([0-9.]+) ", shown, re.MULTILINE) == ["0.1", "0.2", "0.5", "1"]
    with h5py.File(lab.folder_of(stored) / "run.h5") as file:
        table = file["entry/measurements/cell"]
        assert list(table["setpoints/tester_load"][()]) == list(LOADS)
    log = (lab.folder_of(stored) / "run.log").read_text(encoding="utf-8")
    assert log.count("main[1].scan") == 1
    assert call("verify", lab.folder_of(stored)).code == 0


def test_tape_of_a_scan_is_replayed(lab):
    tape = lab.folder / "tape"
    first = lab.run(HEAD + MAIN + TEARDOWN, "--record", tape)
    replayed = lab.run(HEAD + MAIN + TEARDOWN, "--replay", tape)
    assert replayed.info.path != first.info.path
    assert [dict(one.values) for one in replayed.measurements] == [
        dict(one.values) for one in first.measurements
    ]
    assert replayed.digest == first.digest


EVERYWHERE = f"""{HEAD}setup:
  - scan: {{set: tester.load, over: [10 N, 20 N], channels: [tester.load], name: setup}}
main:
  - sweep:
      set: tester.frequency
      over: [2 Hz, 4 Hz]
      steps:
        - repeat:
            times: 2
            steps:
              - scan:
                  set: tester.load
                  over: [100 N, 200 N]
                  channels: [tester.load]
                  name: swept
  - call: {{procedure: inner.yaml, with: {{loads: [30 N, 40 N]}}}}
  - measure: {{channels: [tester.load], name: after}}
teardown:
  - scan: {{set: tester.load, over: [50 N, 0 N], channels: [tester.load], name: down}}
"""
INNER = f"""{HEAD}parameters: {{loads: [1 N]}}
main:
  - scan: {{set: tester.load, over: $loads, channels: [tester.load], name: inner}}
teardown:
  - scan: {{set: tester.load, over: [5 N], channels: [tester.load], name: inner}}
"""


def test_scan_is_allowed_wherever_a_step_is(lab):
    lab.write(INNER, "inner.yaml")
    rows = lab.run(EVERYWHERE).measurements
    swept = [one for one in rows if one.name == "swept"]
    assert loads(swept) == [100.0, 200.0] * 4
    assert [one.setpoints["tester.frequency"] for one in swept] == [2.0] * 4 + [4.0] * 4
    others = {
        name: loads([one for one in rows if one.name == name])
        for name in ("setup", "inner", "after", "down")
    }
    assert others == {
        "setup": [10.0, 20.0], "inner": [30.0, 40.0, 5.0], "after": [5.0], "down": [50.0, 0.0],
    }  # fmt: skip
    for one in rows:
        assert one.values["tester.load"] == pytest.approx(one.setpoints["tester.load"], abs=3)
        assert one.units["tester.load"] == "N"


def test_ramped_drive_takes_the_time_of_its_rate(lab):
    slower = "safety:\n  drives:\n    tester.load: {rate: 50 N/s}\n"
    station = station_file(lab.folder, ("safety:\n", slower))
    stored = lab.run(HEAD + MAIN + TEARDOWN, station=station)
    starts = [e for e in stored.events if isinstance(e, StepStarted) and e.action == "scan"]
    times = [one.monotonic_s for one in stored.events if isinstance(one, Scanned)]
    since_s = [at - starts[0].monotonic_s for at in times]
    assert since_s == pytest.approx([2 + 2, 4 + 4, 10 + 6, 20 + 8], abs=0.1)
    plan = json.loads(call("plan", lab.write(), "--station", station, "--json").out)
    assert plan["steps"][1]["estimated_s"] == pytest.approx(28.0)
    assert loads(stored.measurements) == list(LOADS)


def interrupted(lab, at):
    """Return the folder as after kill -9 at an event, and the uninterrupted run."""
    lab.write()
    lab.runs.mkdir()
    snapshot = Snapshot(lab.runs, lab.folder / "killed", at)
    whole = run(lab.folder / "scan.yaml", lab.runs, listeners=[snapshot])
    return snapshot.folder, read(whole.folder)


def test_run_killed_during_a_scan_repeats_the_scan(lab):
    folder, whole = interrupted(lab, lambda event: isinstance(event, Scanned) and event.point == 1)
    assert loads(read(folder).measurements) == [100.0, 200.0]
    shown = call("resume", folder, "--dry-run")
    assert "resumes at main[1].scan" in shown.err + shown.out
    assert "measured: cell, 2 rows" in shown.err + shown.out
    called = call("resume", folder, "--by", "Ada", "--unattended")
    assert called.code == 0, called.err
    resumed = read(folder)
    points = [one.point for one in resumed.events if isinstance(one, Scanned)]
    assert points == [0, 1, 0, 1, 2, 3]
    assert loads(resumed.measurements) == list(LOADS)
    assert len(resumed.recordings) == len(whole.recordings) == 1


def test_run_killed_after_a_scan_sets_the_drive_and_does_not_repeat_it(lab):
    def at(event):
        return isinstance(event, StepStarted) and event.action == "settle"

    folder, whole = interrupted(lab, at)
    shown = call("resume", folder, "--dry-run")
    line = "once more: Set tester.frequency to 5 Hz; Set tester.load to 1000 N, where the scan left"
    assert line in shown.err + shown.out
    called = call("resume", folder, "--by", "Ada", "--unattended")
    assert called.code == 0, called.err
    resumed = read(folder)
    assert resumed.measurements == whole.measurements
    assert [one.point for one in resumed.events if isinstance(one, Scanned)] == [0, 1, 2, 3]
    (record,) = resumed.recordings
    assert record.conditions["tester.load"] == pytest.approx(1000.0, abs=3)
    (resume_at,) = [one for one in resumed.events if isinstance(one, Intervention)]
    assert resume_at.subject.endswith("; rows measured before: 4")
    ends = [one for one in resumed.events if isinstance(one, StepEnded) and one.index == 1]
    assert [one.action for one in ends] == ["scan", "set"]


def test_run_killed_during_a_scan_is_recovered_with_its_points(lab):
    folder, _ = interrupted(lab, lambda event: isinstance(event, Scanned) and event.point == 2)
    called = call("recover", folder, "--by", "Ada", "--reason", "enough")
    assert called.code == 0, called.err
    assert loads(read(folder).measurements) == [100.0, 200.0, 500.0]
    assert "Measured: cell" in call("show", folder).out
    assert call("verify", folder).code == 0


def test_value_out_of_limits_ends_the_run_and_is_its_last_row(lab):
    limited = MAIN + "      limits:\n        tester.load: {max: 300 N}\n"
    procedure = lab.write(HEAD + limited + TEARDOWN)
    called = call("run", procedure, "--station", "simulated", "--unattended", "--runs", lab.runs)
    assert called.code == 1
    assert "at tester.load 500 N (point 3 of 4): tester.load is" in called.err
    assert "(limit: 300 N or less)" in called.err
    stored = lab.last()
    assert loads(stored.measurements) == [100.0, 200.0, 500.0]
    assert stored.info.outcome == "stopped at a limit"


def test_scans_give_the_tables_of_the_paper_with_the_same_digest(lab):
    text = find_procedure("paper_reproduction").read_text(encoding="utf-8")
    sweep = re.compile(
        r"  - sweep: .*\n      set: (.*)\n      over: (.*)\n      steps:\n"
        r"        - measure: \{channels: (.*), name: (.*)\}\n"
    )
    scan = r"  - scan: {set: \1, over: \2, channels: \3, name: \4}" + "\n"
    as_scans, count = sweep.subn(scan, text)
    assert count == 2
    results = []
    for procedure in (text, as_scans):
        words = ("--station", "paper", "--unattended", "--runs", lab.runs, "--json")
        called = call("run", lab.write(procedure), *words)
        assert called.code == 0, called.err
        results.append(
            (json.loads((lab.folder_of(lab.last()) / "result.json").read_text()), lab.last())
        )
    (of_sweeps, sweeps), (of_scans, scans) = results
    assert sweeps.digest == scans.digest
    for result in (of_sweeps, of_scans):
        for key in ("id", "started_utc", "ended_utc", "approval"):
            del result["run"][key]
    assert of_sweeps == of_scans
