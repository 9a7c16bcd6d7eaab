"""A list of specimens is read completely, or refused."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from rigrunner.api.errors import DataError
from rigrunner.cli.commands.queue.add import LONGEST_FILE, _text

LINE = "SN-123456\n"
LONGEST = LINE * (LONGEST_FILE // len(LINE))


def test_a_list_on_stdin_is_taken_up_to_the_length_that_is_allowed(monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO(LONGEST))
    assert _text(Path("-")) == LONGEST


@pytest.mark.parametrize("name", ["-", "list.txt"])
def test_a_list_that_is_too_long_is_refused_and_not_cut(monkeypatch, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    Path("list.txt").write_text(LONGEST + LINE, encoding="utf-8")
    monkeypatch.setattr("sys.stdin", io.StringIO(LONGEST + LINE))
    with pytest.raises(DataError, match=f"{name} is longer than 1000000 bytes"):
        _text(Path(name))
