"""Standard streams that are closed, or lead to a full disk."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rigrunner.api.errors import ExitCode

FULL = Path("/dev/full")
FIRST_FREE = 3
OPENS_A_FILE = (
    "import os, sys\n"
    "from rigrunner.cli.main import main\n"
    "main(['--version'])\n"
    "os._exit(os.open(sys.argv[1], os.O_WRONLY | os.O_CREAT))"
)


@pytest.mark.skipif(os.name == "nt", reason="a shell closes them")
def test_file_never_gets_the_descriptor_of_a_closed_stream(tmp_path):
    words = [sys.executable, "-c", OPENS_A_FILE, str(tmp_path / "journal")]
    result = subprocess.run(
        ["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", *words], check=False, timeout=60
    )
    assert result.returncode >= FIRST_FREE


@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")
def test_full_disk_behind_stderr_is_ignored(tmp_path):
    with FULL.open("w") as full:
        result = rigrunner("runs", "--runs", str(tmp_path), stdout=subprocess.PIPE, stderr=full)
    assert result.returncode == ExitCode.PASS


@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")
def test_full_disk_behind_stdout_is_reported():
    with FULL.open("w") as full:
        result = rigrunner("plugins", stdout=full, stderr=subprocess.PIPE)
    assert result.returncode == ExitCode.DATA
    assert "the result cannot be printed: No space left on device" in result.stderr
    assert "Traceback" not in result.stderr


def rigrunner(*arguments: str, **streams) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-m", "rigrunner", *arguments]
    return subprocess.run(words, check=False, text=True, timeout=60, **streams)
