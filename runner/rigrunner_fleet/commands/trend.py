"""`rigrunner trend`: control charts of the results of many runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rigrunner_fleet.cli.archiving import filter_options
from rigrunner_fleet.cli.monitoring import by_option, output_options

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.errors import ExitCode


@click.command(name="trend")
@click.argument("quantity")
@by_option
@click.option(
    "--chart",
    type=click.Choice(["i-mr", "ewma"]),
    default="i-mr",
    show_default=True,
    help="Individuals and moving range, or an exponentially weighted moving average.",
)
@click.option(
    "--rules",
    type=click.Choice(["nelson", "western-electric", "shewhart"]),
    default="nelson",
    show_default=True,
    help="The set of rules for individuals; shewhart is the limits only.",
)
@click.option(
    "--baseline",
    default="20",
    show_default=True,
    metavar="N|FROM..TO",
    help="The values for the limits: the first N, or those of these days (UTC).",
)
@click.option(
    "--weight",
    type=click.FloatRange(0.0, 1.0, min_open=True),
    default=0.2,
    show_default=True,
    help="The weight of a new value in an EWMA.",
)
@filter_options
@output_options
def command(
    *,
    quantity: str,
    by: tuple[str, ...],
    chart: str,
    rules: str,
    baseline: str,
    weight: float,
    runs: Path,
    database: str,
    limit: int | None,
    out: Path | None,
    as_json: bool,
    **options: Any,
) -> ExitCode:
    """Make control charts of the results of many runs.

    QUANTITY is a named result, torque, raw_peak, or a figure of the rig: J, fn, damping, zero, or
    another one by its name ('source/name' if several have this name). A named result has a chart
    for each place; --where selects one. Without --by, results are grouped by type and lot, figures
    by rig. The exit code is 1 if a rule is met after the baseline.
    """
    from rigrunner.api.errors import ExitCode
    from rigrunner_fleet.cli.monitoring import finish, question_of, read_observations, refuse_limit
    from rigrunner_fleet.cli.monitoring_text import trend_text
    from rigrunner_fleet.monitoring.trending import baseline_of, trend
    from rigrunner_fleet.trends.charting import Charting

    refuse_limit(limit)
    charting = Charting(chart, rules, baseline_of(baseline), weight)
    observations = read_observations(quantity, options, by, runs, database)
    question = question_of(
        quantity,
        options,
        by=", ".join(observations.by),
        chart=chart,
        rules=rules if chart == "i-mr" else f"EWMA, weight {weight:g}",
        baseline=f"the first {baseline}" if baseline.isdecimal() else baseline,
    )
    study = trend(observations, charting, question)
    finish(study, trend_text(study), out, as_json=as_json)
    return ExitCode.FAIL if any(series.alarms for series in study.series) else ExitCode.PASS
