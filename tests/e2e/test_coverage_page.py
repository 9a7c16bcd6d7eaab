"""The page of the coverage study has the population of the code, and tables of one study."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from helpers_population import HEADER, law_rows, population_rows
from rigrunner.study.coverage_case import limits
from rigrunner.study.coverage_plots import FIGURES
from rigrunner.study.coverage_rigs import FREQUENCIES_HZ, torque_instrument
from rigrunner.study.coverage_table import ROW_HEADER, held_text
from rigrunner.study.share import Share
from rigrunner.study.tools import tools

pytestmark = pytest.mark.figures

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "reference/coverage.md").read_text(encoding="utf-8")


def rows_after(words):
    """Return the first table after these words."""
    table = re.search(r"(?:^\|.*\n)+", PAGE.split(words, 1)[1], re.MULTILINE)
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[0].splitlines()]


def test_the_population_is_that_of_the_code():
    header, _, *rows = rows_after("## The rigs")
    assert header == list(HEADER)
    assert rows == population_rows(torque_instrument(tools().station), limits())
    assert f"at {', '.join(f'{f:g}' for f in FREQUENCIES_HZ)} Hz" in PAGE


def test_the_laws_are_those_of_the_code():
    assert rows_after("follows one of these laws")[2:] == law_rows()


def test_every_figure_is_there():
    for name in FIGURES:
        assert f"../images/{name}.svg" in PAGE
        assert (DOCS / f"images/{name}.svg").exists()


@pytest.mark.parametrize("title", ["Errors in mN·m, and how", "By the bearing's law"])
def test_intervals_of_runs_belong_to_their_counts(title):
    header, _, *rows = rows_after(f"### {title}")
    assert header == list(ROW_HEADER)
    for row in rows:
        rigs = int(re.search(r"\((\d+)\)", row[1])[1])
        rate = float(row[-1].split(" %")[0]) / 100
        assert held_text(Share(round(rate * rigs), rigs)) == row[-1]
