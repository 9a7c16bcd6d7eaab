"""`rigrunner report`: write the report of a stored run again."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.api.errors import UsageError
from rigrunner.cli.options import lab_option, run_argument, runs_option
from rigrunner.cli.output import result
from rigrunner.run.locate import find_run


@click.command(name="report")
@run_argument
@runs_option
@lab_option
@click.option(
    "--format",
    "kind",
    metavar="NAME",
    help="A report format of 'rigrunner plugins'; by default html.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Where to write it; by default the run folder.",
)
def command(run: str, runs: Path, station: str | None, kind: str | None, out: Path | None) -> None:
    """Write the report of a stored run again.

    The same run gives the same bytes; the path of the report is printed.
    """
    from rigrunner.cli.progress import shown_progress
    from rigrunner.run.lab_plugins import lab_registry
    from rigrunner.run.report import DEFAULT_FORMAT, write_report

    folder = find_run(run, runs)
    if out is not None and not out.parent.is_dir():
        raise UsageError(f"there is no folder {out.parent}", hint="make it first")
    registry = lab_registry(station)
    kind, names = kind or DEFAULT_FORMAT, registry.names("report_format")
    if kind not in names:
        hint = registry.suggestion(kind, names)
        raise UsageError(f"there is no report format '{kind}'", hint=hint)
    with shown_progress() as progress:
        report = write_report(folder, registry, out=out, kind=kind, progress=progress.analysing)
    result(str(report))
