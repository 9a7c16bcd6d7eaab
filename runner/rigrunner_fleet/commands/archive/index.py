"""`rigrunner archive index`: add new runs of folders."""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING

import click

from rigrunner_fleet.cli.archiving import (
    database_option,
    folders_argument,
    jobs_option,
    report_indexed,
)

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="index")
@folders_argument
@database_option
@jobs_option
def command(folders: tuple[Path, ...], database: str, jobs: int | None) -> None:
    """Update the archive from folders of runs, at any depth; by default 'runs'.

    Only new and changed runs are read. An unreadable run is listed with its problem.
    """
    from pathlib import Path

    from rigrunner.cli.batch import shown_count
    from rigrunner.jobs import Processes, usable_cores
    from rigrunner_fleet.archive import index
    from rigrunner_fleet.archive.database import Database
    from rigrunner_fleet.archive.location import location_of

    workers = Processes(jobs or usable_cores())
    sources = list(folders or [Path("runs")])
    with (
        closing(Database(location_of(database, sources))) as archive,
        shown_count("runs") as progress,
    ):
        indexed = index(archive, sources, workers=workers, progress=progress)
    report_indexed(indexed)
