"""`rigrunner study diagnostics`: what the checks are worth, measured on simulated rigs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner_bearings.commands.study.options import case_runner, show, study_options

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="diagnostics")
@click.option(
    "--rigs",
    type=click.IntRange(min=1),
    default=300,
    show_default=True,
    help="Healthy rigs of each simulator.",
)
@click.option(
    "--broken", type=click.IntRange(min=1), help="Rigs with each fault; by default as many."
)
@study_options
def command(
    *,
    rigs: int,
    broken: int | None,
    jobs: int | None,
    dask: str | None,
    keep: Path | None,
    seed: int,
    as_markdown: bool,
    as_json: bool,
) -> None:
    """Measure false alarms and misses of the checks on random simulated rigs.

    The same seed gives the same rigs and the same table.
    """
    from rigrunner_bearings.study.diagnostics import run_diagnostics
    from rigrunner_bearings.study.diagnostics_table import printed, study_document

    with case_runner("diagnostics", jobs, dask, keep) as runner:
        study = run_diagnostics(
            healthy_rigs=rigs, broken_rigs=broken or rigs, seed=seed, runner=runner
        )
    show(printed(study), study_document(study), as_markdown=as_markdown, as_json=as_json)
