"""`rigrunner study coverage`: how wrong results are, and how often their interval is right."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.cli.output import message
from rigrunner_bearings.commands.study.options import case_runner, show, study_options


@click.command(name="coverage")
@click.option(
    "--rigs",
    type=click.IntRange(min=1),
    default=250,
    show_default=True,
    help="Rigs of each simulator.",
)
@click.option(
    "--figures",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Write the figures there, as SVG.",
)
@study_options
def command(
    *,
    rigs: int,
    figures: Path | None,
    jobs: int | None,
    dask: str | None,
    keep: Path | None,
    seed: int,
    as_markdown: bool,
    as_json: bool,
) -> None:
    """Measure errors, and how often the stated 95 % interval contains the true value.

    Random simulated rigs with errors from the distributions that the budget states. The same seed
    gives the same rigs and the same tables.
    """
    from rigrunner_bearings.study.coverage import run_coverage
    from rigrunner_bearings.study.coverage_plots import draw_figures
    from rigrunner_bearings.study.coverage_table import printed, study_document

    with case_runner("coverage", jobs, dask, keep) as runner:
        study = run_coverage(rigs=rigs, seed=seed, runner=runner)
    if figures is not None:
        for path in draw_figures(study, figures):
            message(f"wrote {path}")
    show(printed(study), study_document(study), as_markdown=as_markdown, as_json=as_json)
