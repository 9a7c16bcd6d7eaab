"""The keyboard of Windows, whose `select` knows no console, played by stand-ins."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import pytest

from rigrunner.cli.keyboard import wait_for_line


@pytest.fixture
def windows(monkeypatch):
    keys = []
    console = SimpleNamespace(kbhit=lambda: bool(keys))
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(isatty=lambda: True))
    monkeypatch.setitem(sys.modules, "msvcrt", console)
    return keys


def test_on_windows_the_wait_for_a_key_ends_so_that_the_rig_is_looked_at(windows):
    assert not wait_for_line(0.01)
    windows.append("a")
    assert wait_for_line(0.01)


def test_what_is_piped_in_may_be_read_at_once(monkeypatch):
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(isatty=lambda: False))
    assert wait_for_line(60.0)
