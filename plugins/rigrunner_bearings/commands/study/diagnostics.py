"""`rigrunner study diagnostics`: what the checks are worth, measured on simulated rigs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.output import result, result_json
from rigrunner.cli.table import table
from rigrunner_bearings.commands.study.options import going, study_options

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner_bearings.study.diagnostics import Study


@click.command(name="diagnostics")
@click.option(
    "--rigs",
    type=click.IntRange(min=1),
    default=300,
    show_default=True,
    help="Healthy rigs of each simulator.",
)
@click.option(
    "--broken", type=click.IntRange(min=1), help="Rigs with each break; left out, as many."
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
    from rigrunner_bearings.study.diagnostics_table import markdown, study_document

    with going("diagnostics", jobs, dask, keep) as cases:
        study = run_diagnostics(
            healthy_rigs=rigs, broken_rigs=broken or rigs, seed=seed, going=cases
        )
    if as_json:
        result_json(study_document(study))
    else:
        result(markdown(study) if as_markdown else _tables(study))


def _tables(study: Study) -> str:
    from rigrunner_bearings.study.diagnostics_table import (
        ALARM_HEADER,
        BREAK_HEADER,
        alarm_rows,
        break_rows,
        error_text,
    )

    alarms = table(list(ALARM_HEADER), alarm_rows(study), "lrr")
    breaks = table(list(BREAK_HEADER), break_rows(study), "lllrlr")
    errors = "\n".join(f"{name}: {error_text(each)}" for name, each in study.error.items())
    unseen = "\n".join(
        f"{row.fault.name}: {row.fault.unseen}" for row in study.breaks if row.fault.unseen
    )
    return "\n\n".join(
        [
            f"False alarms on {study.healthy} healthy rigs\n{alarms}",
            f"Error on healthy rigs, rms and largest, in N·m\n{errors}",
            f"Broken rigs\n{breaks}",
            f"Why no check sees a break\n{unseen}",
        ]
    )
