"""The state: every change is sent once, and the deltas add up to the whole."""

from __future__ import annotations

import json
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner_panel.control import Control, short_name
from rigrunner_panel.errors import PanelError
from rigrunner_panel.view.board import SECTIONS, Board
from rigrunner_panel.view.sections import AnalysingView, Reading, State

NOW = datetime(2026, 3, 1, 12, tzinfo=UTC)

CHANGE = st.one_of(
    st.builds(lambda p: {"phase": p}, st.sampled_from(["idle", "running", "paused"])),
    st.builds(lambda n: {"watchers": n}, st.integers(0, 3)),
    st.builds(
        lambda n: {"analysing": None if n == 0 else AnalysingView(what="x", done=n, of=9)},
        st.integers(0, 3),
    ),
)


@given(st.lists(st.one_of(CHANGE, st.none()), max_size=30))
def test_applying_all_deltas_gives_the_whole_state(changes):
    board = Board()
    shown = json.loads(board.state("me"))
    for change in [*changes, None]:
        if change is not None:
            board.put(**change)
            continue
        delta = board.delta()
        if delta is not None:
            message = json.loads(delta)
            assert message["seq"] == shown["seq"] + 1
            shown |= {**message["changes"], "seq": message["seq"]}
    assert {**shown, "now_utc": ""} == {**json.loads(board.state("me")), "now_utc": ""}


def test_state_matches_the_published_model():
    state = json.loads(Board().state("abc"))
    others = {"seq", "latest", "version", "you", "now_utc"}
    assert set(state) == set(State.model_fields) == {*SECTIONS, *others}
    age = datetime.now(UTC) - datetime.fromisoformat(state["now_utc"])
    assert abs(age) < timedelta(seconds=60)
    State.model_validate(state)


def test_unchanged_values_are_not_sent():
    board, calls = Board(), []
    board.wake = lambda: calls.append(1)
    board.put(phase="idle", readings={})
    assert (calls, board.delta()) == ([], None)
    board.put(phase="running")
    assert json.loads(board.delta())["changes"] == {"phase": "running"}
    assert calls == [1]


def test_non_finite_value_is_null_in_the_state():
    board = Board()
    board.put(readings={"t.load": Reading(value=float("nan"), unit="", shown=0.0, shown_in="")})
    text = board.state("me")
    assert json.loads(text)["readings"]["t.load"]["value"] is None
    assert "NaN" not in text


@pytest.fixture
def control():
    return Control(Board())


def test_second_client_is_refused_with_the_name_in_control(control):
    assert control.take("client-a", "Ann", NOW, take_over=False) is None
    with pytest.raises(PanelError, match="Ann has control") as refused:
        control.take("client-b", "Bob", NOW, take_over=False)
    assert refused.value.status == 409
    with pytest.raises(PanelError, match="Ann has control") as refused:
        control.require("client-b")
    assert (refused.value.status, refused.value.view.code) == (403, "not_in_control")
    assert control.require("client-a") == "Ann"


def test_take_over_returns_the_former_holder(control):
    control.take("client-a", "Ann", NOW, take_over=False)
    assert control.take("client-b", "Bob", NOW, take_over=True).name == "Ann"
    assert control.require("client-b") == "Bob"
    assert control.take("client-b", "Bob B.", NOW, take_over=False) is None  # only a new name
    control.release("client-b")
    with pytest.raises(PanelError, match="nobody has control"):
        control.require("client-b")


def test_state_does_not_reveal_the_id_that_has_control(control):
    control.take("client-a", "Ann", NOW, take_over=False)
    control.count_connection("client-a", 1)
    shown = json.loads(control._board.state("x"))
    assert shown["control"] == {
        "client": short_name("client-a"),
        "name": "Ann",
        "since_utc": "2026-03-01T12:00:00.000Z",
        "connected": True,
    }
    assert "client-a" not in json.dumps(shown)
    control.count_connection("client-a", -1)
    shown = json.loads(control._board.state("x"))
    assert (shown["control"]["connected"], shown["watchers"]) == (False, 0)
