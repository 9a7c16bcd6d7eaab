from __future__ import annotations

import errno
import os
from asyncio import CancelledError

import click
import pytest

from helpers_cli import call
from rigrunner.api.errors import (
    DataError,
    DeviceLostError,
    ExitCode,
    InvalidFileError,
    Location,
    Problem,
    RigrunnerError,
)
from rigrunner.cli.boundary import run_command
from rigrunner.registry import load_registry, with_drop_ins


def command(body):
    return click.Command("test", callback=body)


def raising(error):
    def body():
        raise error

    return command(body)


def test_error_shows_location_message_and_hint(capsys):
    error = DataError("no channel", location=Location("a.yaml", 3, 7), hint="there is tester.angle")
    assert run_command(raising(error), []) == ExitCode.DATA
    captured = capsys.readouterr()
    assert captured.err == "a.yaml:3:7: error: no channel\n  hint: there is tester.angle\n"
    assert captured.out == ""


def test_problems_of_a_file_are_shown_in_line_order(capsys):
    problems = [
        Problem("no unit", Location("a.yaml", 12, 1)),
        Problem(
            "unknown key 'lod'", Location("a.yaml", 3, 7), "main[0].set", "did you mean 'load'?"
        ),
    ]
    assert run_command(raising(InvalidFileError(problems)), []) == ExitCode.INVALID
    assert capsys.readouterr().err.splitlines() == [
        "a.yaml:3:7: error: main[0].set: unknown key 'lod'",
        "  hint: did you mean 'load'?",
        "a.yaml:12:1: error: no unit",
        "2 problems found",
    ]


def test_notes_of_an_error_are_shown(capsys):
    error = DeviceLostError("tester: the line broke")
    error.add_note("tester could not be made safe: time-out")
    assert run_command(raising(error), []) == ExitCode.DEVICE
    assert "note: tester could not be made safe" in capsys.readouterr().err


def test_unexpected_exception_is_a_bug_with_traceback(capsys):
    assert run_command(raising(ZeroDivisionError("oops")), []) == ExitCode.BUG
    err = capsys.readouterr().err
    assert "Traceback" in err
    assert "ZeroDivisionError: oops" in err
    assert "bug" in err


def test_plain_rigrunner_error_has_the_exit_code_of_a_bug():
    assert RigrunnerError("?").exit_code == ExitCode.BUG


def test_ctrl_c_ends_with_130(capsys):
    assert run_command(raising(KeyboardInterrupt()), []) == ExitCode.INTERRUPTED
    assert "Interrupted" in capsys.readouterr().err


@pytest.mark.parametrize("code", [ExitCode.PASS, ExitCode.FAIL, ExitCode.UNDECIDED])
def test_return_value_of_a_command_is_the_exit_code(code):
    assert run_command(command(lambda: code), []) == code


def test_command_that_returns_none_succeeds():
    assert run_command(command(lambda: None), []) == ExitCode.PASS


def test_unknown_command_is_a_usage_error_with_a_suggestion():
    result = call("anlyse")
    assert result.code == ExitCode.USAGE
    assert "Did you mean 'analyse'?" in result.err
    assert result.out == ""


def test_old_command_name_suggests_the_new_one():
    result = call("diff", "a.yaml", "b.yaml")
    assert result.code == ExitCode.USAGE
    assert "'diff' is called 'compare' now" in result.err


def test_unknown_option_is_a_usage_error_with_a_suggestion():
    result = call("runs", "--rnus", "x")
    assert result.code == ExitCode.USAGE
    assert "'--runs'" in result.err


def test_no_command_shows_the_help():
    result = call()
    assert result.code == ExitCode.PASS
    assert result.out == call("--help").out


def test_broken_pipe_of_a_device_is_not_taken_for_a_closed_stdout():
    assert run_command(raising(BrokenPipeError("the device's socket")), []) == ExitCode.BUG


def test_bug_in_a_plugin_names_its_file_and_line(capsys, tmp_path):
    (tmp_path / "press.py").write_text(
        "from rigrunner.api.hooks import FitRecord, hookimpl\n"
        "api_version = 1\n"
        "def make(settings):\n"
        "    return {}['no such key']\n"
        "@hookimpl\n"
        "def rigrunner_fits():\n"
        "    return [FitRecord(name='line', help='', factory=make)]\n"
    )
    registry = with_drop_ins(load_registry([]), tmp_path)
    make_fit = command(lambda: registry.make("fit", "line", {}))
    assert run_command(make_fit, []) == ExitCode.BUG
    *_, last = capsys.readouterr().err.splitlines()
    place = f"{tmp_path / 'press.py'}:4"
    assert last == f"error: this is a bug in the plugin {place}, or in code that it calls"


@pytest.mark.parametrize("error", [SystemExit(0), CancelledError(), GeneratorExit()])
def test_exit_raised_by_a_plugin_is_a_bug(error, capsys):
    """As a compensation could raise one in the middle of an analysis."""
    assert run_command(raising(error), []) == ExitCode.BUG
    assert type(error).__name__ in capsys.readouterr().err


@pytest.mark.parametrize(
    ("number", "code"),
    [
        (errno.ENAMETOOLONG, ExitCode.DATA),
        (errno.EACCES, ExitCode.DATA),
        (errno.EIO, ExitCode.DATA),
        (errno.ENOENT, ExitCode.BUG),
    ],
)
def test_file_that_the_system_refuses_is_named_and_no_bug(capsys, number, code):
    refused = OSError(number, os.strerror(number), "runs/a")
    assert run_command(raising(refused), []) == code
    assert f"error: runs/a: {os.strerror(number)}" in capsys.readouterr().err or code == 70
    assert run_command(raising(OSError(number, "of a socket")), []) == ExitCode.BUG


def test_word_that_is_not_utf_8_is_refused_unless_a_file_has_that_name(tmp_path):
    name = os.fsdecode(b"a\xff")
    result = call("amend", "a.json", "--reason", name)
    assert result.code == ExitCode.USAGE
    assert "the word 'a?' is not UTF-8" in result.err
    file = tmp_path / name
    file.touch()
    assert "UTF-8" not in call("verify", file).err
