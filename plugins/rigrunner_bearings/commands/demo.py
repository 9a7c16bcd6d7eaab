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
    """Run two procedures on the simulated rig and write the report.

    Time is simulated: minutes at the rig take seconds.
    """
    from rigrunner.cli.finishing import show_finished
    from rigrunner.cli.progress import shown_progress
    from rigrunner.cli.stopping import stop_on_signals
    from rigrunner.clock import SimulatedClock
    from rigrunner.engine import UnattendedAnswers
    from rigrunner.registry import load_registry
    from rigrunner.run.inputs import answer_inputs
    from rigrunner.run.locate import find_procedure, find_station
    from rigrunner.run.partners import partners_for
    from rigrunner.run.prepare import plan_run
    from rigrunner.run.record import execute
    from rigrunner_bearings.labs import PROCEDURES

    message(
        "No-load sweep and 1000 N test on a simulated rig, in simulated time, with its own answers."
    )
    answers, registry, clock = UnattendedAnswers(), load_registry(), SimulatedClock()
    runs: list[FinishedRun] = []
    try:
        with stop_on_signals() as stop, shown_progress() as progress:
            for name in PROCEDURES:  # the no-load run, then the loaded one that it compensates
                planned = plan_run(find_procedure(name), find_station("simulated"), registry, clock)
                finished = execute(
                    planned,
                    runs=folder,
                    inputs=answer_inputs(planned.procedure, {}, answers),
                    partners=partners_for(planned, folder),
                    answers=answers,
                    stop=stop,
                    listeners=[stop, progress],
                )
                runs.append(finished)
                if finished.error is not None:
                    break
    finally:
        for finished in runs:
            show_finished(finished)
    return runs[-1].exit_code
