"""Which runs are meant, and what their results are called."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rigrunner.api.errors import UsageError
from rigrunner_fleet.reanalysis.selection import select_runs


@pytest.fixture
def lab(tmp_path):
    for name in ("a/one", "a/two", "b/one", ".hidden/three", "c/deep/er/four"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "run.h5").write_bytes(name.encode())
    (tmp_path / "c" / "notes").mkdir()
    (tmp_path / "unsealed/journal").mkdir(parents=True)
    (tmp_path / "unsealed/journal/events.journal").touch()
    return tmp_path


def names(*paths):
    return [run.name for run in select_runs(paths)]


def test_a_folder_stands_for_all_runs_below(lab):
    assert names(lab) == ["a/one", "a/two", "b/one", "c/deep/er/four", "unsealed"]
    assert names(lab / "a") == ["one", "two"]


def test_a_run_by_its_folder_or_its_file_and_once_though_named_twice(lab):
    assert names(lab / "a/one") == names(lab / "a/one/run.h5") == ["one"]
    assert names(lab / "a/one", lab / "a/one/run.h5", lab / "a") == ["one", "two"]
    assert names(lab / "unsealed") == ["unsealed"]


def test_a_file_that_stands_alone(lab):
    (lab / "SN 17.h5").touch()
    assert names(lab / "SN 17.h5") == ["SN 17"]


def test_paths_are_absolute_for_other_machines(lab, monkeypatch):
    monkeypatch.chdir(lab)
    (only,) = select_runs([type(lab)("b")])
    assert only.path == lab / "b/one"


def test_two_runs_of_one_name_are_refused(lab):
    with pytest.raises(UsageError, match="would have one result, 'one'"):
        select_runs([lab / "a", lab / "b"])


@pytest.mark.parametrize(
    ("path", "words"), [("nowhere", "there is no "), ("c/notes", "there is no run in ")]
)
def test_where_no_run_is(path, words, lab):
    with pytest.raises(UsageError, match=words):
        select_runs([lab / path])


def test_a_stamp_changes_with_the_file_alone(lab):
    (before,) = select_runs([lab / "b"])
    stamp = before.stamp
    (lab / "b/one/report.html").touch()
    assert before.stamp == stamp
    (lab / "b/one/run.h5").write_bytes(b"other")
    assert before.stamp != stamp
    (unsealed,) = select_runs([lab / "unsealed"])
    assert unsealed.stamp == ""


def test_a_folder_that_cannot_be_read_is_listed_and_not_left_out(lab, monkeypatch):
    plain = os.scandir

    def scandir(path):
        if Path(path).name == "a":
            raise PermissionError(13, "Permission denied", str(path))
        return plain(path)

    monkeypatch.setattr(os, "scandir", scandir)
    assert names(lab) == ["a", "b/one", "c/deep/er/four", "unsealed"]
    with pytest.raises(UsageError, match="there is no run in") as caught:
        names(lab / "a")
    assert caught.value.hint == f"not all could be read: {lab / 'a'}"
