"""Calls the command line, in this process or a shell, and keeps what it prints."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

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


def shell(folder: Path, code: str, *programs: Path) -> subprocess.CompletedProcess[str]:
    """Run these lines in bash, with `rigrunner` on the path; each must succeed.

    Programs of other folders come before those of this environment.
    """
    path = os.pathsep.join(map(str, (*programs, Path(sys.executable).parent, os.environ["PATH"])))
    process = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", code],
        cwd=folder,
        env=os.environ | {"PATH": path},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, f"{process.stdout}\n{process.stderr}"
    return process
