"""The questions at the terminal while a run is paused, and the accepted answers."""

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
def test_clear_answers_are_accepted(monkeypatch, typed, choice, reason):
    decision, _ = decide(monkeypatch, typed)
    assert (decision.choice, decision.reason, decision.by) == (choice, reason, "Ada")


def test_prompt_shows_step_reason_devices_and_choices(monkeypatch, capsys):
    decide(monkeypatch, "maybe\nresume\n")
    output = capsys.readouterr().err
    assert "Paused at main[0].record: pause requested." in output
    assert "press cannot pause: load stays at 1000 N" in output
    assert "skip the rest of main[0].sweep[3], with a reason" in output
    assert "Please answer with one of: resume, repeat, skip, note, abort." in output


def test_only_a_note_leaves_the_run_paused(monkeypatch):
    assert decide(monkeypatch, "note\nhm\n")[1].pause_requested() == "keyboard"
    assert decide(monkeypatch, "resume\n")[1].pause_requested() == ""


def test_end_of_input_aborts_a_paused_run(monkeypatch):
    with pytest.raises(AbortedError, match="no answer"):
        decide(monkeypatch, "")


def test_ctrl_c_pauses_again_once_progress_is_shown_again(monkeypatch):
    stop = SignalStop(attended=True)
    pause_sources = []

    class ShownProgress(LineProgress):
        @contextmanager
        def paused(self):
            yield
            pause_sources.append(stop.pause_requested())

    monkeypatch.setattr("sys.stdin", io.StringIO("resume\n"))
    TerminalPauses(stop, ShownProgress(), "Ada").decide(PAUSED, lambda: None)
    assert pause_sources == [""]
