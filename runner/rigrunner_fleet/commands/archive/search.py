"""`rigrunner archive search`: find runs."""

from __future__ import annotations

from contextlib import closing
from datetime import datetime
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.summaries import table
from rigrunner.cli.options import json_option, raw_option
from rigrunner.cli.output import message, result, result_json
from rigrunner.clock import utc_text
from rigrunner.printable import UNPRINTABLE, printable
from rigrunner.signal.rounding import with_uncertainty
from rigrunner_fleet.cli.archiving import filter_options, filters_in

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner_fleet.archive import Rows

_HEADER = ["run", "specimen", "rig", "state", "verdict", "result / N·m"]


@click.command(name="search")
@filter_options
@json_option
@click.option("--csv", "as_csv", is_flag=True, help="Print CSV, with every column.")
@raw_option
def command(
    *,
    runs: Path,
    database: str,
    limit: int | None,
    as_json: bool,
    as_csv: bool,
    raw: bool,
    **options: Any,
) -> None:
    """Find runs by specimen, rig, procedure and results, oldest first.

    Repeated options are alternatives; all options must match. With --result or --where, results
    are listed instead of runs.
    """
    from rigrunner.api.errors import UsageError
    from rigrunner_fleet.archive import open_archive
    from rigrunner_fleet.archive.querying import rows

    if as_json and as_csv:
        raise UsageError("--json and --csv exclude each other")
    filters = filters_in(options)
    results = bool(filters.results or filters.where)
    with closing(open_archive(runs, database)) as archive:
        matches = rows(archive, "results" if results else "runs", filters, limit=limit)
    if as_json:
        result_json([{name: _json(value) for name, value in row.items()} for row in matches])
    elif as_csv:
        result(matches.to_csv(raw=raw).removesuffix("\n"))
    elif not len(matches):
        message("No matching runs.")
    else:
        result(_table_of_results(matches) if results else _table_of_runs(matches))
        word = "result" if results else "run"
        message(f"1 {word}" if len(matches) == 1 else f"{len(matches)} {word}s")


def _table_of_runs(runs: Rows) -> str:
    """Return a table of runs, one line each."""
    rows = []
    for row in runs:
        run = row["run_id"] or row["path"]
        texts = (run, row["specimen"], row["rig"], _state(row), row["verdict"])
        torque = row["torque_nm"]
        expanded = nan if row["expanded_nm"] is None else row["expanded_nm"]
        shown = "" if torque is None else with_uncertainty(torque, expanded)
        rows.append([*map(_cell, texts), shown])
    if not any(shown for *_, shown in rows):  # no run has a torque
        return table(_HEADER[:-1], [row[:-1] for row in rows], "lllll")
    return table(_HEADER, rows, "lllllr")


def _table_of_results(results: Rows) -> str:
    """Return a table of named results, one line each."""
    header = ["run", "specimen", "rig", "result", "where", "value", "verdict"]
    names = ("run_id", "specimen", "rig", "name", "place")
    rows = [
        [*(_cell(row[name]) for name in names), _value(row), _cell(row["verdict"])]
        for row in results
    ]
    return table(header, rows, "lllllrl")


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
    """Return a value for JSON: a time as text, infinite as the text 'infinite'."""
    if isinstance(value, datetime):
        return utc_text(value)
    if isinstance(value, float) and not isfinite(value):
        return "infinite"
    return value
