"""`rigrunner gauge-rr`: the repeatability and reproducibility of a gauge."""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING, Any

import click

from rigrunner_fleet.cli.archiving import filter_options
from rigrunner_fleet.cli.monitoring import output_options

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="gauge-rr")
@click.argument("quantity", default="torque")
@click.option(
    "--tolerance",
    default="",
    metavar="QUANTITY",
    help="Upper minus lower limit, to compare the gauge with, such as '0.5 N·m'.",
)
@filter_options
@output_options
def command(
    *,
    quantity: str,
    tolerance: str,
    runs: Path,
    database: str,
    limit: int | None,
    out: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Estimate repeatability and reproducibility of a gauge.

    QUANTITY is torque, raw_peak or a named result. The study is crossed, of sessions such as those
    of the procedure gauge_rr: the specimen of a run is the part, its operator the operator, and
    each of its set-points a trial; for a named result, each of its values at one set-point. Every
    operator must have measured every part equally often; gaps are listed.
    """
    from rigrunner_fleet.archive import open_archive
    from rigrunner_fleet.cli.archiving import filters_in
    from rigrunner_fleet.cli.monitoring import finish, question_of, refuse_limit
    from rigrunner_fleet.cli.monitoring_text import gauge_text
    from rigrunner_fleet.monitoring.gauge import gauge_study, read_sessions
    from rigrunner_fleet.monitoring.quantities import width_in

    refuse_limit(limit)
    with closing(open_archive(runs, database)) as archive:
        sessions = read_sessions(archive, quantity, filters_in(options))
    question = question_of(quantity, options, tolerance=tolerance)
    study = gauge_study(sessions, question, width_in(tolerance, sessions.unit))
    finish(study, gauge_text(study), out, as_json=as_json)
