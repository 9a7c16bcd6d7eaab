"""`rigrunner import`: recordings that another program made, as a run like any other."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.cli.completing import stations, stored_runs
from rigrunner.cli.options import json_option, override_options, runs_option

if TYPE_CHECKING:
    from rigrunner.api.errors import ExitCode


@click.command(name="import")
@click.argument("mapping", type=click.Path(path_type=Path, dir_okay=False))
@runs_option
@click.option(
    "--no-load",
    metavar="RUN",
    shell_complete=stored_runs,
    help="The no-load run to compensate with.",
)
@click.option(
    "--no-load-after",
    metavar="RUN",
    shell_complete=stored_runs,
    help="The no-load run made after it, where the procedure asks for one.",
)
@click.option(
    "--station",
    shell_complete=stations,
    help="A station in place of the mapping's; needed where it brings plugins of its own.",
)
@override_options
@json_option
def command(
    mapping: Path,
    runs: Path,
    no_load: str | None,
    no_load_after: str | None,
    station: str | None,
    *,
    overridden: tuple[str, ...],
    by: str,
    reason: str,
    as_json: bool,
) -> ExitCode:
    """Import recordings made by another program.

    MAPPING is a YAML file that says what stands where, and at which set-points it was recorded.
    """
    from rigrunner.cli.finishing import tell_finished
    from rigrunner.cli.output import message
    from rigrunner.cli.progress import shown_progress
    from rigrunner.registry import load_registry
    from rigrunner.run.locate import find_station
    from rigrunner.run.noload import no_load_after_for, no_load_for
    from rigrunner.run.overrides import overrides_for
    from rigrunner.tools.importing.mapping import load_mapping
    from rigrunner.tools.importing.planning import plan_import
    from rigrunner.tools.importing.run import import_run

    named = None if station is None else find_station(station)
    checked = plan_import(load_mapping(mapping), load_registry(), named)
    planned = checked.planned
    overrides = overrides_for(planned, overridden, by, reason)
    chosen = no_load_for(planned, runs, no_load)
    second = no_load_after_for(planned, runs, no_load_after, planned.clock.utc())
    if planned.approval.is_draft:
        message(f"{planned.procedure.model.id} is a {planned.approval.sentence()}")
    with shown_progress() as progress:
        finished = import_run(
            checked,
            runs=runs,
            no_load=chosen,
            no_load_after=second,
            overrides=overrides,
            progress=progress.analysing,
        )
    tell_finished(finished, as_json=as_json)
    return finished.exit_code
