"""Output: results on stdout, messages on stderr; silent if stdout is closed."""

from __future__ import annotations

import json
import os
import re
import sys
from typing import TYPE_CHECKING, Any, TextIO

import click

from rigrunner.api.errors import DataError
from rigrunner.printable import printable

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

_AGREES = {"y": True, "yes": True, "n": False, "no": False}
_ERROR = "error:"
_RED = click.style(_ERROR, fg="red", bold=True)
_WARNING = "WARNING:"
_RED_WARNING = click.style(_WARNING, fg="red", bold=True)
_LABELS = re.compile(f"({re.escape(_RED)}|{re.escape(_RED_WARNING)})")
"""The escape sequences that the program itself writes."""
_PLAIN = {
    "·": ".",
    "±": "+/-",
    "≤": "<=",
    "≥": ">=",
    "…": "...",
    "→": "->",
    "²": "^2",
    "³": "^3",
    "°": "deg ",
    "µ": "u",
    "Ω": "ohm",
    "ω": "omega",
    "φ": "phi",
    "\N{MULTIPLICATION SIGN}": "x",
    "\N{MINUS SIGN}": "-",
    "\N{EN DASH}": "-",
    "\N{GREEK SMALL LETTER MU}": "u",
    "\N{GREEK SMALL LETTER SIGMA}": "sigma",
    "\N{GREEK SMALL LETTER ALPHA}": "alpha",
    "\N{GREEK SMALL LETTER NU}": "nu",
}
"""Replacements of characters that a legacy console lacks; a unit must stay readable."""


def result(text: str) -> None:
    """Print lines of a result on stdout; raise DataError if they cannot be written."""
    try:
        _print(text, sys.stdout)
    except OSError as error:
        _silence(sys.stdout)
        raise DataError(
            f"the result cannot be printed: {error.strerror or error}",
            hint="the command itself was carried out; check the destination of its output",
        ) from error


def result_json(document: Mapping[str, Any] | Sequence[Any]) -> None:
    """Print a document as JSON on stdout. A NaN, which JSON does not have, is a bug."""
    encodes_all = "utf" in (sys.stdout.encoding or "").lower()
    text = json.dumps(document, indent=2, ensure_ascii=not encodes_all, allow_nan=False)
    if text != printable(text):  # escaped it is the same document
        text = json.dumps(document, indent=2, allow_nan=False)
    result(text)


def message(text: str, *, end: str = "\n") -> None:
    """Print lines for the person on stderr; drop them if they cannot be written.

    A full disk behind it must not end a run that is otherwise good.
    """
    try:
        _print(text, sys.stderr, end)
    except OSError:
        _silence(sys.stderr)


def unsafe_rig(problems: str) -> str:
    """Return the message on a rig that could not be made safe."""
    return f"THE RIG IS NOT SAFE: {problems}. Stop it by its own switch."


def no_time_limits() -> str:
    """Return the message that calls of devices have no time limits, red like a warning of a rig."""
    return (
        f"{warning_label()} time limits are suspended for a debugger: no call of a device is given"
        " up, and a device that hangs is not made safe. Watch the rig."
    )


def yes_or_no(ask: Callable[[str], str], question: str) -> bool:
    """Ask until the answer is yes or no; there is no default."""
    while (answer := ask(f"{question} [yes/no] ").lower()) not in _AGREES:
        message("Please answer yes or no.")
    return _AGREES[answer]


def prompt(question: str) -> None:
    """Print a question on stderr and leave the cursor after it."""
    message(question, end="")


def error_label() -> str:
    """Return the label of an error, red on a terminal unless NO_COLOR is set."""
    return _RED if _colour(sys.stderr) else _ERROR


def warning_label() -> str:
    """Return the label of a warning of a rig, red like that of an error."""
    return _RED_WARNING if _colour(sys.stderr) else _WARNING


def stdout_is_closed() -> bool:
    """Return whether stdout is no longer read, as when it is piped into `head`."""
    try:
        sys.stdout.write("\n")
        sys.stdout.flush()
    except BrokenPipeError:
        return True
    return False


def close_quietly() -> None:
    """Flush the output. A closed pipe is no error."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            _silence(stream)


def in_encoding(text: str, encoding: str | None) -> str:
    """Return a text as a console of that encoding can show it: 'N.m' where it has no 'N·m'."""
    encoding = encoding or "utf-8"
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        shown = "".join(_in_plain(sign, encoding) for sign in text)
        return shown.encode(encoding, errors="replace").decode(encoding)
    return text


def _in_plain(sign: str, encoding: str) -> str:
    try:
        sign.encode(encoding)
    except UnicodeEncodeError:
        return _PLAIN.get(sign, sign)
    return sign


def _print(text: str, stream: TextIO, end: str = "\n") -> None:
    try:
        parts = _LABELS.split(text)  # every second part is one of our labels
        parts[::2] = map(printable, parts[::2])
        shown = "".join(parts)
        stream.write(f"{in_encoding(shown, stream.encoding)}{end}")
        stream.flush()
    except BrokenPipeError:
        _silence(stream)


def _colour(stream: TextIO) -> bool:
    return stream.isatty() and not os.environ.get("NO_COLOR")


def _silence(stream: TextIO) -> None:
    # The interpreter flushes again when it ends, and would then complain about the pipe.
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
