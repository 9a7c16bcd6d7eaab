"""`rigrunner check`: check a procedure without a rig."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.completing import stations
from rigrunner.cli.durations import steps_text
from rigrunner.cli.options import procedure_argument, runs_option
from rigrunner.cli.output import result
from rigrunner.run.locate import find_procedure, find_station

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.run.prepare import Planned


@click.command(name="check")
@procedure_argument
@click.option("--station", shell_complete=stations, help="Also check how it fits this station.")
@runs_option
def command(procedure: str, station: str | None, runs: Path) -> None:
    """Check a procedure, and how it fits a station, without a rig.

    Every problem is shown with its file, line and column. Partner runs are searched if the folder
    of runs exists.
    """
    path = find_procedure(procedure)
    if station is not None:
        _check_on(path, station, runs)
        return
    from rigrunner.run.approval import approval_state
    from rigrunner.run.checked import checked_alone

    loaded = checked_alone(path)
    result(
        f"{path}: {loaded.model.id} is valid; with --station its plugins and limits are checked too"
        f"\n{approval_state(loaded).sentence()}"
    )


def _check_on(path: Path, station: str, runs: Path) -> None:
    from rigrunner.run.calibration import require_calibrated
    from rigrunner.run.guardian.guarded import guardian_text, real_roles
    from rigrunner.run.planning import planned_run

    planned = planned_run(path, find_station(station))
    require_calibrated(planned)
    partners = list(_partners(planned, runs)) if runs.is_dir() else []
    steps, seconds = planned.plan.steps, planned.plan.estimated_s
    result(f"{path}: can be run on {station}: {steps_text(len(steps), seconds)}")
    result(planned.approval.sentence())
    for text in partners:
        result(text)
    real = real_roles(planned.station, planned.registry)
    if text := guardian_text(planned.station, planned.registry, real):
        result(f"{text[0].upper()}{text[1:]}.")


def _partners(planned: Planned, runs: Path) -> Iterator[str]:
    from rigrunner.api.analysis.requirements import partner_words
    from rigrunner.run.partners import require_partners

    for name, run in require_partners(planned, runs).items():
        yield f"Its {partner_words(name)} would be {run.name}."
