"""The folder that all who use a machine share: what may be in it, and what is refused."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rigrunner.rig_state import folder


def test_ctrl_c_while_the_folder_is_made_is_not_taken_for_none(tmp_path, monkeypatch):
    def interrupted(_path, **_known):
        raise KeyboardInterrupt

    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    monkeypatch.setattr(Path, "mkdir", interrupted)
    with pytest.raises(KeyboardInterrupt):
        folder.shared_folder()


def test_a_file_with_a_second_name_is_refused(tmp_path):
    (tmp_path / "ours").touch()
    (tmp_path / "press.lock").hardlink_to(tmp_path / "ours")
    with pytest.raises(OSError, match="is a link, or no file"):
        folder.open_plain(tmp_path / "press.lock", os.O_RDWR)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes are of POSIX")
def test_what_is_no_file_is_refused(tmp_path):
    os.mkfifo(tmp_path / "press.lock")
    with pytest.raises(OSError, match="is a link, or no file"):
        folder.open_plain(tmp_path / "press.lock", os.O_RDWR)


def test_a_file_that_is_refused_does_not_stay_open(tmp_path, monkeypatch):
    (tmp_path / "ours").touch()
    (tmp_path / "press.lock").hardlink_to(tmp_path / "ours")
    opened, really = [], os.open

    def remembered(*args):
        opened.append(really(*args))
        return opened[-1]

    monkeypatch.setattr(os, "open", remembered)
    with pytest.raises(OSError, match="is a link, or no file"):
        folder.open_plain(tmp_path / "press.lock", os.O_RDWR)
    (descriptor,) = opened
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(descriptor)
