"""`rigrunner import`: import recordings of another program as a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.cli.completing import stations
from rigrunner.cli.options import json_option, override_options, partner_option, runs_option

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.errors import ExitCode


@click.command(name="import")
@click.argument("mapping", type=click.Path(path_type=Path, dir_okay=False))
@runs_option
@partner_option
@click.option(
    "--station",
    shell_complete=stations,
    help="A station instead of the mapping's; needed if it has plugins of its own.",
)
@override_options
@json_option
def command(
    mapping: Path,
    runs: Path,
    partners: Mapping[str, str],
    station: str | None,
    *,
    overridden: tuple[str, ...],
    by: str,
    reason: str,
    as_json: bool,
) -> ExitCode:
    """Import recordings made by another program.

    MAPPING is a YAML file that maps files and columns to recordings, channels and set-points.
    """
    from rigrunner.cli.finishing import show_finished
    from rigrunner.cli.output import message
    from rigrunner.cli.progress import shown_progress
    from rigrunner.queue import SPECIMEN, tested_before
    from rigrunner.registry import load_registry
    from rigrunner.run.locate import find_station
    from rigrunner.run.overrides import overrides_for
    from rigrunner.run.partners import later_partners, partners_after_for, partners_for
    from rigrunner.tools.importing.mapping import load_mapping
    from rigrunner.tools.importing.planning import plan_import
    from rigrunner.tools.importing.run import import_run

    station_path = None if station is None else find_station(station)
    checked = plan_import(load_mapping(mapping), load_registry(), station_path)
    planned = checked.planned
    overrides = overrides_for(planned, overridden, by, reason)
    later = later_partners(planned)
    before = {name: run for name, run in partners.items() if name not in later}
    after = {name: run for name, run in partners.items() if name in later}
    chosen = partners_for(planned, runs, before)
    chosen |= partners_after_for(planned, runs, after, planned.clock.utc())
    if planned.approval.is_draft:
        message(f"{planned.procedure.model.id} is a {planned.approval.sentence()}")
    specimens = [checked.matched.inputs.get(SPECIMEN, "")]
    for note in tested_before(runs, planned.procedure.model.id, specimens).values():
        message(f"note: {note}")
    with shown_progress() as progress:
        finished = import_run(
            checked,
            runs=runs,
            partners=chosen,
            overrides=overrides,
            progress=progress.analysing,
        )
    show_finished(finished, as_json=as_json)
    return finished.exit_code
