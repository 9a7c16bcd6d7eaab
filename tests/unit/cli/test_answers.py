from __future__ import annotations

import io
import os
import signal
from contextlib import contextmanager

import pytest

from rigrunner.api.errors import AbortedError
from rigrunner.api.quantity import parse_quantity
from rigrunner.cli.answers import TerminalAnswers
from rigrunner.cli.progress import LineProgress
from rigrunner.cli.stopping import stop_on_signals
from rigrunner.procedure.answers import Expected
from rigrunner.steps.ask import Ask
from rigrunner.steps.confirm import Confirm

GUARDS = Confirm("Guards closed?", unattended=True)
SERIAL = Ask("Serial number", "specimen", "DEMO-0001")


@contextmanager
def person(monkeypatch, typed):
    monkeypatch.setattr("sys.stdin", typed if hasattr(typed, "readline") else io.StringIO(typed))
    with stop_on_signals() as stop:
        yield TerminalAnswers(stop, LineProgress())


@pytest.mark.parametrize(("typed", "answer"), [("yes\n", True), ("Y\n", True), ("no\n", False)])
def test_confirmation_accepts_yes_or_no(monkeypatch, typed, answer):
    with person(monkeypatch, typed) as answers:
        assert answers.confirm("setup[0]", GUARDS) is answer


def test_empty_or_unclear_confirmation_is_asked_again(monkeypatch, capsys):
    with person(monkeypatch, "\nperhaps\nno\n") as answers:
        assert answers.confirm("setup[0]", GUARDS) is False
    captured = capsys.readouterr()
    assert captured.err.count("Please answer yes or no.") == 2
    assert captured.out == ""


def test_unattended_answer_is_not_offered_to_the_operator(monkeypatch, capsys):
    with person(monkeypatch, "\nSN-17\n") as answers:
        assert answers.ask("inputs", SERIAL) == "SN-17"
    assert "DEMO" not in capsys.readouterr().err


def test_end_of_input_aborts_the_run_and_suggests_unattended(monkeypatch):
    with person(monkeypatch, "") as answers, pytest.raises(AbortedError, match="--unattended"):
        answers.confirm("setup[0]", GUARDS)


class SignalInsteadOfAnswer:
    def readline(self):
        os.kill(os.getpid(), signal.SIGTERM)
        return "yes\n"


def test_signal_during_a_question_aborts_the_run(monkeypatch):
    stopped = pytest.raises(AbortedError, match="SIGTERM")
    with person(monkeypatch, SignalInsteadOfAnswer()) as answers, stopped:
        answers.confirm("setup[0]", GUARDS)


def test_question_shows_limits_and_picture_and_repeats_after_wrong_answers(monkeypatch, capsys):
    expected = Expected(unit="°C", maximum=parse_quantity("30 °C"))
    room = Ask("Room", "room", "23 °C", picture="lab/gauge.png", expected=expected)
    with person(monkeypatch, "warm\n23,5\n31\n24\n") as answers:
        assert answers.ask("main[0]", room) == "24 °C"
    output = capsys.readouterr().err
    assert "See the picture lab/gauge.png" in output
    assert output.count("Room [in °C, 30 °C or less]: ") == 4
    assert "Please answer again: 'warm' is not a number with a unit" in output
    assert "write '23.5'" in output
    assert "31 °C is out of range (30 °C or less)" in output


def test_choice_ignores_case(monkeypatch, capsys):
    side = Ask("Side", "side", None, expected=Expected(("Left", "Right")))
    with person(monkeypatch, "l\nleft\n") as answers:
        assert answers.ask("main[0]", side) == "Left"
    assert "Side [Left / Right]: " in capsys.readouterr().err


def test_confirmation_shows_its_picture(monkeypatch, capsys):
    with person(monkeypatch, "yes\n") as answers:
        answers.confirm("main[0]", Confirm("As shown?", unattended=None, picture="lab/rig.png"))
    assert "See the picture lab/rig.png" in capsys.readouterr().err
