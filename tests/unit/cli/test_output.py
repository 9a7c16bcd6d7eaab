from __future__ import annotations

import io
import json
import subprocess
import sys

import pytest

from rigrunner.cli import output


def test_json_keeps_letters_that_the_stream_can_take(capsys):
    output.result_json({"unit": "N·m"})
    printed = capsys.readouterr().out
    assert "N·m" in printed
    assert json.loads(printed) == {"unit": "N·m"}


def test_json_is_json_on_an_ascii_terminal(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", stream)
    output.result_json({"unit": "N·m"})
    stream.seek(0)
    assert json.loads(stream.read()) == {"unit": "N·m"}


def test_text_is_printed_on_an_ascii_terminal(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", stream)
    output.result("0.7 N·m")
    stream.seek(0)
    assert stream.read() == "0.7 N.m\n"


def test_a_nan_is_refused():
    with pytest.raises(ValueError, match="not JSON compliant"):
        output.result_json({"torque": float("nan")})


def test_a_reader_that_has_gone_is_no_error():
    code = "from rigrunner.cli.main import main; import sys; sys.exit(main(['--help']))"
    child = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    child.stdout.close()
    with child.stderr as err:
        assert err.read() == b""
    assert child.wait() == 0


@pytest.mark.parametrize(("no_color", "expected"), [("", "\x1b["), ("1", "error:")])
def test_colour_only_on_a_terminal_that_wants_it(monkeypatch, no_color, expected):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr("sys.stderr", Terminal())
    monkeypatch.setenv("NO_COLOR", no_color)
    assert output.error_label().startswith(expected)


STEERING = "S1\x1b[2J\x1b[8m\x07\x9b31m\N{RIGHT-TO-LEFT OVERRIDE}1 mN\N{NO-BREAK SPACE}m"
"""As a stranger's file can have it: it clears the screen, and hides what is written after it."""
SHOWN = "S1�[2J�[8m��31m�1 mN\N{NO-BREAK SPACE}m"


@pytest.mark.parametrize("say", [output.result, output.message, output.prompt])
def test_no_text_of_others_steers_the_terminal(say, capsys):
    say(STEERING)
    assert "".join(capsys.readouterr()).removesuffix("\n") == SHOWN


def test_as_json_it_is_the_same_text_and_steers_nothing(capsys):
    output.result_json({"specimen": STEERING})
    printed = capsys.readouterr().out
    assert printed.replace("\n", "").isprintable()
    assert json.loads(printed) == {"specimen": STEERING}


def test_our_own_colour_stays(monkeypatch, capsys):
    monkeypatch.setattr(output, "_colour", lambda _: True)
    output.message(f"{output.error_label()} it is so")
    assert capsys.readouterr().err == "\x1b[31m\x1b[1merror:\x1b[0m it is so\n"
