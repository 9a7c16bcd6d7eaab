"""`rigrunner capability`: compare the results of many runs with limits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rigrunner_fleet.cli.archiving import filter_options
from rigrunner_fleet.cli.monitoring import by_option, output_options

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="capability")
@click.argument("quantity")
@click.option(
    "--upper", default="", metavar="QUANTITY", help="The upper limit, such as '0.95 N·m'."
)
@click.option("--lower", default="", metavar="QUANTITY", help="The lower limit.")
@click.option(
    "--confidence",
    type=click.FloatRange(0.5, 0.9999),
    default=0.95,
    show_default=True,
    help="Confidence level of the two-sided intervals.",
)
@by_option
@filter_options
@output_options
def command(
    *,
    quantity: str,
    upper: str,
    lower: str,
    confidence: float,
    by: tuple[str, ...],
    runs: Path,
    database: str,
    limit: int | None,
    out: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Compare the results of many runs with limits.

    QUANTITY is as in `trend`. With an upper limit alone the index is Cpu, with a lower one Cpl,
    with both also Cp and Cpk, each with its confidence interval. Without limits a named result is
    compared with the limits of its runs.
    """
    from rigrunner_fleet.cli.monitoring import finish, question_of, read_observations, refuse_limit
    from rigrunner_fleet.cli.monitoring_text import capability_text
    from rigrunner_fleet.monitoring.capability import capability_study
    from rigrunner_fleet.monitoring.quantities import limit_in

    refuse_limit(limit)
    observations = read_observations(quantity, options, by, runs, database)
    question = question_of(
        quantity, options, by=", ".join(observations.by), upper=upper, lower=lower
    )
    study = capability_study(
        observations,
        question,
        lower=limit_in(lower, observations.unit),
        upper=limit_in(upper, observations.unit),
        confidence=confidence,
    )
    finish(study, capability_text(study), out, as_json=as_json)
