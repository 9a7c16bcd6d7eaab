"""Coordinates and elapsed time in journal and run file, and in the digests."""

from __future__ import annotations

import hashlib
import json
from datetime import timedelta
from pathlib import Path

import h5py
import numpy as np
import pytest

from rigrunner.api.data import Block, Measurement
from rigrunner.api.events import Outcome, RunEnded, RunStarted, Samples, StepEnded, StepStarted
from rigrunner.bus import Bus, Emitter
from rigrunner.clock import SimulatedClock
from rigrunner.runfile import RunWriter, read, seal
from rigrunner.runfile.digest import RecordingDigest
from rigrunner.runfile.measurements import measurement_digest
from unit.runfile.helpers_runfile import START, header_of

OLD = Path(__file__).parents[2] / "data" / "0.1.0" / "table" / "run.h5"
COORDINATES = {"phase": "wear", "dwell": 60.0, "aged": True, "block": 3}
UNITS = {"dwell": "s"}


def write(folder, coordinates=COORDINATES):
    """Write a set-up step of 5 s, then a recording of 2 s and a row at its end."""
    clock = SimulatedClock(START)
    with RunWriter(folder, header_of(folder.name)) as writer:
        emit = Emitter(Bus([writer]), clock)
        emit(RunStarted, run_id=folder.name, steps=3, estimated_s=1.0)
        fields = {"step": "setup[0]", "index": 0, "action": "wait"}
        emit(StepStarted, **fields, text="wait")
        clock.sleep(5)
        emit(StepEnded, **fields, ok=True)
        here = {"coordinates": coordinates, "units": {"t.x": "N", **UNITS}}
        fields = {"step": "main[0]", "index": 1, "action": "record", "recording": "001"}
        emit(StepStarted, **fields, text="record", **here)
        emit(Samples, recording="001", block=Block(1.0, 0, 0.0, {"t.x": np.zeros(2)}))
        clock.sleep(2)
        emit(StepEnded, **fields, ok=True)
        fields = {"step": "main[1]", "index": 2, "action": "measure"}
        emit(StepStarted, **fields, text="measure", **here)
        emit(StepEnded, **fields, ok=True, measurement="m", values={"t.x": 1.0}, units={"t.x": "N"})
        emit(RunEnded, outcome=Outcome.COMPLETED)


@pytest.fixture(params=["loose", "sealed"])
def run(tmp_path, request):
    write(tmp_path / "run")
    if request.param == "sealed":
        seal(tmp_path / "run")
    return read(tmp_path / "run")


def test_they_come_back_as_they_were(run):
    for item in (*run.recordings, *run.measurements):
        assert item.coordinates == COORDINATES
        assert {name: type(value) for name, value in item.coordinates.items()} == {
            "phase": str, "dwell": float, "aged": bool, "block": int,
        }  # fmt: skip
        assert item.units["dwell"] == "s"


def test_time_counts_from_the_beginning_of_main(run):
    assert run.recordings[0].elapsed_s == 0.0
    assert run.measurements[0].elapsed_s == 2.0


def test_before_main_no_time_has_elapsed(tmp_path):
    clock = SimulatedClock(START)
    with RunWriter(tmp_path / "run", header_of("run")) as writer:
        emit = Emitter(Bus([writer]), clock)
        fields = {"step": "setup[0]", "index": 0, "action": "measure"}
        emit(StepStarted, **fields, text="measure")
        emit(StepEnded, **fields, ok=True, measurement="m", values={"t.x": 1.0}, units={"t.x": "N"})
        clock.sleep(5)
        emit(StepStarted, step="main[0]", index=1, action="wait", text="wait")
    (row,) = read(tmp_path / "run").measurements
    assert row.elapsed_s is None


def test_a_row_of_the_very_moment_at_which_main_began_has_a_time(tmp_path):
    """It is read before it is known when that was."""
    with RunWriter(tmp_path / "run", header_of("run")) as writer:
        emit = Emitter(Bus([writer]), SimulatedClock(START))
        fields = {"step": "setup[0]", "index": 0, "action": "measure"}
        emit(StepStarted, **fields, text="measure")
        emit(StepEnded, **fields, ok=True, measurement="m", values={"t.x": 1.0}, units={"t.x": "N"})
        emit(StepStarted, step="main[0]", index=1, action="wait", text="wait")
    (row,) = read(tmp_path / "run").measurements
    assert row.elapsed_s == 0.0


def test_time_goes_on_while_a_run_is_interrupted(tmp_path):
    """The clock of another process begins again; the date and time do not."""
    write(tmp_path / "run")
    with RunWriter(tmp_path / "run") as writer:
        emit = Emitter(Bus([writer]), SimulatedClock(START + timedelta(hours=1)), 20)
        fields = {"step": "main[2]", "index": 3, "action": "measure"}
        emit(StepStarted, **fields, text="measure")
        emit(StepEnded, **fields, ok=True, measurement="m", values={"t.x": 1.0}, units={"t.x": "N"})
    assert read(tmp_path / "run").measurements[-1].elapsed_s == 3595.0


def test_the_digest_of_a_recording_covers_them():
    digest = RecordingDigest("001", 1.0, {}, {"t.x": "N"}, {"block": 3})
    digest.update({"t.x": np.zeros(2)})
    document = {
        "channels": {"t.x": hashlib.sha256(bytes(16)).hexdigest()},
        "coordinates": {"block": 3},
        "name": "001",
        "rate_hz": 1.0,
        "setpoints": {},
        "units": {"t.x": "N"},
    }
    text = json.dumps(document, sort_keys=True, separators=(",", ":"))
    assert digest.hexdigest() == hashlib.sha256(text.encode()).hexdigest()


def test_runs_with_other_coordinates_have_other_digests(tmp_path):
    digests = set()
    for number, coordinates in enumerate(({}, COORDINATES, {**COORDINATES, "block": 4})):
        write(tmp_path / f"run{number}", coordinates)
        digests.add(read(tmp_path / f"run{number}").digest)
    assert len(digests) == 3


def test_a_row_of_before_has_the_digest_of_before():
    row = Measurement("m", "", {}, {"t.x": 1.0}, {"t.x": "N"})
    text = (
        '{"limits":[],"name":"m","recording":"","setpoints":{},"units":{"t.x":"N"},'
        '"values":{"t.x":1.0}}'
    )
    assert measurement_digest(row, 4) == hashlib.sha256(text.encode()).hexdigest()


def test_an_old_file_has_none():
    run = read(OLD)
    assert run.measurements
    assert all(not item.coordinates for item in (*run.recordings, *run.measurements))
    assert all(measurement.elapsed_s is not None for measurement in run.measurements)


def test_viewers_find_attributes_and_columns(tmp_path):
    write(tmp_path / "run")
    seal(tmp_path / "run")
    with h5py.File(tmp_path / "run" / "run.h5") as file:
        recording = file["entry/recordings/_001"]
        assert recording.attrs["elapsed_s"] == 0.0
        assert recording["coordinates/dwell"].attrs["value"] == 60.0
        assert recording["coordinates/dwell"].attrs["units"] == "s"
        assert recording["coordinates/phase"].attrs["value"] == "wear"
        table = file["entry/measurements/m"]
        assert list(table["elapsed"]) == [2.0]
        assert list(table["coordinates/phase"]) == [b"wear"]
        assert list(table["coordinates/aged"]) == [b"yes"]
        assert list(table["coordinates/block"]) == [3]
        assert table["coordinates/dwell"].attrs["units"] == "s"


def test_a_coordinate_that_was_changed_is_found(tmp_path):
    write(tmp_path / "run")
    seal(tmp_path / "run")
    path = tmp_path / "run" / "run.h5"
    path.chmod(0o644)
    with h5py.File(path, "r+") as file:
        file["entry/recordings/_001/coordinates/block"].attrs["value"] = np.int64(4)
    with pytest.raises(Exception, match="not what was recorded"):
        read(path)
