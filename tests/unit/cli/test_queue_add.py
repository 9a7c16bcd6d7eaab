"""The list of specimens of `queue add`."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from rigrunner.api.errors import DataError
from rigrunner.cli.commands.queue.add import LONGEST_FILE, _text

LINE = "SN-123456\n"
LONGEST = LINE * (LONGEST_FILE // len(LINE))


def test_list_of_maximum_length_is_read_from_stdin(monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO(LONGEST))
    assert _text(Path("-")) == LONGEST


@pytest.mark.parametrize("name", ["-", "list.txt"])
def test_too_long_list_is_refused(monkeypatch, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    Path("list.txt").write_text(LONGEST + LINE, encoding="utf-8")
    monkeypatch.setattr("sys.stdin", io.StringIO(LONGEST + LINE))
    with pytest.raises(DataError, match=f"{name} is longer than 1000000 bytes"):
        _text(Path(name))
