"""The checks: those that need attention first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rigrunner.api.analysis import Consequence
from rigrunner.api.checks import effect_words, is_skipped
from rigrunner_reports.section import Section

if TYPE_CHECKING:
    from rigrunner.api import ReportInput
    from rigrunner.api.results import Result


@dataclass(frozen=True)
class CheckRow:
    """One check; `source` is the method that made it, or empty for the run itself."""

    source: str
    name: str
    ok: bool
    was_made: bool
    is_note: bool
    text: str
    effect: str
    """The effect on the result, as text."""
    advice: str


def check_rows(result: Result) -> tuple[CheckRow, ...]:
    """Return all checks of the run and its methods: those with consequences, then notes."""
    pairs = [("", check) for check in result.checks]
    for details in result.details:
        for name, checks in details.checks_by_method.items():
            pairs += [(name, check) for check in checks]
    rows = (
        CheckRow(
            source,
            check.name,
            check.ok,
            not is_skipped(check),
            check.consequence is Consequence.NOTE,
            check.text,
            effect_words(check),
            check.advice,
        )
        for source, check in pairs
    )
    return tuple(sorted(rows, key=lambda row: (row.ok, not row.is_note, row.was_made)))


def _are_shown(report: ReportInput, page: Any) -> bool:
    return bool(page.checks) or any(details.shows_recordings for details in report.result.details)


SECTIONS = (Section("checks", "Checks", 80, _are_shown),)
