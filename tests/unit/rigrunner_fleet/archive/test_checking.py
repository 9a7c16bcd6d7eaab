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
    """A stop token that is set after it was asked this many times."""

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


def test_nothing_is_wrong_twice(archive):
    for _ in range(2):
        summary = check_files(archive)
        assert (summary.findings, summary.checked, summary.due) == ((), 3, 3)


def flip(path, at):
    path.chmod(0o644)
    content = bytearray(path.read_bytes())
    content[at] ^= 1
    path.write_bytes(content)


def place_of_samples(path):
    """Return where in a file the samples of its recording are."""
    with h5py.File(path) as file:
        (recording,) = file["entry/recordings"].values()
        return recording["tester_torque"].id.get_chunk_info(0).byte_offset + 10


@pytest.mark.parametrize("checked_before", [False, True])
def test_each_kind_of_harm(archive, runs, checked_before):
    if checked_before:
        assert check_files(archive).findings == ()
    flip(runs / "a/run.h5", place_of_samples(runs / "a/run.h5"))
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


def test_a_file_that_is_gone(archive, runs):
    (runs / "a/run.log").unlink()
    (runs / "b/run.h5").unlink()
    assert findings_of(check_files(archive)) == [("missing", "a/run.log"), ("missing", "b/run.h5")]


def test_a_run_that_could_not_be_read_when_it_was_indexed(archive, runs):
    for name in ("a", "new"):
        (runs / name).mkdir(exist_ok=True)
        (runs / name / "run.h5").unlink(missing_ok=True)
        (runs / name / "run.h5").write_bytes(b"no HDF5")
    index(archive, [runs])
    assert findings_of(check_files(archive)) == [("damaged", "a"), ("damaged", "new")]
    shutil.rmtree(runs / "new")
    index(archive, [runs])
    assert ("missing", "new") in findings_of(check_files(archive))


def test_a_whole_file_that_is_another_one(archive, runs):
    other = store_run(runs.parent, "other")
    (runs / "a/run.h5").chmod(0o644)
    shutil.copyfile(other / "run.h5", runs / "a/run.h5")
    assert findings_of(check_files(archive)) == [("changed", "a/run.h5")]


def test_every_flipped_bit_is_told_once_a_file_was_looked_at(archive, runs):
    """Also one in a place that no dataset uses, which the manifest does not cover."""
    check_files(archive)
    size = (runs / "a/run.h5").stat().st_size
    for at in (size // 7, size // 3, size - 5):
        flip(runs / "a/run.h5", at)
        (finding,) = check_files(archive).findings
        assert finding.path == "a/run.h5"
        flip(runs / "a/run.h5", at)
    assert check_files(archive).findings == ()


def test_it_goes_on_where_it_was_and_the_oldest_look_comes_first(archive, runs):
    first = check_files(archive, stop=Stop(2))
    assert (first.checked, first.due) == (2, 3)
    (runs / "c/run.log").unlink()
    second = check_files(archive, at=START + timedelta(hours=1), stop=Stop(1))
    assert findings_of(second) == [("missing", "c/run.log")]
    (runs / "a/run.log").unlink()
    third = check_files(archive, at=START + timedelta(hours=2), stop=Stop(1))
    assert findings_of(third) == [("missing", "a/run.log"), ("missing", "c/run.log")]


def test_runs_that_were_looked_at_since_are_left_out(archive):
    check_files(archive, stop=Stop(2))
    before = START + timedelta(seconds=0.5)
    later = check_files(archive, at=START + timedelta(days=1), before=before)
    # c, never, and a, at the start; b was a second later
    assert (later.checked, later.due) == (2, 2)


def test_what_was_found_is_kept_when_the_index_is_made_anew(archive, runs):
    check_files(archive)
    flip(runs / "a/run.h5", place_of_samples(runs / "a/run.h5"))
    rebuild(archive, [runs])
    assert findings_of(check_files(archive)) == [("damaged", "a/run.h5")]


def test_the_pace_is_kept_and_idle_time_is_not_made_up_for():
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


def test_as_much_is_read_as_there_is(archive, runs):
    pace = Pace()
    size = sum(path.stat().st_size for path in runs.glob("*/*") if path.name != "run.lock")
    assert check_files(archive, pace=pace).read_bytes == size


@pytest.mark.thorough
def test_the_command(runs):
    store_run(runs, "a")
    command = ["archive", "check", "--runs", runs]
    assert (result := call(*command)).code == 2
    assert "there is no archive" in result.err
    assert call("archive", "index", runs).code == 0
    result = call(*command)
    assert result.code == 0, result.err
    assert result.out.startswith("1 run, ")
    assert result.out.endswith("no file is damaged, missing or changed\n")
    flip(runs / "a/run.h5", place_of_samples(runs / "a/run.h5"))
    result = call(*command)
    assert (result.code, result.out.startswith("damaged  a/run.h5: ")) == (1, True)
    document = json.loads(call(*command, "--json", "--older", "30 d").out)
    assert (document["runs_due"], document["findings"][0]["kind"]) == (0, "damaged")
    for wrong in (["--rate", "fast"], ["--rate", "0 MB/s"], ["--for", "6"], ["--older", "3 N"]):
        result = call(*command, *wrong)
        assert (result.code, wrong[0] in result.err, "Traceback" in result.err) == (2, True, False)


@pytest.mark.parametrize("option", ["--for", "--older"])
def test_a_time_of_zero_or_less_is_refused_in_words_that_fit_both_options(runs, option):
    for time in ("0 s", "-3 d"):
        result = call("archive", "check", "--runs", runs, f"{option}={time}")
        assert result.code == 2
        assert f"{option}: '{time}' is not longer than 0" in result.err
