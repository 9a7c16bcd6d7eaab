"""A file written by an earlier version of the program stays readable, with all its content.

The expected values were read from the file with h5py alone, when it was added.
"""

from __future__ import annotations

import hashlib
import shutil
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from threading import Event

import h5py
import pytest

from helpers_cli import call
from rigrunner.documents.packing.pack import pack
from rigrunner.documents.packing.unpack import unpack
from rigrunner.jobs import InProcess
from rigrunner.runfile import file_differences, read, read_info, read_summary
from rigrunner_fleet import open_run
from rigrunner_fleet.archive import index, open_archive, query
from rigrunner_fleet.archive.checking import Pace, RunChecker, check

OLD = Path(__file__).parents[2] / "data" / "format-1" / "run.h5"
FILE_SHA256 = "faddef58f4edbbecb3a32353a5f4e0d716b5b81207c06e4a4ff6466da8289cd9"
TORQUE_SHA256 = {
    "001_15Hz": "7c5996451c6d1af5c3b932e5463d29715b425f1376c9cfdcebc91cbab271bc95",
    "002_35Hz": "75b1ccae054835a6f78cc53d62f906a76857bc16c5ae0d0fe85227767b8002af",
}


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "runs" / "20260301T120009Z_SSPB-STT-1000_DEMO-0001"
    folder.mkdir(parents=True)
    shutil.copyfile(OLD, folder / "run.h5")
    return folder


def test_old_file_is_unchanged():
    assert hashlib.sha256(OLD.read_bytes()).hexdigest() == FILE_SHA256
    with h5py.File(OLD) as file:
        assert file.attrs["rigrunner_format"] == 1
        assert "manifest" not in file["entry"]


def test_old_file_has_all_its_content(run):
    stored = read(run)
    assert stored.header.procedure_id == "SSPB-STT-1000"
    assert stored.header.inputs == {"specimen": "DEMO-0001", "operator": "Demo operator"}
    assert stored.info.outcome == "completed"
    torques = {
        recording.name: recording.arrays()["tester.torque"] for recording in stored.recordings
    }
    digests = {name: hashlib.sha256(x.tobytes()).hexdigest() for name, x in torques.items()}
    assert digests == TORQUE_SHA256
    assert stored.partners["no_load"].header.procedure_id == "SSPB-NLI"
    assert len(stored.partners["no_load"].recordings) == 2
    assert stored.result_document["decision"]["verdict"] == "inconclusive"


def test_newer_fields_of_an_old_file_are_empty(run):
    assert read_info(run).manifest_sha256 == ""
    assert file_differences(run / "run.h5") is None
    assert read_summary(run).manifest_sha256 == ""


def test_damaged_samples_of_an_old_file_are_detected(run):
    (run / "run.h5").chmod(0o644)
    with h5py.File(run / "run.h5", "r+") as file:
        file["entry/recordings/001_15Hz/tester_torque"][7] += 1e-9
    result = call("analyse", run)
    assert result.code == 5
    assert "digest" in result.err or "samples" in result.err


def test_old_file_is_shown_and_opened(run):
    assert call("show", run).code == 0
    assert len(open_run(run).recordings) == 2


def test_old_file_is_indexed_checked_packed_and_unpacked(run, tmp_path):
    with closing(open_archive(run.parent)) as archive:
        index(archive, [run.parent])
        look = RunChecker(Pace(), yielding=False)
        assert checked(archive, look) == ()
    (row,) = query(runs=run.parent)
    assert (row["run_id"], row["verdict"], row["manifest_sha256"]) == (
        run.name, "inconclusive", "",
    )  # fmt: skip
    assert pack(run, tmp_path / "old.zip").manifest_sha256 == ""
    unpacked = unpack(tmp_path / "old.zip", tmp_path / "elsewhere")
    assert (unpacked / "run.h5").read_bytes() == OLD.read_bytes()


def checked(archive, look):
    return check(archive, look, InProcess(), Event(), now=lambda: datetime.now(UTC)).findings


def test_newer_file_is_refused_with_both_versions(run):
    (run / "run.h5").chmod(0o644)
    with h5py.File(run / "run.h5", "r+") as file:
        file.attrs.modify("rigrunner_format", 5)
    result = call("analyse", run)
    assert result.code == 5
    assert "format 5, this one reads up to 4" in result.err
