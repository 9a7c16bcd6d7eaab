"""The diagnostics: what needs attention first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.checks import is_skipped

if TYPE_CHECKING:
    from rigrunner.api.results import Result


@dataclass(frozen=True)
class CheckRow:
    """One check; `source` is the method that made it, or empty for the run itself."""

    source: str
    name: str
    ok: bool
    was_made: bool
    text: str
    advice: str


def check_rows(result: Result) -> tuple[CheckRow, ...]:
    """Return all checks of the run and its methods: those that failed, then those not made."""
    found = [("", check) for check in result.checks]
    for name, compensation in result.compensations.items():
        found += [(name, check) for check in compensation.checks]
    rows = (
        CheckRow(source, each.name, each.ok, not is_skipped(each), each.text, each.advice)
        for source, each in found
    )
    return tuple(sorted(rows, key=lambda row: (row.ok, row.was_made)))
