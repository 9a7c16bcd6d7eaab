"""A study as tables of text and as a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner_bearings.study.diagnostics_rigs import POPULATIONS
from rigrunner_bearings.study.tables import Table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner_bearings.study.diagnostics import Error, Study
    from rigrunner_bearings.study.share import Share
    from rigrunner_bearings.study.tables import Part

ALARM_HEADER = ("check", *POPULATIONS)
BREAK_HEADER = ("break", "from to", "seen by", "missed", "other checks", "error / N·m")
NOTHING = "-"


def alarm_rows(study: Study) -> list[list[str]]:
    """Return the false alarms, one row per check: 'alarms/rigs (95 % interval)' per simulator."""
    return [
        [check, *(share_text(shares[name]) for name in POPULATIONS)]
        for check, shares in study.alarms.items()
    ]


def break_rows(study: Study) -> list[list[str]]:
    """Return the breaks, one row each, in the order of BREAK_HEADER."""
    rows = []
    for row in study.breaks:
        other_checks = ", ".join(f"{name} {count}" for name, count in row.others.most_common())
        rows.append(
            [
                row.fault.name,
                row.fault.extent,
                row.fault.seen_by or NOTHING,
                NOTHING if row.missed is None else share_text(row.missed),
                other_checks or NOTHING,
                error_text(row.error),
            ]
        )
    return rows


def printed(study: Study) -> Iterator[Part]:
    """Yield the printed parts."""
    title = f"False alarms on {study.healthy} healthy rigs"
    yield Table(title=title, header=ALARM_HEADER, rows=alarm_rows(study), sides="lrr")
    errors = [[name, error_text(error)] for name, error in study.error.items()]
    title, header = "Error on healthy rigs, in N·m", ("rigs of", "rms, largest")
    yield Table(title=title, header=header, rows=errors, sides="lr")
    yield Table(title="Broken rigs", header=BREAK_HEADER, rows=break_rows(study), sides="lllrlr")
    unseen = [[row.fault.name, row.fault.unseen] for row in study.breaks if row.fault.unseen]
    title, header = "What no check sees", ("break", "why")
    yield Table(title=title, header=header, rows=unseen, sides="ll")


def share_text(share: Share) -> str:
    """Return '3/300 (0.2-2.9 %)'."""
    low, high = share.interval
    return f"{share.hits}/{share.of} ({100 * low:.1f}-{100 * high:.1f} %)"


def error_text(error: Error | None) -> str:
    """Return 'rms, largest', or a dash without a method."""
    return NOTHING if error is None else f"{error.rms_nm:.3f}, {error.largest_nm:.3f}"


def study_document(study: Study) -> dict[str, Any]:
    """Return the study for JSON."""
    return {
        "healthy_rigs": study.healthy,
        "false_alarms": {
            check: {name: share.document() for name, share in shares.items()}
            for check, shares in study.alarms.items()
        },
        "error_of_healthy_rigs_nm": {name: _error(error) for name, error in study.error.items()},
        "breaks": [
            {
                "name": row.fault.name,
                "extent": row.fault.extent,
                "seen_by": row.fault.seen_by or None,
                "unseen_because": row.fault.unseen or None,
                "missed": None if row.missed is None else row.missed.document(),
                "other_checks": dict(row.others),
                "error_nm": _error(row.error),
            }
            for row in study.breaks
        ],
    }


def _error(error: Error | None) -> dict[str, float] | None:
    return None if error is None else {"rms": error.rms_nm, "largest": error.largest_nm}
