"""`rigrunner study coverage`: how wrong results are, and how often their interval is right."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.cli.commands.study.options import (
    jobs_option,
    markdown_option,
    progress_shown,
    seed_option,
)
from rigrunner.cli.options import json_option
from rigrunner.cli.output import message, result, result_json
from rigrunner.cli.stopping import stop_on_signals
from rigrunner.cli.table import table
from rigrunner.workflow.study.coverage import run_coverage
from rigrunner.workflow.study.coverage_plots import draw_figures
from rigrunner.workflow.study.coverage_table import markdown, study_document, summary, tables

if TYPE_CHECKING:
    from rigrunner.workflow.study.coverage import Study


@click.command(name="coverage")
@click.option(
    "--rigs",
    type=click.IntRange(min=1),
    default=250,
    show_default=True,
    help="Rigs of each simulator.",
)
@jobs_option
@seed_option
@click.option(
    "--figures",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Write the figures there, as SVG.",
)
@markdown_option
@json_option
def command(
    rigs: int, jobs: int, seed: int, figures: Path | None, *, as_markdown: bool, as_json: bool
) -> None:
    """Measure errors, and how often the stated 95 % interval holds the truth.

    Random simulated rigs with errors from the distributions that the budget states. The same seed
    gives the same rigs and the same tables.
    """
    with stop_on_signals() as stop, progress_shown() as progress:
        study = run_coverage(rigs=rigs, seed=seed, jobs=jobs, stop=stop, progress=progress)
    if figures is not None:
        for path in draw_figures(study, figures):
            message(f"wrote {path}")
    if as_json:
        result_json(study_document(study))
    else:
        result(markdown(study) if as_markdown else _text(study))


def _text(study: Study) -> str:
    found = (f"{each.title}\n{table(each.header, each.rows, each.sides)}" for each in tables(study))
    return "\n\n".join([summary(study), *found])
