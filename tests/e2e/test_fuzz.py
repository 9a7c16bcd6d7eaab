"""Nearly valid files, and all that ever crashed a reader, are read or refused.

A short form of `python tests/fuzz/fuzz.py`.
"""

import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from helpers_thorough import examples

FUZZ = Path(__file__).resolve().parent.parent / "fuzz"
sys.path.insert(0, str(FUZZ))

from targets import TARGETS, Target  # noqa: E402

import fuzz as fuzzing  # noqa: E402  (the folder is on the path only now)
from fuzz import (  # noqa: E402
    ELSEWHERE,
    GOOD,
    OUTCOMES,
    READ,
    SLOW,
    Reader,
    fuzz,
    measured,
    seeds_of,
    verdict,
)  # fmt: skip

CORPUS = sorted((FUZZ / "corpus").glob("*/*"))
INPUTS = examples(60)


@pytest.fixture(scope="module")
def reader():
    shared_reader = Reader()
    yield shared_reader
    shared_reader.end()


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_nearly_valid_files_are_read_or_refused(reader, target):
    tally = fuzz(reader, target, INPUTS, seed=2)

    assert not tally.crashes
    assert sum(tally.counts.values()) == INPUTS


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_seed_files_are_valid(target, tmp_path):
    seeds = seeds_of(target)

    assert seeds
    for seed in seeds:
        assert verdict(target, seed, tmp_path) == (READ, "")


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_files_that_once_crashed_a_reader_are_refused(path, tmp_path):
    target = next(t for t in TARGETS if t.name.replace(" ", "_") == path.parent.name)

    outcome, where = verdict(target, path.read_bytes(), tmp_path)

    assert outcome in GOOD, where


def test_slow_readers_and_changes_of_other_files_are_faults(tmp_path, monkeypatch):
    def read(path):
        end_s = time.process_time() + float(path.read_text("utf-8"))
        while time.process_time() < end_s:
            pass

    monkeypatch.setattr(fuzzing, "SLOW_S", 0.01)
    target = Target("any", ".txt", lambda _: [], read)
    assert measured(target, b"0", tmp_path, []).outcome == READ
    assert measured(target, b"0.02", tmp_path, []).outcome == SLOW
    assert measured(target, b"0", tmp_path, ["open /x"])[:2] == (ELSEWHERE, "open /x")


def test_changes_of_other_files_and_calls_are_detected(tmp_path):
    """In a separate program: the watch of a process lasts until its end."""
    (tmp_path / "own").mkdir()
    (tmp_path / "link").symlink_to(tmp_path)
    text = """
        import os, socket, subprocess, sys
        from pathlib import Path
        from watch import watch
        os.chdir("own")
        seen = watch(Path("."))
        Path("a").write_text("1", "utf-8")
        Path("a").rename("b")
        Path("b").read_text("utf-8")
        Path("../link").readlink()
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM).connect(("127.0.0.1", 9))
        assert not seen, seen
        Path("../c").write_text("1", "utf-8")
        Path("../link/own/../d").mkdir()
        Path("b").rename("../e")
        subprocess.run([sys.executable, "-V"], stdout=subprocess.DEVNULL)
        try:
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM).connect(("192.0.2.1", 9))
        except OSError:  # without a network
            pass
        kinds = [each.split()[0] for each in seen]
        assert kinds[:3] == ["open", "os.mkdir", "os.rename"], seen
        assert kinds[-1] == "socket.connect" and "subprocess.Popen" in kinds, seen
        """
    lines = "\n".join(line[8:] for line in text.splitlines())
    path = {"PYTHONPATH": str(FUZZ)}
    subprocess.run([sys.executable, "-c", lines], cwd=tmp_path, env=path, check=True)


def test_corpus_is_not_empty():
    assert CORPUS


def test_security_page_has_every_reader_and_no_crash():
    page = (FUZZ.parent.parent / "docs/evidence/security.md").read_text(encoding="utf-8")
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in page.split("## Fuzzing")[1].splitlines()
        if line.startswith("|")
    ]
    assert [row[0] for row in rows[2:]] == [target.name for target in TARGETS]
    for _, files, read, refused, *more in rows[2:]:
        assert int(files) == int(read) + int(refused)
        assert more[: len(OUTCOMES) - 2] == ["0"] * (len(OUTCOMES) - 2)
    cited = re.findall(r"`(tests/[^`]+)`", page)
    assert all((FUZZ.parent.parent / name).exists() for name in cited)
