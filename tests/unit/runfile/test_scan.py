"""Which folders below a root are runs, and which files tell whether one has changed."""

from __future__ import annotations

import os

import pytest

from rigrunner.runfile.scan import run_folders


@pytest.fixture
def root(tmp_path):
    for name in ("b/sealed", "a", ".hidden/run"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "run.h5").write_bytes(b"12345")
    (tmp_path / "c" / "open" / "journal").mkdir(parents=True)
    (tmp_path / "c" / "empty").mkdir()
    return tmp_path


def test_runs_are_found_at_any_depth_in_order_with_their_files(root):
    runs = list(run_folders(root))
    assert [run.path for run in runs] == ["a", "b/sealed", "c/open"]
    (file,) = runs[0].files
    assert (file.name, file.bytes) == ("run.h5", 5)
    assert file.modified_ns == (root / "a" / "run.h5").stat().st_mtime_ns


def test_the_root_is_no_run_whatever_lies_in_it(root):
    (root / "run.h5").touch()
    assert [folder.path for folder in run_folders(root)] == ["a", "b/sealed", "c/open"]
    assert [folder.path for folder in run_folders(root / "c" / "empty")] == []


def test_links_are_passed_over(root):
    (root / "d").symlink_to(root / "b")
    (root / "a" / "notes").symlink_to(root / "b" / "sealed" / "run.h5")
    runs = list(run_folders(root))
    assert [run.path for run in runs] == ["a", "b/sealed", "c/open"]
    assert [file.name for file in runs[0].files] == ["run.h5"]


def test_a_folder_that_cannot_be_read_is_told_by_its_path(root, monkeypatch):
    plain, unread = os.scandir, []

    def scandir(folder):
        if os.fspath(folder).endswith("b"):
            raise PermissionError(13, "Permission denied")
        return plain(folder)

    monkeypatch.setattr(os, "scandir", scandir)
    runs = run_folders(root, lambda path, why: unread.append((path, why)))
    assert [run.path for run in runs] == ["a", "c/open"]
    assert unread == [("b", "the folder cannot be read: Permission denied")]


def test_a_sealed_run_has_a_stamp_that_changes_with_it_and_another_one_has_none(root):
    (root / "c" / "open" / "notes.txt").touch()
    first, _, unsealed = run_folders(root)
    assert unsealed.stamp == ""
    os.utime(root / "a" / "run.h5", (1, 1))
    assert "" != first.stamp != next(run_folders(root)).stamp
