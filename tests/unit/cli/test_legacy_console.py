"""Legacy consoles: a character that they lack is replaced, and is never an error."""

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
def test_missing_characters_are_replaced(encoding, shown):
    assert in_encoding("0.7 ± 0.1 N·m ≤ 1 → ä", encoding) == shown


@pytest.mark.parametrize("encoding", first(1, ["ascii", "cp1252"]))
@pytest.mark.parametrize(
    "words",
    [["--help"], ["plan", "--help"], ["plan", "starting_torque_1000n", "--station", "simulated"]],
)
def test_commands_work_on_a_legacy_console(tmp_path, encoding, words):
    legacy = {"PYTHONIOENCODING": encoding, "PYTHONUTF8": "0", "LC_ALL": "C"}
    result = subprocess.run(
        [sys.executable, "-m", "rigrunner", *words],
        cwd=tmp_path, env=os.environ | legacy, capture_output=True, check=False,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr.decode(encoding)
    assert "Traceback" not in result.stderr.decode(encoding)
    assert "N?m" not in result.stdout.decode(encoding)
