"""The page of the checks says what the code does, and its tables come from the study."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rigrunner_bearings.compensations.checks import BUILD_UP
from rigrunner_bearings.compensations.checks import LIMITS as METHOD_LIMITS
from rigrunner_bearings.study.breaks import BREAKS, REFUSED
from rigrunner_bearings.study.diagnostics_rigs import CYCLES, FREQUENCIES_HZ, POPULATIONS
from rigrunner_bearings.study.diagnostics_table import (
    ALARM_HEADER,
    BREAK_HEADER,
    NOTHING,
    share_text,
)
from rigrunner_bearings.study.share import Share
from rigrunner_bearings.torque import consistency
from rigrunner_bearings.torque.checks import LIMITS
from rigrunner_bearings.torque.one_setup import LIMITS as SETUP_LIMITS

AGREEMENT = (consistency.NAME, "at most the Birge ratio of 1 % chance")
CHECKS = (
    *((each.name, each.allowed) for each in LIMITS),
    AGREEMENT,
    *((each.name, each.allowed) for each in (*SETUP_LIMITS, *METHOD_LIMITS)),
)
APART = {consistency.NAME, "torque that grows with speed", BUILD_UP.name}
"""Newer than the study of false alarms, or skipped on its stations, as the page says."""
DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "evidence/diagnostics.md"


def rows_of(title, page=PAGE):
    section = page.read_text(encoding="utf-8").split(f"# {title}\n")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_every_check_is_listed_with_its_limit():
    rows = rows_of("Checks of a run", DOCS / "reference/diagnostics.md")[2:]
    assert [(row[0], row[1]) for row in rows] == list(CHECKS)


def test_every_check_has_its_rate_of_false_alarms():
    header, _, *rows = rows_of("False alarms")
    assert header == list(ALARM_HEADER)
    assert {row[0] for row in rows} == {name for name, _ in CHECKS} - APART


def test_every_break_is_listed_as_the_code_has_it():
    header, _, *rows = rows_of("Broken rigs")
    assert header == list(BREAK_HEADER)
    expected = [(each.name, each.extent, each.seen_by or NOTHING) for each in BREAKS]
    assert [tuple(row[:3]) for row in rows] == expected


def test_every_break_that_no_check_sees_is_explained():
    listed = {row[0]: row[1] for row in rows_of("What no check sees")[2:]}
    assert listed == {each.name: each.unseen for each in BREAKS if not each.seen_by}


def test_the_population_is_that_of_the_code():
    listed = [tuple(row) for row in rows_of("The rigs")[2:]]
    expected = [
        (simulator, each.setting, f"{each.low:g}", f"{each.high:g}", _unit(each))
        for simulator, ranges in POPULATIONS.items()
        for each in ranges
    ]
    assert listed == expected
    text = PAGE.read_text(encoding="utf-8")
    assert f"{CYCLES} cycles at {', '.join(f'{f:g}' for f in FREQUENCIES_HZ)} Hz" in text


def _unit(each):
    return f"times {each.times}" if each.times else each.unit


@pytest.mark.parametrize("title", ["False alarms", "Broken rigs"])
def test_intervals_belong_to_their_counts(title):
    text = "\n".join("|".join(row) for row in rows_of(title))
    shares = re.findall(r"(\d+)/(\d+) (\([^)]* %\))", text)
    assert len(shares) >= 15
    assert REFUSED in text or title == "False alarms"
    for hits, of, _ in shares:
        assert share_text(Share(int(hits), int(of))) in text
    assert {"".join(each) for each in shares} == {
        share_text(Share(int(hits), int(of))).replace("/", "").replace(" (", "(")
        for hits, of, _ in shares
    }
