"""`rigrunner archive search`: find runs."""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING, Any

import click

from rigrunner.cli.options import json_option, raw_option
from rigrunner.cli.output import message, result, result_json
from rigrunner_fleet.cli.archiving import filter_options, filters_in

if TYPE_CHECKING:
    from pathlib import Path


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
    **words: Any,
) -> None:
    """Find runs by specimen, rig, procedure and results, oldest first.

    Repeated options are alternatives; all options must match. With --result or --where, results
    are listed instead of runs.
    """
    from rigrunner.api.errors import UsageError
    from rigrunner_fleet.archive import open_archive
    from rigrunner_fleet.archive.querying import rows
    from rigrunner_fleet.cli.found import json_rows, table_of_results, table_of_runs

    if as_json and as_csv:
        raise UsageError("--json and --csv exclude each other")
    filters = filters_in(words)
    results = bool(filters.results or filters.where)
    with closing(open_archive(runs, database)) as archive:
        found = rows(archive, "results" if results else "runs", filters, limit=limit)
    if as_json:
        result_json(json_rows(found))
    elif as_csv:
        result(found.to_csv(raw=raw).removesuffix("\n"))
    elif not len(found):
        message("No matching runs.")
    else:
        result(table_of_results(found) if results else table_of_runs(found))
        word = "result" if results else "run"
        message(f"1 {word}" if len(found) == 1 else f"{len(found)} {word}s")
