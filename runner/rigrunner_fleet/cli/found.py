"""The rows of a search, for a terminal and as JSON."""

from __future__ import annotations

from datetime import datetime
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

from rigrunner.api.summaries import table
from rigrunner.clock import utc_text
from rigrunner.printable import UNPRINTABLE, printable
from rigrunner.signal.rounding import with_uncertainty

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner_fleet.archive import Rows

_HEADER = ["run", "specimen", "rig", "state", "verdict", "result / N·m"]


def table_of_runs(found: Rows) -> str:
    """Return a table of runs, one line each."""
    rows = []
    for row in found:
        run = row["run_id"] or row["path"]
        texts = (run, row["specimen"], row["rig"], _state(row), row["verdict"])
        torque = row["torque_nm"]
        expanded = nan if row["expanded_nm"] is None else row["expanded_nm"]
        shown = "" if torque is None else with_uncertainty(torque, expanded)
        rows.append([*map(_cell, texts), shown])
    return table(_HEADER, rows, "lllllr")


def table_of_results(found: Rows) -> str:
    """Return a table of named results, one line each."""
    header = ["run", "specimen", "rig", "result", "where", "value", "verdict"]
    names = ("run_id", "specimen", "rig", "name", "place")
    rows = [
        [*(_cell(row[each]) for each in names), _value(row), _cell(row["verdict"])] for row in found
    ]
    return table(header, rows, "lllllrl")


def json_rows(found: Rows) -> list[dict[str, Any]]:
    """Return rows as JSON values: times as text, infinite as the text 'infinite'."""
    return [{name: _json(value) for name, value in row.items()} for row in found]


def _value(row: Mapping[str, Any]) -> str:
    if row["value"] is None:
        return ""
    value, expanded = row["value"], row["expanded"]
    shown = f"{value:.6g}" if expanded is None else with_uncertainty(value, expanded)
    return shown if row["unit"] in {None, "1"} else f"{shown} {_cell(row['unit'])}"


def _state(row: Mapping[str, Any]) -> str:
    if row["missing"]:
        return "file gone"
    if row["problem"]:
        return "unreadable"
    return str(row["outcome"]) if row["sealed"] else "not sealed"


def _cell(value: str | None) -> str:
    """Return a text on one line, without control characters of terminals."""
    return printable(value or "").replace("\n", UNPRINTABLE)


def _json(value: Any) -> Any:
    if isinstance(value, datetime):
        return utc_text(value)
    if isinstance(value, float) and not isfinite(value):
        return "infinite"
    return value
