"""Calls the command line in this process and keeps what it prints."""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass

from rigrunner.cli.main import main


@dataclass(frozen=True)
class Called:
    """How a command ended and what it printed."""

    code: int
    out: str
    err: str


def call(*arguments: str) -> Called:
    """Run `rigrunner` with these arguments, with pipes for a terminal."""
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        code = main([str(argument) for argument in arguments])
    return Called(code, out.getvalue(), err.getvalue())
