"""The journal of finished items survives a kill at any byte, and is bound to its task."""

from __future__ import annotations

import json
from math import inf, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.errors import DataError, UsageError
from rigrunner.jobs import discard, journal

OF = {"study": "coverage", "seed": "1"}


def stored(path, task=OF):
    with journal(path, task) as finished:
        return dict(finished._values)


def test_added_items_are_there_after_reopening(tmp_path):
    path = tmp_path / "new folder" / "done.jsonl"
    with journal(path, OF) as finished:
        finished.add("a", {"x": pi})
        finished.add("ü\n", [1, None, inf])
        assert "a" in finished
        assert len(finished) == 2
    with journal(path, OF) as reopened:
        assert reopened["a"] == {"x": pi}
        assert reopened["ü\n"] == [1, None, inf]
        assert "b" not in reopened


def test_added_line_is_on_disk_at_once(tmp_path):
    path = tmp_path / "done.jsonl"
    with journal(path, OF) as finished:
        finished.add("a", 1)
        assert json.loads(path.read_text().splitlines()[-1]) == ["a", 1]


def test_partly_written_line_is_an_error(tmp_path, monkeypatch):
    class Full:
        def __init__(self, file):
            self._file = file

        def write(self, text):
            return self._file.write(text[:5])

    path = tmp_path / "done.jsonl"
    with journal(path, OF) as finished:
        finished.add("a", 1)
        monkeypatch.setattr(finished, "_file", Full(finished._file))
        with pytest.raises(DataError, match="No space left"):
            finished.add("b", 2)
        assert "b" not in finished
    assert stored(path) == {"a": 1}


@given(cut=st.integers(0, 200), values=st.lists(st.floats(allow_nan=False), max_size=4))
def test_kill_at_any_byte_loses_only_the_last_line(cut, values, tmp_path_factory):
    path = tmp_path_factory.mktemp("kill") / "done.jsonl"
    with journal(path, OF) as finished:
        for number, value in enumerate(values):
            finished.add(str(number), value)
    text = path.read_bytes()
    path.write_bytes(text[:cut])
    complete = max(text[:cut].count(b"\n") - 1, 0)
    expected = {str(number): value for number, value in enumerate(values[:complete])}
    assert stored(path) == expected
    with journal(path, OF) as reopened:
        reopened.add("further", 1)
    assert stored(path) == {**expected, "further": 1}


def test_journal_of_another_task_is_refused(tmp_path):
    path = tmp_path / "done.jsonl"
    stored(path)
    with (
        pytest.raises(UsageError, match="has results of other work: seed was 1, is 2"),
        journal(path, {**OF, "seed": "2"}),
    ):
        pass
    assert stored(path) == {}


@pytest.mark.parametrize(
    "text",
    [
        "no json\n",
        '"text"\n',
        '{"of": {}}\n7\n',
        '{}\n["a", 1]\n',
        '{"of": 3}\n',
        '{"format": "rigrunner: done/2", "of": {}}\n',
        "a,b\n1,2",
        "a,b",
    ],
)
def test_file_that_is_no_journal_is_refused_unchanged(text, tmp_path):
    path = tmp_path / "done.jsonl"
    path.write_text(text)
    with pytest.raises((DataError, UsageError)):
        stored(path, {})
    assert path.read_text() == text


def test_journal_is_locked(tmp_path):
    path = tmp_path / "done.jsonl"
    with journal(path, OF), pytest.raises(UsageError, match="in use"), journal(path, OF):
        pass


def test_journal_that_cannot_be_written_is_a_data_error(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match="cannot write"):
        stored(tmp_path / "file" / "done.jsonl")


def test_discard_removes_the_journal_and_may_be_repeated(tmp_path):
    path = tmp_path / "done.jsonl"
    stored(path)
    discard(path)
    discard(path)
    assert not list(tmp_path.iterdir())
