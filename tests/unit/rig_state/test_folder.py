"""The folder that all users of a machine share, and files in it that are refused."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rigrunner.rig_state import folder


def test_ctrl_c_while_creating_the_folder_is_raised(tmp_path, monkeypatch):
    def interrupted(_path, **_options):
        raise KeyboardInterrupt

    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    monkeypatch.setattr(Path, "mkdir", interrupted)
    with pytest.raises(KeyboardInterrupt):
        folder.shared_folder()


def test_hard_link_is_refused(tmp_path):
    (tmp_path / "ours").touch()
    (tmp_path / "press.lock").hardlink_to(tmp_path / "ours")
    with pytest.raises(OSError, match="is a link, or no file"):
        folder.open_plain(tmp_path / "press.lock", os.O_RDWR)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes are of POSIX")
def test_named_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "press.lock")
    with pytest.raises(OSError, match="is a link, or no file"):
        folder.open_plain(tmp_path / "press.lock", os.O_RDWR)


def test_refused_file_is_closed(tmp_path, monkeypatch):
    (tmp_path / "ours").touch()
    (tmp_path / "press.lock").hardlink_to(tmp_path / "ours")
    opened, real_open = [], os.open

    def recording_open(*args):
        opened.append(real_open(*args))
        return opened[-1]

    monkeypatch.setattr(os, "open", recording_open)
    with pytest.raises(OSError, match="is a link, or no file"):
        folder.open_plain(tmp_path / "press.lock", os.O_RDWR)
    (descriptor,) = opened
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(descriptor)
