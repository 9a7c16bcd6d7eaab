"""The lock of a run's folder: only one process writes to it."""

from __future__ import annotations

from pathlib import Path

import pytest
from filelock import FileLock

from rigrunner.api.errors import DataError
from rigrunner.runfile import lock
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.lock import is_in_progress, run_lock


def test_run_is_in_progress_while_its_lock_is_held(tmp_path):
    assert is_in_progress(tmp_path) is False
    assert not RunFolder(tmp_path).lock.exists()
    with run_lock(tmp_path):
        assert is_in_progress(tmp_path) is True
    assert is_in_progress(tmp_path) is False


def test_unreadable_lock_counts_as_free_but_ctrl_c_passes(tmp_path, monkeypatch):
    RunFolder(tmp_path).lock.touch()

    def failing(error):
        def acquire(*_, **__):
            raise error

        return acquire

    monkeypatch.setattr(FileLock, "acquire", failing(PermissionError(13, "denied")))
    assert is_in_progress(tmp_path) is False
    monkeypatch.setattr(FileLock, "acquire", failing(KeyboardInterrupt()))
    with pytest.raises(KeyboardInterrupt):
        is_in_progress(tmp_path)


def test_second_process_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "PATIENCE_S", 0.01)
    with (
        run_lock(tmp_path),
        pytest.raises(DataError, match="is still running"),
        run_lock(tmp_path),
    ):
        pass


def test_ctrl_c_while_waiting_for_a_lock_is_raised(tmp_path, monkeypatch):
    def interrupted(_lock):
        raise KeyboardInterrupt

    monkeypatch.setattr(FileLock, "acquire", interrupted)
    with pytest.raises(KeyboardInterrupt), run_lock(tmp_path):
        pass


def test_lock_is_released_on_a_disk_that_does_not_answer(tmp_path, monkeypatch):
    def fail(_path):
        raise OSError(5, "Input/output error")

    with monkeypatch.context() as patched, run_lock(tmp_path):
        patched.setattr(Path, "exists", fail)
    assert is_in_progress(tmp_path) is False
