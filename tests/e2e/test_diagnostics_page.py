"""The page of the checks matches the code, and its tables are consistent."""

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
    *((limit.name, limit.allowed) for limit in LIMITS),
    AGREEMENT,
    *((limit.name, limit.allowed) for limit in (*SETUP_LIMITS, *METHOD_LIMITS)),
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


def test_every_check_has_a_false_alarm_rate():
    header, _, *rows = rows_of("False alarms")
    assert header == list(ALARM_HEADER)
    assert {row[0] for row in rows} == {name for name, _ in CHECKS} - APART


def test_breaks_match_the_code():
    header, _, *rows = rows_of("Broken rigs")
    assert header == list(BREAK_HEADER)
    expected = [(fault.name, fault.extent, fault.seen_by or NOTHING) for fault in BREAKS]
    assert [tuple(row[:3]) for row in rows] == expected


def test_every_undetected_break_is_explained():
    listed = {row[0]: row[1] for row in rows_of("What no check sees")[2:]}
    assert listed == {fault.name: fault.unseen for fault in BREAKS if not fault.seen_by}


def test_population_matches_the_code():
    listed = [tuple(row) for row in rows_of("The rigs")[2:]]
    expected = [
        (simulator, drawn.setting, f"{drawn.low:g}", f"{drawn.high:g}", _unit(drawn))
        for simulator, ranges in POPULATIONS.items()
        for drawn in ranges
    ]
    assert listed == expected
    text = PAGE.read_text(encoding="utf-8")
    assert f"{CYCLES} cycles at {', '.join(f'{f:g}' for f in FREQUENCIES_HZ)} Hz" in text


def _unit(drawn):
    return f"times {drawn.times}" if drawn.times else drawn.unit


@pytest.mark.parametrize("title", ["False alarms", "Broken rigs"])
def test_intervals_belong_to_their_counts(title):
    text = "\n".join("|".join(row) for row in rows_of(title))
    shares = re.findall(r"(\d+)/(\d+) (\([^)]* %\))", text)
    assert len(shares) >= 15
    assert REFUSED in text or title == "False alarms"
    for hits, of, _ in shares:
        assert share_text(Share(int(hits), int(of))) in text
    assert {"".join(share) for share in shares} == {
        share_text(Share(int(hits), int(of))).replace("/", "").replace(" (", "(")
        for hits, of, _ in shares
    }
