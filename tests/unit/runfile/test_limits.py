"""Rows with limits in journal and run file, and digests by the version of the layout."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import h5py
import pytest

from rigrunner.api.data import Measurement
from rigrunner.api.events import (
    LimitMissed,
    Outcome,
    RunEnded,
    RunStarted,
    StepEnded,
    StepStarted,
)
from rigrunner.api.limits import ValueLimit
from rigrunner.api.readings import ReadingLimit
from rigrunner.runfile import RunWriter, codec, read, seal
from rigrunner.runfile.measurements import _decisions, measurement_digest
from unit.runfile.helpers_runfile import emitter_of, header_of

OLD = Path(__file__).parents[2] / "data" / "0.1.0" / "table" / "run.h5"
LIMIT = ValueLimit("press.torque", None, 0.5, "N·m", 0.01)
ROW = Measurement(
    "cell", "2026-03-01T12:00:00.000Z", {"press.load": 5.0}, {"press.torque": 0.75},
    {"press.load": "N", "press.torque": "N·m"}, (LIMIT,),
)  # fmt: skip


def sha256(document):
    text = json.dumps(document, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def step(emit, value, limits=(LIMIT,), index=0):
    fields = {"step": f"main[{index}]", "index": index, "action": "measure"}
    units = dict(ROW.units)
    emit(StepStarted, **fields, text="measure", setpoints=ROW.setpoints, units=units, limits=limits)
    ended = {"measurement": "cell", "setpoints": ROW.setpoints, "units": units}
    emit(StepEnded, **fields, ok=True, values={"press.torque": value}, **ended)


def write(folder, *steps):
    with RunWriter(folder, header_of(folder.name)) as writer:
        emit = emitter_of(writer)
        emit(RunStarted, run_id=folder.name, steps=1, estimated_s=1.0)
        for value, limits, index in steps:
            step(emit, value, limits, index)
        emit(LimitMissed, step="main[0]", text="out of limits")
        emit(RunEnded, outcome=Outcome.STOPPED_AT_LIMIT, reason="out of limits")


OF_VERSION_2 = {
    "name": "cell",
    "setpoints": {"press.load": 5.0},
    "units": {"press.load": "N", "press.torque": "N·m"},
    "values": {"press.torque": 0.75},
}
OF_VERSION_3 = {
    **OF_VERSION_2,
    "recording": "",
    "limits": [
        {"of": "press.torque", "minimum": None, "maximum": 0.5, "unit": "N·m", "marginal": 0.01}
    ],
}


@pytest.mark.parametrize(
    ("version", "document"), [(1, OF_VERSION_2), (2, OF_VERSION_2), (3, OF_VERSION_3)]
)
def test_row_digest_depends_on_the_format_version(version, document):
    assert measurement_digest(ROW, version) == sha256(document)


def test_row_digest_covers_expected_readings():
    row = replace(
        ROW,
        readings={"press.door": True},
        expected=(ReadingLimit("press.door", (True,)),),
    )
    document = {
        **OF_VERSION_3,
        "readings": {"press.door": True},
        "expected": [{"of": "press.door", "allowed": [True]}],
    }
    assert measurement_digest(row, 4) == sha256(document)


def test_decisions_of_a_row_are_those_on_values_and_readings():
    row = replace(
        ROW,
        limits=(LIMIT,),
        readings={"press.door": False},
        expected=(ReadingLimit("press.door", (True,)),),
    )
    passes = {name: within for name, (_, within) in _decisions(row).items()}
    assert passes == {"press.torque": False, "press.door": False}


def test_row_out_of_limits_round_trips(tmp_path):
    write(tmp_path / "run", (0.75, (LIMIT,), 0))
    loose = read(tmp_path / "run")
    seal(tmp_path / "run")
    sealed = read(tmp_path / "run")
    for run in (loose, sealed):
        (row,) = run.measurements
        assert (row.values, row.limits) == (ROW.values, ROW.limits)
        assert [decision.passes for decision in row.decisions] == [False]
        assert (run.info.outcome, run.info.format) == ("stopped at a limit", 4)
    assert loose.digest == sealed.digest
    assert sealed.digest == hashlib.sha256(f"{sha256(OF_VERSION_3)}\n".encode()).hexdigest()


def test_superseded_row_is_kept(tmp_path):
    write(tmp_path / "run", (0.75, (LIMIT,), 0), (0.25, (LIMIT,), 0))
    seal(tmp_path / "run")
    run = read(tmp_path / "run")
    assert [row.values["press.torque"] for row in run.measurements] == [0.25]
    assert [row.values["press.torque"] for row in run.superseded_measurements] == [0.75]
    with h5py.File(tmp_path / "run" / "run.h5") as file:
        table = file["entry/superseded_measurements/cell"]
        assert list(table["values/press_torque"][()]) == [0.75]
        assert list(table["passes"][()]) == [0]


def test_run_started_with_an_older_format_keeps_it(tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(codec, "FORMAT", 2)
        write(tmp_path / "run", (0.75, (), 0))
    before = read(tmp_path / "run").digest
    seal(tmp_path / "run")
    run = read(tmp_path / "run")
    assert run.info.format == 2
    assert run.digest == before
    assert run.digest == hashlib.sha256(f"{sha256(OF_VERSION_2)}\n".encode()).hexdigest()
    with h5py.File(tmp_path / "run" / "run.h5") as file:
        assert file.attrs["rigrunner_format"] == 2


def test_embedded_older_run_keeps_its_digest(tmp_path):
    older = read(OLD)
    assert older.info.format == 2
    assert older.measurements
    write(tmp_path / "run", (0.75, (LIMIT,), 0))
    seal(tmp_path / "run", partners={"no_load": OLD})
    run = read(tmp_path / "run")
    assert run.info.format == 4
    assert run.partners["no_load"].info.format == 2
    assert run.partners["no_load"].digest == older.digest


def test_file_has_limits_and_decisions_of_every_row(tmp_path):
    low = ValueLimit("press.torque", 0.125, None, "N·m")
    rows = [(0.75, (LIMIT,)), (0.25, (LIMIT,)), (9.0, ()), (0.5, (low,))]
    write(tmp_path / "run", *[(value, limits, at) for at, (value, limits) in enumerate(rows)])
    seal(tmp_path / "run")
    with h5py.File(tmp_path / "run" / "run.h5") as file:
        table = file["entry/measurements/cell"]
        assert table.attrs["name"] == "cell"
        limits = table["limits/press_torque"]
        assert (limits.attrs["name"], limits.attrs["units"]) == ("press.torque", "N·m")
        nan = float("nan")
        assert limits["minimum"][()].tolist() == pytest.approx([nan, nan, nan, 0.125], nan_ok=True)
        assert limits["maximum"][()].tolist() == pytest.approx([0.5, 0.5, nan, nan], nan_ok=True)
        assert limits["passes"][()].tolist() == [0, 1, -1, 1]
        assert table["passes"][()].tolist() == [0, 1, 1, 1]
