"""The tables of silent errors are consistent, and cover the faults in the code."""

from __future__ import annotations

from pathlib import Path

from rigrunner_bearings.study.diagnostics_table import share_text
from rigrunner_bearings.study.fault_kinds import FAULTS, UNSEEN
from rigrunner_bearings.study.fault_table import HEADER, SILENT_HEADER, UNSEEN_HEADER
from rigrunner_bearings.study.faults import UNSEEN_CASES
from rigrunner_bearings.study.share import Share

PAGE = Path(__file__).parents[2] / "docs/evidence/faults.md"
AT_LEAST = 300


def table_of(title):
    section = PAGE.read_text(encoding="utf-8").split(f"## {title}\n")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    header, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return header, rows


def test_faults_match_the_code_and_all_cases_are_counted():
    header, rows = table_of("Fault by fault")
    assert header == list(HEADER)
    assert [row[:2] for row in rows] == [[fault.name, fault.extent] for fault in FAULTS]
    for row in rows:
        cases, failed, refused, flagged, *silent = (int(row[i]) for i in (2, 3, 4, 5, 7, 8, 9))
        assert failed + refused + flagged + sum(silent) == cases
    assert sum(int(row[2]) for row in rows) >= AT_LEAST


def test_no_result_is_far_beyond_its_uncertainty():
    _, rows = table_of("Fault by fault")
    within, beyond, far = (sum(int(row[i]) for row in rows) for i in (7, 8, 9))
    header, (faulty, clean) = table_of("Undetected wrong results")
    assert header == list(SILENT_HEADER)
    assert far == 0
    share = Share(beyond, within + beyond)
    assert faulty[:4] == ["with a fault", str(share.of), share_text(share), "0"]
    hits, of = (int(part) for part in clean[2].split(" ")[0].split("/"))
    assert clean[2] == share_text(Share(hits, of))
    assert clean[3] == "0"
    # No more often than on rigs without a fault, within the statistics of both.
    assert share.interval[0] <= Share(hits, of).interval[1]


def test_undetectable_faults_are_listed_with_the_reason():
    header, rows = table_of("Faults that data cannot show")
    assert header == list(UNSEEN_HEADER)
    listed = [(row[0], row[1], int(row[2]), row[-1]) for row in rows]
    assert listed == [(fault.name, fault.extent, UNSEEN_CASES, fault.unseen) for fault in UNSEEN]
