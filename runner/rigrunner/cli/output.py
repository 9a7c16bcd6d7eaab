"""Where words go: results on stdout, messages on stderr; quiet when the reader has gone."""

from __future__ import annotations

import json
import os
import sys
from typing import TYPE_CHECKING, Any, TextIO

import click

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

UNPRINTABLE = "\N{REPLACEMENT CHARACTER}"


def result(text: str) -> None:
    """Print a line or more of result on stdout."""
    _print(text, sys.stdout)


def result_json(document: Mapping[str, Any] | Sequence[Any]) -> None:
    """Print a document as JSON on stdout; a NaN would not be JSON and is a bug."""
    encodes_all = "utf" in (sys.stdout.encoding or "").lower()
    _print(
        json.dumps(document, indent=2, ensure_ascii=not encodes_all, allow_nan=False), sys.stdout
    )


def message(text: str) -> None:
    """Print a line or more for the person, on stderr."""
    _print(text, sys.stderr)


def printable(text: str) -> str:
    """Return a text of one line or more without what would steer the terminal."""
    return "".join(each if each.isprintable() or each == "\n" else UNPRINTABLE for each in text)


def prompt(question: str) -> None:
    """Print a question on stderr and leave the cursor behind it."""
    _print(question, sys.stderr, end="")


def error_label() -> str:
    """Return the word that begins an error, red on a terminal unless NO_COLOR is set."""
    return click.style("error:", fg="red", bold=True) if _colour(sys.stderr) else "error:"


def reader_has_gone() -> bool:
    """Return True if nobody reads our stdout any more, as in `rigrunner runs | head -1`."""
    try:
        sys.stdout.write("\n")
        sys.stdout.flush()
    except BrokenPipeError:
        return True
    return False


def close_quietly() -> None:
    """Write out what is left; a reader that has gone is no error."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except BrokenPipeError:
            _silence(stream)


def _print(text: str, stream: TextIO, end: str = "\n") -> None:
    encoding = stream.encoding or "utf-8"
    printable = text.encode(encoding, errors="replace").decode(encoding)
    try:
        stream.write(f"{printable}{end}")
        stream.flush()
    except BrokenPipeError:
        _silence(stream)


def _colour(stream: TextIO) -> bool:
    return stream.isatty() and not os.environ.get("NO_COLOR")


def _silence(stream: TextIO) -> None:
    # The interpreter flushes once more when it ends, and would then complain about the pipe.
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
