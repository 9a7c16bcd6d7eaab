"""`rigrunner archive rebuild`: rebuild the archive."""

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


@click.command(name="rebuild")
@folders_argument
@database_option
@jobs_option
def command(folders: tuple[Path, ...], database: str, jobs: int | None) -> None:
    """Rebuild the archive from the run files.

    With a database and no folder, all known folders are read. Runs whose files are gone are
    removed.
    """
    from pathlib import Path

    from rigrunner.cli.batch import shown_count
    from rigrunner.jobs import Processes, usable_cores
    from rigrunner_fleet.archive import rebuild
    from rigrunner_fleet.archive.database import Database
    from rigrunner_fleet.archive.location import location_of

    workers = Processes(jobs or usable_cores())
    location = list(folders or [Path("runs")])
    sources = list(folders) if database else location
    with (
        closing(Database(location_of(database, location))) as archive,
        shown_count("runs") as progress,
    ):
        indexed = rebuild(archive, sources, workers=workers, progress=progress)
    report_indexed(indexed)
