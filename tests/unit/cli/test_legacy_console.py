"""Legacy consoles: a sign that they lack becomes a plain one, and never an error."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from helpers_thorough import first
from rigrunner.cli.output import in_encoding


@pytest.mark.parametrize(
    ("encoding", "shown"),
    [
        ("utf-8", "0.7 ± 0.1 N·m ≤ 1 → ä"),
        (None, "0.7 ± 0.1 N·m ≤ 1 → ä"),
        ("cp1252", "0.7 ± 0.1 N·m <= 1 -> ä"),
        ("ascii", "0.7 +/- 0.1 N.m <= 1 -> ?"),
    ],
)
def test_what_the_console_lacks_is_written_plainly(encoding, shown):
    assert in_encoding("0.7 ± 0.1 N·m ≤ 1 → ä", encoding) == shown


@pytest.mark.parametrize("encoding", first(1, ["ascii", "cp1252"]))
@pytest.mark.parametrize(
    "words",
    [["--help"], ["plan", "--help"], ["plan", "starting_torque_1000n", "--station", "simulated"]],
)
def test_a_legacy_console_is_no_error(tmp_path, encoding, words):
    legacy = {"PYTHONIOENCODING": encoding, "PYTHONUTF8": "0", "LC_ALL": "C"}
    done = subprocess.run(
        [sys.executable, "-m", "rigrunner", *words],
        cwd=tmp_path, env=os.environ | legacy, capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode(encoding)
    assert "Traceback" not in done.stderr.decode(encoding)
    assert "N?m" not in done.stdout.decode(encoding)
