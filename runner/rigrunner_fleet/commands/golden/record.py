"""`rigrunner golden record`: record the references of stored runs."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.cli.batch import shown_count, worker_options, workers_for
from rigrunner.cli.options import lab_option
from rigrunner.cli.output import message, result
from rigrunner_fleet.cli.analysing import changes_in, changes_options, paths_argument


@click.command(name="record")
@paths_argument
@click.option(
    "--out",
    required=True,
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Write the references here; existing ones are kept.",
)
@click.option("--copy", is_flag=True, help="Copy the run files there too, for version control.")
@changes_options
@lab_option
@worker_options
def command(
    *,
    paths: tuple[Path, ...],
    out: Path,
    copy: bool,
    file: Path | None,
    primary: str,
    station: str | None,
    jobs: int | None,
    dask: str | None,
) -> None:
    """Record the results of runs with this software as the reference.

    PATH is a file, a run folder, or a folder of runs at any depth.
    """
    from rigrunner.cli.stopping import batch_stop_on_signals
    from rigrunner_fleet.golden.recording import Recorder
    from rigrunner_fleet.reanalysis.batch import Batch
    from rigrunner_fleet.reanalysis.selection import select_runs

    workers, runs = workers_for(jobs, dask), select_runs(paths)
    changes = changes_in(file, primary, station)
    with batch_stop_on_signals() as stop, shown_count("runs") as progress:
        batch = Batch(changes, station, workers, stop, progress)
        recorded = Recorder(out, copy, batch).record(runs)
    for row in recorded.skipped:
        message(f"left out: {row.run}: {row.skipped}")
    for reference in recorded.references:
        if reference.found.problem:
            message(f"golden as refused: {reference.name}: {reference.found.problem}")
    count = len(recorded.references)
    result(f"{count} golden run{'' if count == 1 else 's'} in {out}")
