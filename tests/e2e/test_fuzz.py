"""Nearly good files, and all that ever crashed a reader: read or refused, never worse.

A short form of `python tests/fuzz/fuzz.py`.
"""

import re
import sys
from pathlib import Path

import pytest

FUZZ = Path(__file__).resolve().parent.parent / "fuzz"
sys.path.insert(0, str(FUZZ))

from targets import TARGETS  # noqa: E402

from fuzz import GOOD, READ, Reader, fuzz, seeds_of, verdict  # noqa: E402  (the folder is on the path only now)

CORPUS = sorted((FUZZ / "corpus").glob("*/*"))
INPUTS = 60


@pytest.fixture(scope="module")
def reader():
    made = Reader()
    yield made
    made.end()


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_nearly_good_files_are_read_or_refused(reader, target):
    tally = fuzz(reader, target, INPUTS, seed=2)

    assert not tally.crashes
    assert sum(tally.counts.values()) == INPUTS


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_the_files_to_begin_from_are_good_ones(target, tmp_path):
    seeds = seeds_of(target)

    assert seeds
    for seed in seeds:
        assert verdict(target, seed, tmp_path) == (READ, "")


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_what_once_crashed_a_reader_is_refused(path, tmp_path):
    target = next(each for each in TARGETS if each.name.replace(" ", "_") == path.parent.name)

    outcome, where = verdict(target, path.read_bytes(), tmp_path)

    assert outcome in GOOD, where


def test_the_corpus_is_there():
    assert CORPUS


def test_the_page_on_security_has_every_reader_and_no_crash():
    page = (FUZZ.parent.parent / "docs/evidence/security.md").read_text(encoding="utf-8")
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in page.split("## Fuzzing")[1].splitlines()
        if line.startswith("|")
    ]
    assert [row[0] for row in rows[2:]] == [target.name for target in TARGETS]
    for _, files, read, refused, *bad in rows[2:]:
        assert int(files) == int(read) + int(refused)
        assert bad == ["0", "0", "0"]
    named = re.findall(r"`(tests/[^`]+)`", page)
    assert all((FUZZ.parent.parent / name).exists() for name in named)
