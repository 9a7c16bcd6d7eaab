"""Which events of a run are reported, and their texts."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rigrunner.api.events import Answer, Intervention, MadeSafe, Prompt, StepStarted
from rigrunner_plugins.listeners import messages
from rigrunner_plugins.listeners.messages import DISK_EVERY_S, Rules
from rigrunner_plugins.listeners.settings import RuleSettings
from unit.rigrunner_plugins.listeners.helpers_listeners import (
    alarm,
    ended,
    event,
    finished,
    planned,
    run_events,
)


@pytest.fixture(autouse=True)
def disk(monkeypatch):
    """The free space, in 10⁹ bytes."""
    space = SimpleNamespace(gb=100.0)
    usage = lambda _: SimpleNamespace(free=space.gb * 1e9)  # noqa: E731  (shorter so)
    monkeypatch.setattr(messages.shutil, "disk_usage", usage)
    return space


def messages_of(events, **settings):
    rules = Rules(RuleSettings(**settings))
    return [message for event in events for message in rules.take(event)]


def test_end_of_a_run_is_reported_once_with_its_verdict(tmp_path):
    messages = messages_of(run_events(tmp_path))
    assert [message.kind for message in messages] == ["alarm", "run_ended"]
    assert messages[1].title == "rig-1: run ended (completed, pass) - SN-042"
    assert messages[1].document()["verdict"] == "pass"
    assert messages[0].text == "interlock hot: too hot"
    assert "Run: R1" in messages[0].body


def test_run_cut_off_after_its_end_is_reported_without_a_verdict():
    rules = Rules(RuleSettings())
    assert not list(rules.take(ended()))
    (last,) = rules.last()
    assert (last.kind, last.outcome, last.verdict) == ("run_ended", "completed", "")
    assert not list(rules.last())


def test_only_configured_kinds_are_reported(tmp_path):
    (message,) = messages_of(run_events(tmp_path), on=["run_ended"])
    assert message.kind == "run_ended"
    assert messages_of([alarm()], on=["disk_low"]) == []


STEP = {"step": "main[0]", "index": 0, "action": "set", "text": "Set"}


@pytest.mark.parametrize(
    "end",
    [
        event(Answer, step="s", text="yes", by="Ann"),
        event(Intervention, action="abort", by="Ann"),
        event(StepStarted, **STEP),
        ended(),
    ],
)
def test_prompt_waits_until_it_is_answered_or_obsolete(end):
    rules = Rules(RuleSettings())
    assert not list(rules.take(event(Prompt, step="main[0]", text="Is the guard closed?")))
    assert rules.waiting.text == "The run waits for an answer: Is the guard closed? (main[0])"
    assert [message.kind for message in rules.take(alarm())] == ["alarm"]
    assert rules.waiting is not None
    list(rules.take(end))
    assert rules.waiting is None


def test_pause_waits_for_a_person_like_a_prompt():
    rules = Rules(RuleSettings())
    list(rules.take(event(Intervention, action="pause", by="interlock heat", reason="too hot")))
    assert rules.waiting.kind == "waits_for_answer"
    assert rules.waiting.text == "The run is paused by interlock heat: too hot"


def test_only_instruments_due_soon_are_named(tmp_path):
    due = {"load cell": "2026-12-07", "meter": "2026-12-08", "clock": "2026-11-22"}
    (message,) = messages_of([planned(tmp_path, due=due)])
    assert message.kind == "calibration_due"
    assert message.text == (
        "clock: calibration was due on 2026-11-22\nload cell: calibration is due on 2026-12-07"
    )


def test_low_disk_space_is_reported_once_until_there_was_space_again(disk, tmp_path):
    now = SimpleNamespace(s=0.0)
    rules = Rules(RuleSettings(disk_low_gb=5.0), lambda: now.s)
    list(rules.take(planned(tmp_path)))
    kinds = []
    for free_gb in (100.0, 4.9, 4.0, 100.0, 4.0):
        disk.gb, now.s = free_gb, now.s + DISK_EVERY_S
        messages = list(rules.take(event(Answer, step="s", text="t", by="b")))
        kinds.append([message.text for message in messages if message.kind == "disk_low"])
    assert kinds == [
        [],
        ["4.9 GB are free for runs, less than 5 GB"],
        [],
        [],
        ["4.0 GB are free for runs, less than 5 GB"],
    ]


def test_unsafe_device_is_reported_as_an_alarm():
    (message,) = messages_of([event(MadeSafe, what="tester", problems=("no answer",))])
    assert (message.kind, message.text) == ("alarm", "tester may not be safe: no answer")
    assert messages_of([event(MadeSafe, what="tester")]) == []


def test_failed_listener_is_not_reported_by_listeners():
    failed = event(messages.Alarm, source="event sink", text="mail failed and was dropped")
    assert messages_of([failed]) == []


def test_line_break_in_a_specimen_does_not_split_the_subject(tmp_path):
    hostile = planned(tmp_path, inputs={"specimen": "SN\r\nBcc: all@example.org"})
    message = messages_of([hostile, finished()])[-1]
    assert "\n" not in message.title
    assert "\r" not in message.title
