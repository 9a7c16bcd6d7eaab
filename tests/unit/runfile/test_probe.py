from __future__ import annotations

import pytest

from helpers_runfile import TWO, write_run
from rigrunner.api.errors import DataError
from rigrunner.runfile import probe, refuse_crashing


def test_a_run_and_what_is_none_are_left_to_the_reader(tmp_path):
    refuse_crashing(write_run(tmp_path / "run", TWO).seal())
    (tmp_path / "text.h5").write_text("hello")
    refuse_crashing(tmp_path / "text.h5")


@pytest.mark.parametrize(
    ("child", "said"),
    [
        (
            "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)",
            r"crashes on it \(exit code -11",
        ),
        ("while True: pass", "does not end"),
    ],
)
def test_what_would_take_this_process_along_is_told(tmp_path, monkeypatch, child, said):
    (tmp_path / "x.h5").write_bytes(b"")
    monkeypatch.setattr(probe, "_CHILD", child)
    monkeypatch.setattr(probe, "_LEAST_S", 1.0)
    with pytest.raises(DataError, match=said):
        refuse_crashing(tmp_path / "x.h5")
