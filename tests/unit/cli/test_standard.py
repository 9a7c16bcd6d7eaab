"""Standard streams that are closed, or lead to a full disk, neither spoil nor end anything."""

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
def test_a_file_does_not_get_the_number_of_a_stream_that_was_closed(tmp_path):
    words = [sys.executable, "-c", OPENS_A_FILE, str(tmp_path / "journal")]
    ended = subprocess.run(
        ["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", *words], check=False, timeout=60
    )
    assert ended.returncode >= FIRST_FREE


@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")
def test_a_full_disk_behind_the_messages_ends_nothing(tmp_path):
    with FULL.open("w") as full:
        ended = rigrunner("runs", "--runs", str(tmp_path), stdout=subprocess.PIPE, stderr=full)
    assert ended.returncode == ExitCode.PASS


@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")
def test_a_full_disk_behind_the_result_is_told():
    with FULL.open("w") as full:
        ended = rigrunner("plugins", stdout=full, stderr=subprocess.PIPE)
    assert ended.returncode == ExitCode.DATA
    assert "the result cannot be printed: No space left on device" in ended.stderr
    assert "Traceback" not in ended.stderr


def rigrunner(*arguments: str, **streams) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-m", "rigrunner", *arguments]
    return subprocess.run(words, check=False, text=True, timeout=60, **streams)
