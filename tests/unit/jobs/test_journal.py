"""What is done survives a kill at any byte, and is never taken for other work."""

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


def test_what_is_added_is_there_when_it_is_opened_again(tmp_path):
    path = tmp_path / "new folder" / "done.jsonl"
    with journal(path, OF) as finished:
        finished.add("a", {"x": pi})
        finished.add("ü\n", [1, None, inf])
        assert "a" in finished
        assert len(finished) == 2
    with journal(path, OF) as again:
        assert again["a"] == {"x": pi}
        assert again["ü\n"] == [1, None, inf]
        assert "b" not in again


def test_a_line_is_on_disk_as_soon_as_it_is_added(tmp_path):
    path = tmp_path / "done.jsonl"
    with journal(path, OF) as begun:
        begun.add("a", 1)
        assert json.loads(path.read_text().splitlines()[-1]) == ["a", 1]


def test_a_disk_that_takes_a_part_of_a_line_is_told(tmp_path, monkeypatch):
    class Full:
        def __init__(self, file):
            self._file = file

        def write(self, text):
            return self._file.write(text[:5])

    path = tmp_path / "done.jsonl"
    with journal(path, OF) as begun:
        begun.add("a", 1)
        monkeypatch.setattr(begun, "_file", Full(begun._file))
        with pytest.raises(DataError, match="No space left"):
            begun.add("b", 2)
        assert "b" not in begun
    assert stored(path) == {"a": 1}


@given(cut=st.integers(0, 200), values=st.lists(st.floats(allow_nan=False), max_size=4))
def test_a_kill_at_any_byte_loses_the_last_line_alone(cut, values, tmp_path_factory):
    path = tmp_path_factory.mktemp("kill") / "done.jsonl"
    with journal(path, OF) as begun:
        for number, value in enumerate(values):
            begun.add(str(number), value)
    text = path.read_bytes()
    path.write_bytes(text[:cut])
    complete = max(text[:cut].count(b"\n") - 1, 0)
    expected = {str(number): value for number, value in enumerate(values[:complete])}
    assert stored(path) == expected
    with journal(path, OF) as going_on:
        going_on.add("further", 1)
    assert stored(path) == {**expected, "further": 1}


def test_other_work_is_refused(tmp_path):
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
def test_what_is_no_journal_is_refused_and_stays_as_it_was(text, tmp_path):
    path = tmp_path / "done.jsonl"
    path.write_text(text)
    with pytest.raises((DataError, UsageError)):
        stored(path, {})
    assert path.read_text() == text


def test_one_process_at_a_time(tmp_path):
    path = tmp_path / "done.jsonl"
    with journal(path, OF), pytest.raises(UsageError, match="in use"), journal(path, OF):
        pass


def test_where_nothing_can_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match="cannot write"):
        stored(tmp_path / "file" / "done.jsonl")


def test_what_is_not_needed_any_more(tmp_path):
    path = tmp_path / "done.jsonl"
    stored(path)
    discard(path)
    discard(path)
    assert not list(tmp_path.iterdir())
