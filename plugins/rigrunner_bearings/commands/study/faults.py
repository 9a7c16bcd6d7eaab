"""`rigrunner study faults`: how many wrong results pass in silence, with faults put in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner_bearings.commands.study.options import case_runner, show, study_options

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="faults")
@click.option(
    "--cases",
    type=click.IntRange(min=1),
    default=300,
    show_default=True,
    help="Recordings with a fault; half as many clean ones are added.",
)
@study_options
def command(
    *,
    cases: int,
    jobs: int | None,
    dask: str | None,
    keep: Path | None,
    seed: int,
    as_markdown: bool,
    as_json: bool,
) -> None:
    """Count results that are wrong beyond their uncertainty without a warning.

    Faults are injected into recordings of random simulated rigs, which are then analysed as usual.
    The same seed gives the same cases and tables.
    """
    from rigrunner_bearings.study.fault_table import printed, study_document
    from rigrunner_bearings.study.faults import run_faults

    with case_runner("faults", jobs, dask, keep) as runner:
        study = run_faults(cases_wanted=cases, seed=seed, runner=runner)
    show(printed(study), study_document(study), as_markdown=as_markdown, as_json=as_json)
