"""`rigrunner reanalyse`: analyse many stored runs again, on all cores or a cluster."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.api.errors import ExitCode
from rigrunner.api.summaries import pairs
from rigrunner.cli.batch import shown_count, worker_options, workers_for
from rigrunner.cli.options import json_option, lab_option, raw_option
from rigrunner.cli.output import message, result, result_json
from rigrunner_fleet.cli.analysing import changes_in, changes_options, paths_argument

if TYPE_CHECKING:
    from rigrunner_fleet.reanalysis.summary import Summary

SHOWN = 20
"""Runs that are listed by name; the summary has all."""


@click.command(name="reanalyse")
@paths_argument
@click.option(
    "--out",
    required=True,
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Write the results here; the same folder again continues an interrupted analysis.",
)
@changes_options
@lab_option
@worker_options
@raw_option
@json_option
def command(
    *,
    paths: tuple[Path, ...],
    out: Path,
    file: Path | None,
    primary: str,
    station: str | None,
    jobs: int | None,
    dask: str | None,
    raw: bool,
    as_json: bool,
) -> ExitCode:
    """Analyse many stored runs again, on all cores or a cluster.

    PATH is a file, a run folder, or a folder of runs at any depth. Run files do not change. Each
    result goes into a file, and a summary lists the changes from the first analysis. A run that
    fails is listed, and the others continue.
    """
    from rigrunner.cli.stopping import batch_stop_on_signals
    from rigrunner_fleet.reanalysis.batch import Batch
    from rigrunner_fleet.reanalysis.selection import select_runs

    workers, changes, runs = (
        workers_for(jobs, dask),
        changes_in(file, primary, station),
        select_runs(paths),
    )
    with batch_stop_on_signals() as stop, shown_count("runs") as progress:
        batch = Batch(changes, station, workers, stop, progress)
        summary = batch.run(runs, out.resolve(), raw=raw)
    if as_json:
        result_json(summary.document())
    else:
        _show(summary, out)
    return ExitCode.DATA if summary.failed else ExitCode.PASS


def _show(summary: Summary, out: Path) -> None:
    for row in summary.other_verdicts[:SHOWN]:
        result(f"{row.run}: {row.verdict_before or 'no verdict'} -> {row.verdict or 'no verdict'}")
    for row in summary.failed[:SHOWN]:
        message(f"failed: {row.run}: {row.problem}")
    result(
        pairs(
            [
                ("analysed", str(len(summary.analysed))),
                ("skipped", str(len(summary.skipped))),
                ("failed", str(len(summary.failed))),
                ("other verdicts", str(len(summary.other_verdicts))),
                ("results", str(out)),
                ("summary", str(out / "summary.csv")),
            ]
        )
    )
