"""What a batch of analyses found, as a table for programs and for people."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any

from rigrunner.runfile.durable import publish, temporary, writing
from rigrunner.spreadsheet import cell
from rigrunner.workflow.reanalysis.task import Row

if TYPE_CHECKING:
    from pathlib import Path

FORMAT = "rigrunner: reanalysis/1"
COLUMNS = tuple(each.name for each in fields(Row))


@dataclass(frozen=True)
class Summary:
    """The lines of all runs."""

    done: tuple[Row, ...]
    failed: tuple[Row, ...]
    of: int
    """How many runs there are: fewer lines are there if it was stopped."""

    @property
    def analysed(self) -> tuple[Row, ...]:
        """The runs that have a result."""
        return tuple(row for row in self.done if not row.skipped)

    @property
    def skipped(self) -> tuple[Row, ...]:
        """The runs of which there is nothing to analyse."""
        return tuple(row for row in self.done if row.skipped)

    @property
    def other_verdicts(self) -> tuple[Row, ...]:
        """The runs that have another verdict than by their first analysis."""
        return tuple(row for row in self.analysed if row.verdict != row.verdict_before)

    def document(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "format": FORMAT,
            "runs": self.of,
            "analysed": len(self.analysed),
            "skipped": len(self.skipped),
            "failed": len(self.failed),
            "other_verdicts": len(self.other_verdicts),
            "rows": [asdict(row) for row in self._rows()],
        }

    def table(self, *, raw: bool = False) -> str:
        """Return it as CSV, a header and a line per run.

        What a spreadsheet would take for a formula has an apostrophe before it, unless `raw`.
        """
        text = io.StringIO()
        writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for row in self._rows():
            told = asdict(row)
            writer.writerow(told if raw else {name: cell(each) for name, each in told.items()})
        return text.getvalue()

    def _rows(self) -> list[Row]:
        return sorted((*self.done, *self.failed), key=by_run)


def by_run(row: Row) -> str:
    """Return what lines are sorted by."""
    return row.run


def write_summary(folder: Path, found: Summary, *, raw: bool = False) -> None:
    """Write `summary.csv` and `summary.json`; raise DataError where they cannot be written."""
    document = json.dumps(found.document(), ensure_ascii=False, indent=2, allow_nan=False)
    write_text(folder / "summary.json", f"{document}\n")
    write_text(folder / "summary.csv", found.table(raw=raw))


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all; raise DataError where that cannot be."""
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary(path).write_text(text, encoding="utf-8", errors="backslashreplace")
        publish(path, read_only=False)
