"""The one place where errors of commands become a text and an exit code."""

from __future__ import annotations

import errno
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.api.errors import ExitCode, InvalidFileError, Problem, RigrunnerError, UsageError
from rigrunner.api.texts import name_of, refused_character
from rigrunner.cli.output import (
    close_quietly,
    error_label,
    message,
    stdout_is_closed,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

_NO_BUG = {
    *(errno.EACCES, errno.EPERM, errno.EROFS, errno.EIO, errno.ENOSPC, errno.EDQUOT),
    *(errno.ENAMETOOLONG, errno.ESTALE),
}
"""What the system answers for a file that it does not let this user, or anybody, have."""


def run_command(command: click.Command, arguments: Sequence[str] | None = None) -> int:
    """Call the command, show its error on stderr, and return the exit code."""
    try:
        return _invoke(command, sys.argv[1:] if arguments is None else list(arguments))
    except RigrunnerError as error:
        show_error(error)
        return error.exit_code
    except click.ClickException as error:
        message(f"{error_label()} {error.format_message()}")
        context = getattr(error, "ctx", None)
        if context is not None:
            things = "commands" if isinstance(context.command, click.Group) else "options"
            message(f"  hint: '{context.command_path} --help' lists the {things}")
        return ExitCode.USAGE
    except (KeyboardInterrupt, click.Abort):
        message("Interrupted.")
        return ExitCode.INTERRUPTED
    except BaseException as error:  # noqa: BLE001  (a bug; also the exit that a plugin asks for)
        if isinstance(error, OSError) and error.filename and error.errno in _NO_BUG:
            message(f"{error_label()} {error.filename}: {error.strerror}")
            return ExitCode.DATA
        show_bug(error)
        return ExitCode.BUG
    finally:
        close_quietly()


def _invoke(command: click.Command, arguments: list[str]) -> int:
    _check_printable(arguments)
    # Not `command.main`: when stdout is closed it ends with 1, which means a failed verdict here.
    try:
        with command.make_context("rigrunner", arguments) as context:
            return int(command.invoke(context) or ExitCode.PASS)
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except BrokenPipeError:
        if stdout_is_closed():
            return ExitCode.PASS
        raise


def _check_printable(arguments: list[str]) -> None:
    """Raise UsageError for an argument with characters that cannot be displayed.

    Only the name of an existing file need not be UTF-8: it has one half of a surrogate pair.
    """
    for argument in arguments:
        readable = argument.encode("utf-8", "replace").decode()
        if readable != argument and not Path(argument).exists():
            raise UsageError(
                f"the word '{readable[:40]}' is not UTF-8",
                hint="set the terminal to UTF-8 and type it again",
            )
        refused = refused_character(readable)
        if refused:
            raise UsageError(
                f"the word '{readable[:40]}' has the character {name_of(refused[0])}",
                hint="type it again: the copied text contains an invisible character",
            )


def show_error(error: RigrunnerError) -> None:
    """Print an error with its place, its hint and all its problems, on stderr."""
    if isinstance(error, InvalidFileError):
        problems = sorted(error.problems, key=_place)
    else:
        problems = [Problem(error.message, error.location, hint=error.hint)]
    for problem in problems:
        where = f"{problem.location}: " if problem.location else ""
        field = f"{problem.field}: " if problem.field else ""
        message(f"{where}{error_label()} {field}{problem.message}")
        if problem.hint:
            message(f"  hint: {problem.hint}")
    if len(problems) > 1:
        message(f"{len(problems)} problems found")
    for note in getattr(error, "__notes__", ()):
        message(f"  note: {note}")


def _place(problem: Problem) -> tuple[str, int, int]:
    where = problem.location
    return (where.file, where.line or 0, where.column or 0) if where else ("", 0, 0)


def show_bug(error: BaseException) -> None:
    """Print an unexpected error with its traceback, on stderr."""
    message("".join(traceback.format_exception(error)).rstrip())
    from rigrunner.registry import culprit  # noqa: PLC0415  (of use for a bug alone)

    plugin = culprit(error)
    if plugin:
        message(f"{error_label()} this is a bug in the plugin {plugin}, or in code that it calls")
    else:
        message(
            f"{error_label()} this is a bug in Rigrunner or in a plugin; the lines above say where"
        )
