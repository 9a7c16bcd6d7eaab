from __future__ import annotations

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


def command_that(body):
    return click.Command("test", callback=body)


def raising(error):
    def body():
        raise error

    return command_that(body)


def test_an_error_shows_place_message_and_hint(capsys):
    error = DataError("no channel", location=Location("a.yaml", 3, 7), hint="there is tester.angle")
    assert run_command(raising(error), []) == ExitCode.DATA
    captured = capsys.readouterr()
    assert captured.err == "a.yaml:3:7: error: no channel\n  hint: there is tester.angle\n"
    assert captured.out == ""


def test_all_problems_of_a_file_are_shown_in_its_order(capsys):
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


def test_a_second_error_stands_beside_the_first(capsys):
    error = DeviceLostError("tester: the line broke")
    error.add_note("tester could not be made safe: time-out")
    assert run_command(raising(error), []) == ExitCode.DEVICE
    assert "note: tester could not be made safe" in capsys.readouterr().err


def test_anything_else_is_a_bug_with_its_traceback(capsys):
    assert run_command(raising(ZeroDivisionError("oops")), []) == ExitCode.BUG
    err = capsys.readouterr().err
    assert "Traceback" in err
    assert "ZeroDivisionError: oops" in err
    assert "bug" in err


def test_an_error_of_no_known_kind_is_a_bug():
    assert RigrunnerError("?").exit_code == ExitCode.BUG


def test_ctrl_c_ends_with_130(capsys):
    assert run_command(raising(KeyboardInterrupt()), []) == ExitCode.INTERRUPTED
    assert "Interrupted" in capsys.readouterr().err


@pytest.mark.parametrize("code", [ExitCode.PASS, ExitCode.FAIL, ExitCode.UNDECIDED])
def test_what_a_command_returns_is_the_exit_code(code):
    assert run_command(command_that(lambda: code), []) == code


def test_a_command_that_returns_nothing_has_succeeded():
    assert run_command(command_that(lambda: None), []) == ExitCode.PASS


def test_an_unknown_command_is_a_usage_error_with_a_suggestion():
    called = call("anlyse")
    assert called.code == ExitCode.USAGE
    assert "Did you mean 'analyse'?" in called.err
    assert called.out == ""


def test_an_old_name_of_a_command_is_answered_with_the_new_one():
    called = call("diff", "a.yaml", "b.yaml")
    assert called.code == ExitCode.USAGE
    assert "'diff' is called 'compare' now" in called.err


def test_an_unknown_option_is_a_usage_error_with_a_suggestion():
    called = call("runs", "--rnus", "x")
    assert called.code == ExitCode.USAGE
    assert "'--runs'" in called.err


def test_without_a_command_the_help_is_shown():
    called = call()
    assert called.code == ExitCode.PASS
    assert called.out == call("--help").out


def test_a_broken_pipe_of_a_device_is_not_taken_for_a_reader_that_has_gone():
    assert run_command(raising(BrokenPipeError("the device's socket")), []) == ExitCode.BUG


def test_a_bug_in_a_plugin_names_its_file_and_line(capsys, tmp_path):
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
    body = command_that(lambda: registry.make("fit", "line", {}))
    assert run_command(body, []) == ExitCode.BUG
    *_, last = capsys.readouterr().err.splitlines()
    place = f"{tmp_path / 'press.py'}:4"
    assert last == f"error: this is a bug in the plugin {place}, or in code that it calls"


@pytest.mark.parametrize("error", [SystemExit(0), CancelledError(), GeneratorExit()])
def test_an_exit_that_a_plugin_asks_for_is_a_bug_not_a_success(error, capsys):
    """As one that a compensation raises in the middle of an analysis."""
    assert run_command(raising(error), []) == ExitCode.BUG
    assert type(error).__name__ in capsys.readouterr().err
