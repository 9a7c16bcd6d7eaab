"""Waiting for input, with stand-ins for the Windows console, which `select` does not support."""

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


def test_wait_for_a_key_times_out_on_windows(windows):
    assert not wait_for_line(0.01)
    windows.append("a")
    assert wait_for_line(0.01)


def test_piped_input_is_ready_at_once(monkeypatch):
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(isatty=lambda: False))
    assert wait_for_line(60.0)
