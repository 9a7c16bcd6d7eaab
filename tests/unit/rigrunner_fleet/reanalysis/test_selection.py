"""Selection of runs, and the names of their results."""

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


def test_folder_selects_all_runs_below(lab):
    assert names(lab) == ["a/one", "a/two", "b/one", "c/deep/er/four", "unsealed"]
    assert names(lab / "a") == ["one", "two"]


def test_run_named_twice_is_selected_once(lab):
    assert names(lab / "a/one") == names(lab / "a/one/run.h5") == ["one"]
    assert names(lab / "a/one", lab / "a/one/run.h5", lab / "a") == ["one", "two"]
    assert names(lab / "unsealed") == ["unsealed"]


def test_single_file_is_named_by_its_stem(lab):
    (lab / "SN 17.h5").touch()
    assert names(lab / "SN 17.h5") == ["SN 17"]


def test_selected_paths_are_absolute(lab, monkeypatch):
    monkeypatch.chdir(lab)
    (run,) = select_runs([Path("b")])
    assert run.path == lab / "b/one"


def test_runs_with_the_same_name_are_refused(lab):
    with pytest.raises(UsageError, match="would have one result, 'one'"):
        select_runs([lab / "a", lab / "b"])


@pytest.mark.parametrize(
    ("path", "message"), [("nowhere", "there is no "), ("c/notes", "there is no run in ")]
)
def test_paths_without_runs_are_refused(path, message, lab):
    with pytest.raises(UsageError, match=message):
        select_runs([lab / path])


def test_stamp_depends_only_on_the_run_file(lab):
    (before,) = select_runs([lab / "b"])
    stamp = before.stamp
    (lab / "b/one/report.html").touch()
    assert before.stamp == stamp
    (lab / "b/one/run.h5").write_bytes(b"other")
    assert before.stamp != stamp
    (unsealed,) = select_runs([lab / "unsealed"])
    assert unsealed.stamp == ""


def test_unreadable_folder_is_listed(lab, monkeypatch):
    original = os.scandir

    def scandir(path):
        if Path(path).name == "a":
            raise PermissionError(13, "Permission denied", str(path))
        return original(path)

    monkeypatch.setattr(os, "scandir", scandir)
    assert names(lab) == ["a", "b/one", "c/deep/er/four", "unsealed"]
    with pytest.raises(UsageError, match="there is no run in") as caught:
        names(lab / "a")
    assert caught.value.hint == f"not all could be read: {lab / 'a'}"
