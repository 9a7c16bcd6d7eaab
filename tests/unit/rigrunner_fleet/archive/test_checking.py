"""`archive check` reports every changed file, oldest check first, at a limited rate."""

from __future__ import annotations

import json
import shutil
import threading
from contextlib import closing
from datetime import UTC, datetime, timedelta
from itertools import count

import h5py
import pytest

from helpers_cli import call
from rigrunner.jobs import InProcess
from rigrunner_fleet.archive import index, open_archive, rebuild
from rigrunner_fleet.archive.checking import Pace, RunChecker, check
from unit.rigrunner_fleet.archive.helpers_archive import store_run

START = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)


@pytest.fixture
def archive(runs, database):
    for name in ("a", "b", "c"):
        folder = store_run(runs, name)
        (folder / "run.log").write_text(f"run {name}\n")
    with closing(open_archive(runs, database)) as opened:
        index(opened, [runs])
        yield opened


class Stop:
    """A stop token that is set after this many calls."""

    def __init__(self, calls):
        self.left = calls

    def is_set(self):
        self.left -= 1
        return self.left < 0

    def reason(self):
        raise NotImplementedError


def check_files(archive, *, at=START, stop=None, before=None, pace=None):
    checker = RunChecker(pace or Pace(), yielding=False)
    moments = (at + timedelta(seconds=seconds) for seconds in count())
    return check(
        archive,
        checker,
        InProcess(),
        stop or threading.Event(),
        now=lambda: next(moments),
        before=before,
    )


def findings_of(summary):
    return [(str(finding.kind), finding.path) for finding in summary.findings]


def test_intact_archive_has_no_findings(archive):
    for _ in range(2):
        summary = check_files(archive)
        assert (summary.findings, summary.checked, summary.due) == ((), 3, 3)


def flip(path, at):
    path.chmod(0o644)
    content = bytearray(path.read_bytes())
    content[at] ^= 1
    path.write_bytes(content)


def offset_of_samples(path):
    """Return the offset of a byte in the samples of the recording of a file."""
    with h5py.File(path) as file:
        (recording,) = file["entry/recordings"].values()
        return recording["tester_torque"].id.get_chunk_info(0).byte_offset + 10


@pytest.mark.parametrize("checked_before", [False, True])
def test_each_kind_of_damage_is_reported(archive, runs, checked_before):
    if checked_before:
        assert check_files(archive).findings == ()
    flip(runs / "a/run.h5", offset_of_samples(runs / "a/run.h5"))
    (runs / "b/run.log").write_text("another story\n")
    (runs / "b/letter.txt").write_text("dear")
    shutil.rmtree(runs / "c")
    store_run(runs, "d")
    summary = check_files(archive)
    assert findings_of(summary) == [
        ("damaged", "a/run.h5"),
        ("unknown", "b/letter.txt"),
        ("changed", "b/run.log"),
        ("missing", "c"),
        ("unknown", "d"),
    ]
    assert len(summary.grave) == 3


def test_deleted_files_are_missing(archive, runs):
    (runs / "a/run.log").unlink()
    (runs / "b/run.h5").unlink()
    assert findings_of(check_files(archive)) == [("missing", "a/run.log"), ("missing", "b/run.h5")]


def test_runs_unreadable_at_indexing_are_damaged(archive, runs):
    for name in ("a", "new"):
        (runs / name).mkdir(exist_ok=True)
        (runs / name / "run.h5").unlink(missing_ok=True)
        (runs / name / "run.h5").write_bytes(b"no HDF5")
    index(archive, [runs])
    assert findings_of(check_files(archive)) == [("damaged", "a"), ("damaged", "new")]
    shutil.rmtree(runs / "new")
    index(archive, [runs])
    assert ("missing", "new") in findings_of(check_files(archive))


def test_intact_file_of_another_run_is_changed(archive, runs):
    other = store_run(runs.parent, "other")
    (runs / "a/run.h5").chmod(0o644)
    shutil.copyfile(other / "run.h5", runs / "a/run.h5")
    assert findings_of(check_files(archive)) == [("changed", "a/run.h5")]


def test_any_flipped_bit_is_found_after_a_first_check(archive, runs):
    """Also a bit outside all datasets, which the manifest does not cover."""
    check_files(archive)
    size = (runs / "a/run.h5").stat().st_size
    for at in (size // 7, size // 3, size - 5):
        flip(runs / "a/run.h5", at)
        (finding,) = check_files(archive).findings
        assert finding.path == "a/run.h5"
        flip(runs / "a/run.h5", at)
    assert check_files(archive).findings == ()


def test_next_check_starts_with_the_oldest_checked_runs(archive, runs):
    first = check_files(archive, stop=Stop(2))
    assert (first.checked, first.due) == (2, 3)
    (runs / "c/run.log").unlink()
    second = check_files(archive, at=START + timedelta(hours=1), stop=Stop(1))
    assert findings_of(second) == [("missing", "c/run.log")]
    (runs / "a/run.log").unlink()
    third = check_files(archive, at=START + timedelta(hours=2), stop=Stop(1))
    assert findings_of(third) == [("missing", "a/run.log"), ("missing", "c/run.log")]


def test_recently_checked_runs_are_skipped(archive):
    check_files(archive, stop=Stop(2))
    before = START + timedelta(seconds=0.5)
    later = check_files(archive, at=START + timedelta(days=1), before=before)
    # c was never checked, a at the start, b a second later
    assert (later.checked, later.due) == (2, 2)


def test_rebuilding_does_not_hide_damage(archive, runs):
    check_files(archive)
    flip(runs / "a/run.h5", offset_of_samples(runs / "a/run.h5"))
    rebuild(archive, [runs])
    assert findings_of(check_files(archive)) == [("damaged", "a/run.h5")]


def test_pace_is_kept_without_bursts_after_idle_time():
    clock, slept = [0.0], []

    def sleep(seconds):
        slept.append(seconds)
        clock[0] += seconds

    pace = Pace(1000.0, now=lambda: clock[0], sleep=sleep)
    for _ in range(10):
        pace.take(500)
    assert clock[0] == pytest.approx(5.0)
    clock[0] += 100
    pace.take(500)
    assert slept[-1] == pytest.approx(0.5)


def test_read_bytes_are_the_size_of_the_runs(archive, runs):
    pace = Pace()
    size = sum(path.stat().st_size for path in runs.glob("*/*") if path.name != "run.lock")
    assert check_files(archive, pace=pace).read_bytes == size


@pytest.mark.thorough
def test_archive_check_command(runs):
    store_run(runs, "a")
    command = ["archive", "check", "--runs", runs]
    assert (result := call(*command)).code == 2
    assert "there is no archive" in result.err
    assert call("archive", "index", runs).code == 0
    result = call(*command)
    assert result.code == 0, result.err
    assert result.out.startswith("1 run, ")
    assert result.out.endswith("no file is damaged, missing or changed\n")
    flip(runs / "a/run.h5", offset_of_samples(runs / "a/run.h5"))
    result = call(*command)
    assert (result.code, result.out.startswith("damaged  a/run.h5: ")) == (1, True)
    document = json.loads(call(*command, "--json", "--older", "30 d").out)
    assert (document["runs_due"], document["findings"][0]["kind"]) == (0, "damaged")
    for flags in (["--rate", "fast"], ["--rate", "0 MB/s"], ["--for", "6"], ["--older", "3 N"]):
        result = call(*command, *flags)
        assert (result.code, flags[0] in result.err, "Traceback" in result.err) == (2, True, False)


@pytest.mark.parametrize("option", ["--for", "--older"])
def test_non_positive_times_are_refused(runs, option):
    for time in ("0 s", "-3 d"):
        result = call("archive", "check", "--runs", runs, f"{option}={time}")
        assert result.code == 2
        assert f"{option}: '{time}' is not longer than 0" in result.err
