"""A study as tables of text and as a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner_bearings.study.diagnostics_rigs import POPULATIONS
from rigrunner_bearings.study.markdown import piped

if TYPE_CHECKING:
    from rigrunner_bearings.study.diagnostics import BreakRow, Error, Study
    from rigrunner_bearings.study.share import Share

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
    return [_break_row(row) for row in study.breaks]


def markdown(study: Study) -> str:
    """Return both tables as a page of documentation has them, and the errors of healthy rigs."""
    errors = ", ".join(f"`{name}` {error_text(each)}" for name, each in study.error.items())
    return "\n\n".join(
        [
            piped(ALARM_HEADER, alarm_rows(study)),
            piped(BREAK_HEADER, break_rows(study)),
            f"Error on healthy rigs, rms and largest, in N·m: {errors}.",
        ]
    )


def _break_row(row: BreakRow) -> list[str]:
    others = ", ".join(f"{name} {count}" for name, count in row.others.most_common())
    return [
        row.fault.name,
        row.fault.extent,
        row.fault.seen_by or NOTHING,
        NOTHING if row.missed is None else share_text(row.missed),
        others or NOTHING,
        error_text(row.error),
    ]


def share_text(share: Share) -> str:
    """Return '3/300 (0.2-2.9 %)'."""
    low, high = share.interval
    return f"{share.hits}/{share.of} ({100 * low:.1f}-{100 * high:.1f} %)"


def error_text(error: Error | None) -> str:
    """Return 'rms, largest', or a dash where no method was run."""
    return NOTHING if error is None else f"{error.rms_nm:.3f}, {error.largest_nm:.3f}"


def study_document(study: Study) -> dict[str, Any]:
    """Return the study as JSON has it."""
    return {
        "healthy_rigs": study.healthy,
        "false_alarms": {
            check: {name: share.document() for name, share in shares.items()}
            for check, shares in study.alarms.items()
        },
        "error_of_healthy_rigs_nm": {name: _error(each) for name, each in study.error.items()},
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
