"""`rigrunner archive export`: export rows for other programs."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import click

from rigrunner.cli.options import raw_option
from rigrunner.cli.output import message
from rigrunner_fleet.cli.archiving import filter_options, filters_in


@click.command(name="export")
@click.argument("table")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@raw_option
@filter_options
def command(
    *,
    table: str,
    file: Path,
    raw: bool,
    runs: Path,
    database: str,
    limit: int | None,
    **options: Any,
) -> None:
    """Write a TABLE to a FILE that ends with .csv or .parquet.

    TABLE is runs, points, results, coordinates, figures, inputs, decisions or files; the options
    select the runs. An existing file is replaced.
    """
    from rigrunner.api.errors import UsageError
    from rigrunner_fleet.archive import open_archive
    from rigrunner_fleet.archive.querying import rows

    if file.suffix not in {".csv", ".parquet"}:
        raise UsageError(
            f"'{file}' is not a file to export to", hint="it ends with .csv or .parquet"
        )
    filters = filters_in(options)
    with closing(open_archive(runs, database)) as archive:
        selected = rows(archive, table, filters, limit=limit)
    if file.suffix == ".csv":
        selected.to_csv(file, raw=raw)
    else:
        selected.to_parquet(file)
    message(f"Wrote {file}: {len(selected)} rows.")
