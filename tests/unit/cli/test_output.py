from __future__ import annotations

import io
import json
import subprocess
import sys

import pytest

from rigrunner.cli import output


def test_json_keeps_characters_that_the_stream_supports(capsys):
    output.result_json({"unit": "N·m"})
    printed = capsys.readouterr().out
    assert "N·m" in printed
    assert json.loads(printed) == {"unit": "N·m"}


def test_json_is_valid_on_an_ascii_terminal(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", stream)
    output.result_json({"unit": "N·m"})
    stream.seek(0)
    assert json.loads(stream.read()) == {"unit": "N·m"}


def test_text_is_transliterated_on_an_ascii_terminal(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", stream)
    output.result("0.7 N·m")
    stream.seek(0)
    assert stream.read() == "0.7 N.m\n"


def test_nan_is_refused():
    with pytest.raises(ValueError, match="not JSON compliant"):
        output.result_json({"torque": float("nan")})


def test_closed_stdout_is_no_error():
    code = "from rigrunner.cli.main import main; import sys; sys.exit(main(['--help']))"
    child = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    child.stdout.close()
    with child.stderr as err:
        assert err.read() == b""
    assert child.wait() == 0


@pytest.mark.parametrize(("no_color", "expected"), [("", "\x1b["), ("1", "error:")])
def test_colour_is_used_on_terminals_unless_no_color_is_set(monkeypatch, no_color, expected):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr("sys.stderr", Terminal())
    monkeypatch.setenv("NO_COLOR", no_color)
    assert output.error_label().startswith(expected)


CONTROL = "S1\x1b[2J\x1b[8m\x07\x9b31m\N{RIGHT-TO-LEFT OVERRIDE}1 mN\N{NO-BREAK SPACE}m"
"""As a hostile file may contain: it clears the screen, and hides the text after it."""
SHOWN = "S1�[2J�[8m��31m�1 mN\N{NO-BREAK SPACE}m"


@pytest.mark.parametrize("write", [output.result, output.message, output.prompt])
def test_control_characters_are_replaced_in_text(write, capsys):
    write(CONTROL)
    assert "".join(capsys.readouterr()).removesuffix("\n") == SHOWN


def test_control_characters_are_escaped_in_json(capsys):
    output.result_json({"specimen": CONTROL})
    printed = capsys.readouterr().out
    assert printed.replace("\n", "").isprintable()
    assert json.loads(printed) == {"specimen": CONTROL}


def test_own_colour_is_kept(monkeypatch, capsys):
    monkeypatch.setattr(output, "_colour", lambda _: True)
    output.message(f"{output.error_label()} it is so")
    assert capsys.readouterr().err == "\x1b[31m\x1b[1merror:\x1b[0m it is so\n"
