"""The performance page has every benchmark, and the versions of a full run."""

import re

from benchmarks.command import SHORT, names
from benchmarks.machine import ROOT
from benchmarks.page import BEGIN, END, stored

PAGE = ROOT / "docs" / "evidence" / "performance.md"


def tables():
    return PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]


def test_page_has_every_benchmark():
    """If not, run `python -m tests.benchmarks NAME --markdown docs/evidence/performance.md`."""
    assert list(stored(tables())) == names()


def test_page_states_the_versions_of_a_full_run():
    head = tables().partition("\n## ")[0]
    assert re.match(r"\nMeasured 20.* UTC: commit [0-9a-f]+.*, Python 3\.", head)
    assert "numpy" in head
    assert "HDF5" in head
    assert SHORT not in head
    assert "Failed:" not in tables()
