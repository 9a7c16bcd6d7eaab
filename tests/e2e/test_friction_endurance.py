"""The shipped endurance test: wear over cycles, and a verdict from the final recordings alone."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from itertools import pairwise

import h5py
import pytest

from e2e.helpers_resume import resume_run
from helpers_cli import call
from rigrunner.api.errors import DataError
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.runfile import read

pytestmark = pytest.mark.thorough

NEW_NM = 0.7262
"""The starting torque of a new bearing of the simulated tester, at 1000 N."""
SHORT = (("block: 50 s", "block: 5 s"), ("at_most: 50", "at_most: 12"),
         ("keep_every: 10", "keep_every: 5"))  # fmt: skip
FAST = ("wear: 6 %", "wear: 150 %")
"""7.5 % in 500 cycles."""


class Lab:
    """A folder with the procedures, the station, and a run without load, which may be given."""

    def __init__(self, folder, changes=(), wear=FAST, no_load=None):
        folder.mkdir(exist_ok=True)
        for name in ("friction_endurance", "starting_torque_1000n", "no_load_inertia_sweep"):
            shutil.copy(find_procedure(name), folder)
        self.folder = folder
        self.procedure = self._edited(folder / "friction_endurance.yaml", changes)
        shutil.copy(find_station("simulated_wear"), folder / "station.yaml")
        self.station = self._edited(folder / "station.yaml", [wear] if wear else [])
        if no_load is None:
            self.run("no_load_inertia_sweep.yaml")
        else:
            shutil.copytree(no_load, folder / "runs")

    def _edited(self, file, changes):
        text = file.read_text(encoding="utf-8")
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        file.write_text(text, encoding="utf-8")
        return file

    def arguments(self, procedure):
        return ["run", self.folder / procedure, "--station", self.station, "--unattended",
                "--runs", self.folder / "runs"]  # fmt: skip

    def run(self, procedure):
        return call(*self.arguments(procedure))

    def run_folder(self):
        (folder,) = (self.folder / "runs").glob("*SSPB-END*")
        return folder

    def document(self):
        return json.loads((self.run_folder() / "result.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def no_load(made_once):
    """A folder with the run without load, of the station on which the bearing wears fast."""
    return made_once("endurance_no_load", lambda folder: Lab(folder / "lab")) / "lab/runs"


@pytest.fixture(scope="module")
def ended(no_load, tmp_path_factory):
    lab = Lab(tmp_path_factory.mktemp("endurance"), SHORT, no_load=no_load)
    called = lab.run("friction_endurance.yaml")
    assert called.code == 0, called.err
    return lab, read(lab.run_folder())


def results(lab, name):
    named = [result for result in lab.document()["results"] if result["name"] == name]
    return {
        result["coordinates"]["cycles"]["value"]: result["estimate"]["value"] for result in named
    }


def test_friction_and_temperature_are_results_over_cycles(ended):
    lab, _ = ended
    friction, temperature = results(lab, "friction"), results(lab, "temperature")
    started = [5.0 + 50 * number for number in range(12)]  # 5 in the ramp to 10 Hz in 1 s
    assert list(friction) == list(temperature) == started
    assert friction[505.0] > 1.01 * friction[5.0]  # the bearing wears by steps of 500 cycles
    assert all(later > before for before, later in pairwise(temperature.values()))


def test_every_fifth_block_is_kept_and_statistics_of_all(ended):
    _, stored = ended
    wear = [
        recording for recording in stored.recordings if recording.coordinates["phase"] == "wear"
    ]
    assert [recording.coordinates["block"] for recording in wear] == [1, 6, 11]
    assert [recording.cycles for recording in wear] == [5, 255, 505]
    rows = [row for row in stored.measurements if row.name == "recorded"]
    assert [row.coordinates["block"] for row in rows] == list(range(1, 13))
    assert [row.cycles for row in rows] == [5 + 50 * number for number in range(12)]


def test_run_without_reaching_a_limit_notes_its_end(ended):
    _, stored = ended
    notes = [getattr(event, "text", "") for event in stored.events]
    assert any(note.endswith("not above 55 °C after all 12 times") for note in notes)
    assert any(note.endswith("not above 2.1 N·m after 12 of 12 times") for note in notes)


def test_run_file_has_the_cycles(ended):
    lab, stored = ended
    with h5py.File(lab.run_folder() / "run.h5") as file:
        table = file["entry/measurements/recorded"]
        assert list(table["cycles"]) == [row.cycles for row in stored.measurements]
        kept = file["entry/recordings/_001_10Hz_wear_block1"]
        assert kept.attrs["cycles"] == 5


def test_verdict_is_from_the_final_recordings_only(ended):
    lab, stored = ended
    document = lab.document()
    final = [
        recording for recording in stored.recordings if recording.coordinates["phase"] == "final"
    ]
    assert len(final) == 12
    used = [point["recording"] for point in document["points"]]
    assert used == [recording.name for recording in final]
    assert document["verdict"]["verdict"] == "pass"
    result = document["decision"]["result"]
    value, u_95 = result["value"], result["expanded_uncertainty_95"]
    assert value == pytest.approx(1.075 * NEW_NM, abs=u_95)
    assert value - NEW_NM > u_95  # a new bearing would differ


def test_report_shows_friction_and_temperature(ended):
    lab, _ = ended
    page = (lab.run_folder() / "report.html").read_text(encoding="utf-8")
    assert "effective torque of the swing" in page
    assert "temperature of the bearing" in page
    assert call("verify", lab.run_folder()).code == 0


def test_run_ended_by_temperature_is_decided(no_load, tmp_path):
    lab = Lab(
        tmp_path / "warm", (*SHORT, ("too_warm: 55 °C", "too_warm: 23.5 °C")), no_load=no_load
    )
    called = lab.run("friction_endurance.yaml")
    assert called.code == 0, called.err
    stored = read(lab.run_folder())
    rows = [row for row in stored.measurements if row.name == "recorded"]
    warm = [row.values["tester.temperature.mean"] - 273.15 for row in rows]
    assert 1 < len(rows) < 12
    assert max(warm) < 23.6
    notes = " ".join(getattr(event, "text", "") for event in stored.events)
    assert f"above 23.5 °C after {len(rows)} of 12 times" in notes
    assert lab.document()["verdict"]["verdict"] == "pass"


def test_run_ended_by_friction_is_decided(no_load, tmp_path):
    lab = Lab(
        tmp_path / "stiff", (*SHORT, ("too_stiff: 2.1 N·m", "too_stiff: 1.88 N·m")), no_load=no_load
    )
    called = lab.run("friction_endurance.yaml")
    assert called.code == 0, called.err
    rows = [row for row in read(lab.run_folder()).measurements if row.name == "recorded"]
    rms_nm = [row.values["tester.torque.rms"] for row in rows]
    assert len(rows) == 11, "the bearing wears by a step at 500 cycles, in the eleventh block"
    assert max(rms_nm[:-1]) < 1.88 < rms_nm[-1]
    notes = " ".join(getattr(event, "text", "") for event in read(lab.run_folder()).events)
    assert "above 1.88 N·m after 11 of 12 times" in notes
    assert lab.document()["verdict"]["verdict"] == "pass"


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kill -9 needs a Unix")
def test_kill_9_loses_no_finished_block(no_load, tmp_path):
    lab = Lab(tmp_path / "killed", (("block: 50 s", "block: 20 s"), ("at_most: 50", "at_most: 30"),
                                    ("keep_every: 10", "keep_every: 5"),
                                    ("too_stiff: 2.1 N·m", "too_stiff: 5 N·m")),
              no_load=no_load)  # fmt: skip
    program = [sys.executable, "-m", "rigrunner", *lab.arguments("friction_endurance.yaml")]
    running = subprocess.Popen(
        list(map(str, program)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        finished_blocks = _finished_blocks(lab, running, at_least=7)
    finally:
        os.kill(running.pid, signal.SIGKILL)
        running.wait()
    interrupted = read(lab.run_folder())
    assert not interrupted.info.sealed
    blocks = [row.coordinates["block"] for row in interrupted.measurements]
    assert blocks[: len(finished_blocks)] == finished_blocks
    assert blocks == list(range(1, len(blocks) + 1))
    assert len(blocks) < 30
    resume_run(lab.run_folder())
    stored = read(lab.run_folder())
    assert stored.info.outcome == "completed"
    rows = [row for row in stored.measurements if row.name == "recorded"]
    assert [row.coordinates["block"] for row in rows] == list(range(1, 31))
    before = {row.coordinates["block"]: row for row in interrupted.measurements}
    for row in rows[: len(blocks)]:
        assert row.values == before[row.coordinates["block"]].values
        assert row.cycles == before[row.coordinates["block"]].cycles
    cycles = [row.cycles for row in rows]
    assert all(later - earlier >= 200 for earlier, later in pairwise(cycles)), cycles
    whole = [recording.coordinates["block"] for recording in stored.recordings
             if recording.coordinates["phase"] == "wear"]  # fmt: skip
    assert whole == [1, 6, 11, 16, 21, 26]
    document = json.loads((lab.run_folder() / "result.json").read_text(encoding="utf-8"))
    assert document["verdict"]["verdict"] in {"pass", "fail"}
    assert call("verify", lab.run_folder()).code == 0


def _finished_blocks(lab, running, at_least):
    """Return the recorded blocks once there are enough of them, while the run continues."""
    until = time.monotonic() + 120
    while time.monotonic() < until:
        assert running.poll() is None, "the run was over too soon"
        time.sleep(0.2)  # reading takes time from the run
        try:
            rows = read(lab.run_folder()).measurements
        except (DataError, ValueError, OSError):
            continue
        if len(rows) >= at_least:
            return [row.coordinates["block"] for row in rows]
    raise AssertionError("the run made no progress")


def test_25_000_cycles(tmp_path):
    lab = Lab(tmp_path / "long", wear=None)
    assert "70.2 MB of samples" in call("plan", lab.procedure, "--station", lab.station).out
    called = lab.run("friction_endurance.yaml")
    assert called.code == 0, called.err
    friction, temperature = results(lab, "friction"), results(lab, "temperature")
    assert list(friction) == [5.0 + 500 * number for number in range(50)]
    assert friction[24505.0] > friction[5.0] + 0.05
    assert temperature[24505.0] == pytest.approx(23 + 18, abs=0.2)
    estimate = lab.document()["decision"]["result"]
    worn_nm = NEW_NM * (1 + 0.06 * 25_000 / 10_000)
    assert estimate["value"] == pytest.approx(worn_nm, abs=estimate["expanded_uncertainty_95"])
    size = sum(path.stat().st_size for path in lab.run_folder().rglob("*") if path.is_file())
    assert size < 50e6
