"""`rigrunner golden check`: compare golden runs with their references."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.api.summaries import pairs, table
from rigrunner.cli.batch import shown_count, worker_options, workers_for
from rigrunner.cli.options import json_option, lab_option
from rigrunner.cli.output import message, result, result_json
from rigrunner_fleet.cli.analysing import changes_in, changes_options

if TYPE_CHECKING:
    from rigrunner.api.errors import ExitCode
    from rigrunner_fleet.golden.overall import Overall

SHOWN = 20
"""Runs that are listed; page and JSON have all."""
_FILE = click.Path(path_type=Path, dir_okay=False)


@click.command(name="check")
@click.argument("folder", metavar="FOLDER", type=click.Path(path_type=Path, file_okay=False))
@click.option(
    "--runs",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Where the runs are, if they were moved.",
)
@changes_options
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0),
    default=1e-6,
    show_default=True,
    metavar="SHARE",
    help="How far a figure may move, as a share of its U.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Store the results here, to continue an interrupted check.",
)
@click.option("--html", type=_FILE, metavar="FILE", help="Write an HTML report.")
@click.option("--junit", type=_FILE, metavar="FILE", help="Write a JUnit file.")
@lab_option
@worker_options
@json_option
def command(
    *,
    folder: Path,
    runs: Path | None,
    file: Path | None,
    primary: str,
    tolerance: float,
    out: Path | None,
    html: Path | None,
    junit: Path | None,
    station: str | None,
    jobs: int | None,
    dask: str | None,
    as_json: bool,
) -> ExitCode:
    """Analyse golden runs again, and list differences from the references.

    The exit code is 1 if a verdict flipped, a figure moved, or a run is newly refused or accepted,
    and 5 if a golden run is gone or cannot be read.
    """
    from rigrunner.api.errors import UsageError
    from rigrunner.cli.stopping import batch_stop_on_signals
    from rigrunner_fleet.golden.checking import Checker
    from rigrunner_fleet.golden.words import conclusion
    from rigrunner_fleet.reanalysis.batch import Batch

    if html is not None and html.suffix != ".html":  # reported before hours of work
        raise UsageError(f"no report is written as '{html.name}'", hint="end it with: .html")
    workers, changes = workers_for(jobs, dask), changes_in(file, primary, station)
    with batch_stop_on_signals() as stop, shown_count("runs") as progress:
        overall = Checker(
            folder=folder,
            runs=runs,
            tolerance=tolerance,
            out=out,
            batch=Batch(changes, station, workers, stop, progress),
        ).check()
    _write(overall, html, junit)
    if as_json:
        result_json(overall.document())
    else:
        counts = [(str(standing), str(count)) for standing, count in overall.counts().items()]
        counts += [(name, f"{now}, was {then}") for name, then, now in overall.made_by]
        parts = [_listed(overall), _frequencies(overall), pairs(counts), conclusion(overall)]
        result("\n\n".join(part for part in parts if part))
    return overall.exit_code


def _write(overall: Overall, html: Path | None, junit: Path | None) -> None:
    from rigrunner_fleet.reanalysis.summary import write_text

    if html is not None:
        from rigrunner_fleet.golden.report import golden_study
        from rigrunner_fleet.monitoring.report import write_study

        write_study(golden_study(overall), html)
        message(f"Wrote {html}.")
    if junit is not None:
        from rigrunner_fleet.golden.report import junit as as_junit

        write_text(junit, as_junit(overall))
        message(f"Wrote {junit}.")


def _listed(overall: Overall) -> str:
    from rigrunner_fleet.golden.words import details

    lines = []
    for run in overall.moved[:SHOWN]:
        lines += [f"{run.name}: {run.standing}", *(f"  {line}" for line in details(run))]
    if len(overall.moved) > SHOWN:
        lines.append(f"and {len(overall.moved) - SHOWN} more runs (--json or --html lists them)")
    return "\n".join(lines)


def _frequencies(overall: Overall) -> str:
    from rigrunner_fleet.golden.words import in_u

    rows = [
        (
            f"{row.frequency_hz:g} Hz",
            str(row.shift_nm.n),
            f"{row.shift_nm.mean * 1000:+.4g} mN·m",
            in_u(row.in_u.mean) if row.in_u else "-",
            in_u(row.in_u.largest) if row.in_u else "-",
        )
        for row in overall.by_frequency()
    ]
    if not rows or not overall.moved:
        return ""
    return table(("set-point", "values", "mean shift", "mean", "largest"), rows, "rrrrr")
