"""`rigrunner resume`: resume an interrupted run at its next point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.api.errors import ExitCode
from rigrunner.cli.completing import procedures, stations
from rigrunner.cli.options import json_option, partner_option, run_argument, runs_option
from rigrunner.run.locate import find_procedure, find_run, find_station

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


@click.command(name="resume")
@run_argument
@runs_option
@click.option(
    "--procedure",
    shell_complete=procedures,
    help="The procedure, if its file was moved.",
)
@click.option(
    "--station",
    shell_complete=stations,
    help="The station, if its file was moved or it has plugins of its own.",
)
@partner_option
@click.option("--by", default="", metavar="NAME", help="Who resumes it; by default who began it.")
@click.option("--dry-run", is_flag=True, help="Check, and show where it would continue.")
@click.option("--unattended", is_flag=True, help="Use the answers in the procedure.")
@click.option("--realtime", is_flag=True, help="Run a simulated rig in real time.")
@json_option
def command(
    run: str,
    runs: Path,
    procedure: str | None,
    station: str | None,
    *,
    partners: Mapping[str, str],
    by: str,
    dry_run: bool,
    unattended: bool,
    realtime: bool,
    as_json: bool,
) -> ExitCode:
    """Resume an interrupted run.

    Setup and zero are repeated, then the run continues at its next point. Procedure, station,
    software and instruments must be unchanged.
    """
    from rigrunner.cli.answers import TerminalAnswers
    from rigrunner.cli.finishing import show_finished
    from rigrunner.cli.left_rig import TerminalPerson, show_left
    from rigrunner.cli.pausing import TerminalPauses
    from rigrunner.cli.progress import shown_progress
    from rigrunner.cli.resuming import show_resumable
    from rigrunner.cli.stopping import stop_on_signals
    from rigrunner.engine import UnattendedAnswers
    from rigrunner.run.following import following
    from rigrunner.run.interrupted import person, read_interrupted
    from rigrunner.run.planning import planned_run
    from rigrunner.run.resume import prepare_resume, resume, run_files
    from rigrunner.runfile import run_lock
    from rigrunner.tools.by_hand.settling import settle_left

    folder = find_run(run, runs)
    with run_lock(folder):
        stored = read_interrupted(folder)
        files = run_files(
            stored,
            find_procedure(procedure) if procedure else None,
            find_station(station) if station else None,
        )
        who = by.strip() or person(stored)
        planned = planned_run(*files, realtime=realtime)
        resumable = prepare_resume(folder, stored, planned, who, partners)
        show_resumable(resumable)
        if dry_run:
            show_left(resumable.planned.station.model.id)
            return ExitCode.PASS
        terminal = TerminalPerson(attended=not unattended)
        settle_left(files[1], terminal)
        with (
            stop_on_signals(attended=not unattended) as stop,
            shown_progress() as progress,
            following(resumable.planned, progress.live) as live,
        ):
            finished = resume(
                resumable,
                answers=UnattendedAnswers() if unattended else TerminalAnswers(stop, progress),
                stop=stop,
                listeners=[stop, progress, *live],
                pauses=None if unattended else TerminalPauses(stop, progress, who),
                progress=progress.analysing,
                person=terminal,
            )
    show_finished(finished, as_json=as_json)
    return finished.exit_code
