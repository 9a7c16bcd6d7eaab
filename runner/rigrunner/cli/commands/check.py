"""`rigrunner check`: whether a procedure can be run, without a rig."""

from __future__ import annotations

import click

from rigrunner.cli.completing import stations
from rigrunner.cli.options import procedure_argument
from rigrunner.cli.output import result
from rigrunner.cli.progress import clock_text
from rigrunner.workflow.locate import find_procedure, find_station


@click.command(name="check")
@procedure_argument
@click.option("--station", shell_complete=stations, help="Check how it fits this station, too.")
def command(procedure: str, station: str | None) -> None:
    """Check a procedure, and how it fits a station, without a rig.

    Every problem is shown with its file, line and column.
    """
    from rigrunner.plan import check_limits
    from rigrunner.procedure import load_procedure
    from rigrunner.registry import load_registry
    from rigrunner.workflow.approval import approval_state
    from rigrunner.workflow.overrides import require_overridden
    from rigrunner.workflow.planning import planned_run

    path = find_procedure(procedure)
    if station is None:
        loaded = load_procedure(path)
        check_limits(loaded, None, load_registry())
        result(
            f"{path}: {loaded.model.id} is valid; with --station its plugins and limits are"
            f" checked too\n{approval_state(loaded).sentence()}"
        )
        return
    planned = planned_run(path, find_station(station))
    require_overridden(planned, ())
    steps, seconds = planned.plan.steps, planned.plan.estimated_s
    result(f"{path}: can be run on {station}: {len(steps)} steps, {clock_text(seconds)}")
    result(planned.approval.sentence())
