"""What a person at the terminal is asked while a run is paused, and which answers are taken."""

from __future__ import annotations

import io
from contextlib import contextmanager

import pytest

from rigrunner.api.errors import AbortedError
from rigrunner.cli.pausing import TerminalPauses
from rigrunner.cli.progress import LineProgress
from rigrunner.cli.stopping import SignalStop
from rigrunner.engine import Choice, Paused

PAUSED = Paused(
    "main[0].record",
    "main[0].sweep[3]",
    "pause requested",
    ("press cannot pause: load stays at 1000 N",),
    (Choice.RESUME, Choice.REPEAT, Choice.SKIP, Choice.NOTE, Choice.ABORT),
)


def decide(monkeypatch, typed: str):
    stop = SignalStop(attended=True)
    monkeypatch.setattr("sys.stdin", io.StringIO(typed))
    decision = TerminalPauses(stop, LineProgress(), "Ada").decide(PAUSED, lambda: None)
    return decision, stop


@pytest.mark.parametrize(
    ("typed", "choice", "reason"),
    [
        ("resume\n", Choice.RESUME, ""),
        ("RES\n", Choice.RESUME, ""),
        ("\nre\nrep\n", Choice.REPEAT, ""),
        ("skip\n\n\nit squeals\n", Choice.SKIP, "it squeals"),
        ("note\noil on it\n", Choice.NOTE, "oil on it"),
        ("note\nli\N{RIGHT-TO-LEFT OVERRIDE}o\n\x1b[8m\noil\n", Choice.NOTE, "oil"),
        ("override\nabort\n", Choice.ABORT, ""),
    ],
)
def test_an_answer_is_taken_when_it_is_clear(monkeypatch, typed, choice, reason):
    decision, _ = decide(monkeypatch, typed)
    assert (decision.choice, decision.reason, decision.by) == (choice, reason, "Ada")


def test_all_that_matters_is_said(monkeypatch, capsys):
    decide(monkeypatch, "maybe\nresume\n")
    output = capsys.readouterr().err
    assert "Paused at main[0].record: pause requested." in output
    assert "press cannot pause: load stays at 1000 N" in output
    assert "skip the rest of main[0].sweep[3], with a reason" in output
    assert "Please answer with one of: resume, repeat, skip, note, abort." in output


def test_a_note_leaves_the_run_paused_and_other_answers_do_not(monkeypatch):
    assert decide(monkeypatch, "note\nhm\n")[1].pause_requested() == "keyboard"
    assert decide(monkeypatch, "resume\n")[1].pause_requested() == ""


def test_where_the_input_has_ended_the_run_does(monkeypatch):
    with pytest.raises(AbortedError, match="no answer"):
        decide(monkeypatch, "")


def test_once_the_progress_is_seen_again_ctrl_c_pauses_again(monkeypatch):
    stop = SignalStop(attended=True)
    seen = []

    class Shown(LineProgress):
        @contextmanager
        def paused(self):
            yield
            seen.append(stop.pause_requested())

    monkeypatch.setattr("sys.stdin", io.StringIO("resume\n"))
    TerminalPauses(stop, Shown(), "Ada").decide(PAUSED, lambda: None)
    assert seen == [""]
