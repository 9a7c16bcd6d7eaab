"""The study of faults as tables of text and as a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner_bearings.study.diagnostics_table import share_text
from rigrunner_bearings.study.tables import Table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner_bearings.study.faults import FaultRow, Finding, Silent, Study
    from rigrunner_bearings.study.tables import Part

HEADER = (
    "fault", "from to", "cases", "recording failed", "analysis refused", "flagged", "by",
    "silent: up to U", "U to 2U", "above 2U", "worst / U",
)  # fmt: skip
SILENT_HEADER = ("cases", "silent", "U to 2U", "above 2U", "worst / U", "worst set-point / U")
UNSEEN_HEADER = ("fault", "from to", "cases", "flagged", "above 2U", "why no data can show it")
NOTHING = "-"


def fault_rows(study: Study) -> list[list[str]]:
    """Return the faults that data can show, one row each, in the order of HEADER."""
    rows = []
    for row in study.rows:
        by = ", ".join(f"{name} {count}" for name, count in row.flagged.most_common())
        silent = row.silent
        rows.append(
            [
                row.fault.name,
                row.fault.extent,
                str(row.cases),
                str(row.recording_failed),
                str(row.refused),
                str(row.flagged_cases),
                by or NOTHING,
                str(silent.within),
                str(silent.beyond),
                str(silent.far_beyond),
                f"{silent.worst:.2f}" if silent.count else NOTHING,
            ]
        )
    return rows


def silent_rows(study: Study) -> list[list[str]]:
    """Return the results that no check flagged, of faulty cases and of clean ones."""
    return [_silent("with a fault", study.silent), _silent("clean", study.clean)]


def unseen_rows(study: Study) -> list[list[str]]:
    """Return the faults that no data can show."""
    return [
        [
            row.fault.name,
            row.fault.extent,
            str(row.cases),
            str(row.flagged_cases),
            str(row.silent.far_beyond),
            row.fault.unseen,
        ]
        for row in study.unseen
    ]


def summary(study: Study) -> str:
    """Return the main figures in one sentence."""
    share = share_text_of(study.silent)
    return (
        f"Of {study.cases} cases with a fault {study.silent.count} passed in silence;"
        f" {study.silent.far_beyond} of these with an error above twice the stated expanded"
        f" uncertainty, and between one and two times {share}"
        f" (clean: {share_text_of(study.clean)}, and {study.clean_flagged} false alarms)."
        f" {len(study.crashed)} crashed."
    )


def share_text_of(silent: Silent) -> str:
    """Return the share with an error of once to twice the stated one, with its interval."""
    return share_text(silent.share_beyond) if silent.count else NOTHING


def printed(study: Study) -> Iterator[Part]:
    """Yield the printed parts."""
    yield Table(header=HEADER, rows=fault_rows(study), sides="llrrrrlrrrr")
    yield Table(header=SILENT_HEADER, rows=silent_rows(study), sides="lrrrrr")
    yield Table(header=UNSEEN_HEADER, rows=unseen_rows(study), sides="llrrrl")
    yield summary(study)
    yield from listing(study)


def listing(study: Study) -> list[str]:
    """Return the wrong cases that nothing flagged, and those that crashed, one per line."""
    return [
        *(f"{_case(finding)}: error {finding.ratio:.1f} U, unflagged" for finding in study.wrong),
        *(f"{_case(finding)}: crashed" for finding in study.crashed),
    ]


def _case(finding: Finding) -> str:
    case = finding.case
    return f"{case.fault or 'clean'} {case.number} on {case.simulator}, {finding.where}"


def study_document(study: Study) -> dict[str, Any]:
    """Return the study for JSON."""
    return {
        "cases": study.cases,
        "faults": [_document(row) for row in study.rows],
        "unseen": [{**_document(row), "unseen_because": row.fault.unseen} for row in study.unseen],
        "silent": _silent_document(study.silent),
        "clean": {**_silent_document(study.clean), "flagged": study.clean_flagged},
        "wrong": [_case(finding) for finding in study.wrong],
        "crashed": [_case(finding) for finding in study.crashed],
    }


def _silent(label: str, silent: Silent) -> list[str]:
    return [
        label,
        str(silent.count),
        share_text_of(silent),
        str(silent.far_beyond),
        f"{silent.worst:.2f}",
        f"{silent.worst_point:.2f}",
    ]


def _document(row: FaultRow) -> dict[str, Any]:
    return {
        "name": row.fault.name,
        "extent": row.fault.extent,
        "cases": row.cases,
        "recording_failed": row.recording_failed,
        "analysis_refused": row.refused,
        "flagged": row.flagged_cases,
        "flagged_by": dict(row.flagged),
        "silent": _silent_document(row.silent),
    }


def _silent_document(silent: Silent) -> dict[str, Any]:
    return {
        "up_to_stated": silent.within,
        "one_to_two_times": silent.beyond,
        "above_twice": silent.far_beyond,
        "worst": silent.worst,
        "worst_set_point": silent.worst_point,
    }
