"""`rigrunner report`: the report of a stored run, written again."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.api.errors import UsageError
from rigrunner.cli.options import lab_option, run_argument, runs_option
from rigrunner.cli.output import result
from rigrunner.workflow.locate import find_run


@click.command(name="report")
@run_argument
@runs_option
@lab_option
@click.option(
    "--format",
    "kind",
    metavar="NAME",
    help="A report format of 'rigrunner plugins'; left out, html.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Where to write it; left out, into the run folder.",
)
def command(run: str, runs: Path, station: str | None, kind: str | None, out: Path | None) -> None:
    """Write the report of a stored run again.

    The same run gives the same bytes; the path of the report is printed.
    """
    from rigrunner.cli.progress import shown_progress
    from rigrunner.workflow.lab_plugins import lab_registry
    from rigrunner.workflow.report import DEFAULT_FORMAT, write_report

    folder = find_run(run, runs)
    try:
        with shown_progress() as progress:
            registry = lab_registry(station)
            written = write_report(
                folder,
                registry,
                out=out,
                kind=kind or DEFAULT_FORMAT,
                progress=progress.analysing,
            )
        result(str(written))
    except OSError as error:
        raise UsageError(f"the report cannot be written: {error}") from error
