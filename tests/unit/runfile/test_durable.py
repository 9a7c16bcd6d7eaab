"""Renaming under Windows, where another program may hold a file for a moment; played here."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from rigrunner.api.errors import DataError
from rigrunner.runfile import durable

HELD = PermissionError(13, "held by another program")


@pytest.fixture
def rename_errors(monkeypatch):
    """Return what is raised, one after the other, by attempts to rename a file."""
    errors = []
    plain = Path.replace

    def replace(self, target):
        if errors:
            raise errors.pop()
        return plain(self, target)

    monkeypatch.setattr(Path, "replace", replace)
    return errors


@pytest.fixture
def waits_s(monkeypatch):
    """Return how long was waited each time, while no time passes."""
    waits = []
    monkeypatch.setattr(durable, "time", SimpleNamespace(sleep=waits.append))
    return waits


def publish(monkeypatch, path, system):
    durable.temporary(path).write_bytes(b"whole")
    monkeypatch.setattr(durable, "os", SimpleNamespace(**{**vars(os), "name": system}))
    durable.publish(path, read_only=False)


def test_on_windows_a_file_that_is_held_for_a_moment_gets_its_name(
    tmp_path, monkeypatch, rename_errors, waits_s
):
    rename_errors.extend([HELD, HELD])
    publish(monkeypatch, tmp_path / "a", "nt")
    assert (tmp_path / "a").read_bytes() == b"whole"
    assert len(waits_s) == 2


@pytest.mark.parametrize(("system", "waits"), [("nt", 5), ("posix", 0)])
def test_what_stays_held_is_an_error_before_long(  # noqa: PLR0917  (fixtures and a table)
    tmp_path, monkeypatch, rename_errors, waits_s, system, waits
):
    rename_errors.extend([HELD] * 10)
    with pytest.raises(PermissionError):
        publish(monkeypatch, tmp_path / "a", system)
    assert not (tmp_path / "a").exists()
    assert len(waits_s) == waits
    assert sum(waits_s) < 2.0


def test_on_windows_ctrl_c_is_not_waited_out(tmp_path, monkeypatch, rename_errors, waits_s):
    rename_errors.append(KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        publish(monkeypatch, tmp_path / "a", "nt")
    assert waits_s == []


def test_a_file_that_cannot_be_written_whole_is_left_as_it_was(tmp_path, monkeypatch):
    report = tmp_path / "report.html"
    durable.write_whole(report, b"first")

    def full(path, _content):
        path.touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(DataError, match=r"cannot write .*: No space left on device"):
        durable.write_whole(report, b"second")
    assert report.read_bytes() == b"first"
    assert list(tmp_path.iterdir()) == [report]


@pytest.mark.skipif(os.name == "nt", reason="Windows syncs folders by itself")
def test_a_file_is_on_the_disk_before_it_gets_its_name_and_its_name_before_it_counts(
    tmp_path, monkeypatch
):
    path, done = tmp_path / "a", []
    durable.temporary(path).write_bytes(b"whole")
    file, folder = durable.temporary(path).stat().st_ino, tmp_path.stat().st_ino
    plain = Path.replace
    monkeypatch.setattr(os, "fsync", lambda number: done.append(os.fstat(number).st_ino))
    monkeypatch.setattr(Path, "replace", lambda self, to: [done.append("rename"), plain(self, to)])
    durable.publish(path, read_only=True)
    assert done == [file, "rename", folder]
    assert path.stat().st_mode & 0o777 == 0o444


def test_an_interrupt_leaves_no_half_written_file_behind(tmp_path, monkeypatch):
    def interrupted(path, _content):
        path.touch()
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_bytes", interrupted)
    with pytest.raises(KeyboardInterrupt):
        durable.write_whole(tmp_path / "report.html", b"second")
    assert list(tmp_path.iterdir()) == []


def test_where_nothing_may_be_written_that_is_told_and_not_that_nothing_was(tmp_path, monkeypatch):
    def refused(_path, _content):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "write_bytes", refused)
    with pytest.raises(
        DataError, match=r"cannot write .*a: Permission denied.*no permission to write"
    ):
        durable.write_whole(tmp_path / "a", b"text")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_what_is_no_file_is_written_to_as_it_is(tmp_path):
    """A pipe of its own: with the code broken, a root would replace a device of the machine."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    durable.write_whole(pipe, b"text")
    assert os.read(reader, 10) == b"text"
    assert pipe.is_fifo()
    os.close(reader)


def test_a_link_that_was_put_in_the_place_of_the_temporary_file_is_not_followed(tmp_path):
    outside, path = tmp_path / "outside", tmp_path / "queue.json"
    outside.write_bytes(b"mine")
    durable.temporary(path).symlink_to(outside)
    durable.write_whole(path, b"new")
    assert (outside.read_bytes(), path.read_bytes()) == (b"mine", b"new")
    assert not path.is_symlink()
