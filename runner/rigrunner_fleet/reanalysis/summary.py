"""The outcome of a batch of analyses, as a table for programs and for people."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any

from rigrunner.runfile.durable import publish, temporary, writing
from rigrunner.spreadsheet import cell
from rigrunner_fleet.reanalysis.task import Row

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

FORMAT = "rigrunner: reanalysis/1"
COLUMNS = tuple(field.name for field in fields(Row) if field.name != "results")


@dataclass(frozen=True)
class Summary:
    """The lines of all runs."""

    done: tuple[Row, ...]
    failed: tuple[Row, ...]
    total: int
    """The number of runs; there are fewer lines if the batch was stopped."""

    @property
    def analysed(self) -> tuple[Row, ...]:
        """The runs with a result."""
        return tuple(row for row in self.done if not row.skipped)

    @property
    def skipped(self) -> tuple[Row, ...]:
        """The runs with nothing to analyse."""
        return tuple(row for row in self.done if row.skipped)

    @property
    def other_verdicts(self) -> tuple[Row, ...]:
        """The runs whose verdict differs from that of their first analysis."""
        return tuple(row for row in self.analysed if row.verdict != row.verdict_before)

    def document(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "format": FORMAT,
            "runs": self.total,
            "analysed": len(self.analysed),
            "skipped": len(self.skipped),
            "failed": len(self.failed),
            "other_verdicts": len(self.other_verdicts),
            "rows": [asdict(row) for row in self._rows()],
        }

    def table(self, *, raw: bool = False) -> str:
        """Return it as CSV, a header and a line per run.

        A value that a spreadsheet would take for a formula gets an apostrophe before it, unless
        `raw`.
        """
        return _csv([{name: getattr(row, name) for name in COLUMNS} for row in self._rows()], raw)

    def results(self, *, raw: bool = False) -> str:
        """Return the named results as CSV, one line each; '' if there are none."""
        results = [{"run": row.run, **result} for row in self._rows() for result in row.results]
        return _csv(results, raw) if results else ""

    def _rows(self) -> list[Row]:
        return sorted((*self.done, *self.failed), key=by_run)


def _csv(rows: Sequence[Mapping[str, Any]], raw: bool) -> str:  # noqa: FBT001  (as the callers')
    text = io.StringIO()
    writer = csv.DictWriter(text, rows[0] if rows else COLUMNS, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow(row if raw else {name: cell(value) for name, value in row.items()})
    return text.getvalue()


def by_run(row: Row) -> str:
    """Return the sort key of lines."""
    return row.run


def write_summary(folder: Path, summary: Summary, *, raw: bool = False) -> None:
    """Write `summary.csv` and `summary.json`, and `results.csv` if there are named results.

    Raises DataError if they cannot be written.
    """
    document = json.dumps(summary.document(), ensure_ascii=False, indent=2, allow_nan=False)
    write_text(folder / "summary.json", f"{document}\n")
    write_text(folder / "summary.csv", summary.table(raw=raw))
    if results := summary.results(raw=raw):
        write_text(folder / "results.csv", results)


def write_text(path: Path, text: str) -> None:
    """Write a file completely or not at all; raise DataError if that fails."""
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary(path).write_text(text, encoding="utf-8", errors="backslashreplace")
        publish(path, read_only=False)
