"""`rigrunner demo`: both shipped procedures on the simulated rig."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.cli.output import message

if TYPE_CHECKING:
    from rigrunner.api.errors import ExitCode
    from rigrunner.run.finish import FinishedRun


@click.command(name="demo")
@click.option(
    "--dir",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("rigrunner-demo"),
    show_default=True,
    help="Where the run folders go.",
)
def command(folder: Path) -> ExitCode:
    """Run both procedures on the simulated rig and write the report.

    Time is simulated: minutes at the rig take seconds.
    """
    from rigrunner.cli.finishing import tell_finished
    from rigrunner.cli.progress import shown_progress
    from rigrunner.cli.stopping import stop_on_signals
    from rigrunner.clock import SimulatedClock
    from rigrunner.registry import load_registry
    from rigrunner_bearings.demo import run_demo

    message(
        "No-load sweep and 1000 N test on a simulated rig, in simulated time, with its own answers."
    )
    runs: list[FinishedRun] = []
    try:
        with stop_on_signals() as stop, shown_progress() as progress:
            runs.extend(run_demo(folder, load_registry(), SimulatedClock(), stop, [stop, progress]))
    finally:
        for finished in runs:
            tell_finished(finished)
    return runs[-1].exit_code
