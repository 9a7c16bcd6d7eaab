"""`rigrunner run`: a procedure on a station, from two files to a sealed folder and its report."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.completing import stored_runs
from rigrunner.cli.options import (
    answers_option,
    json_option,
    named_values,
    procedure_argument,
    runs_option,
    set_option,
    station_option,
)
from rigrunner.workflow.locate import find_procedure, find_station

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.errors import ExitCode


@click.command(name="run")
@procedure_argument
@station_option
@runs_option
@set_option
@answers_option
@click.option(
    "--no-load",
    metavar="RUN",
    shell_complete=stored_runs,
    help="The no-load run to compensate with.",
)
@click.option("--unattended", is_flag=True, help="Take the procedure's own answers.")
@click.option("--realtime", is_flag=True, help="Let a simulated rig take its real time.")
@click.option("--operator", metavar="NAME", help="Who does the run.")
@click.option(
    "--override",
    "overridden",
    multiple=True,
    metavar="INSTRUMENT",
    help="Start although this instrument's calibration is overdue, missing or out of range.",
)
@click.option("--by", default="", metavar="NAME", help="Who answers for the override.")
@click.option("--reason", default="", metavar="TEXT", help="Why it is overridden.")
@json_option
def command(
    procedure: str,
    station: str,
    runs: Path,
    given: tuple[str, ...],
    no_load: str | None,
    *,
    overridden: tuple[str, ...],
    operator: str | None,
    by: str,
    reason: str,
    answers_file: Path | None,
    unattended: bool,
    realtime: bool,
    as_json: bool,
) -> ExitCode:
    """Run a procedure on a station.

    PROCEDURE is a file, or the name of a shipped procedure.
    """
    from rigrunner.cli.answers import TerminalAnswers
    from rigrunner.cli.finishing import tell_finished
    from rigrunner.cli.output import message
    from rigrunner.cli.pausing import TerminalPauses
    from rigrunner.cli.progress import shown_progress
    from rigrunner.cli.stopping import stop_on_signals
    from rigrunner.engine import UnattendedAnswers
    from rigrunner.workflow.inputs import answer_inputs, read_answers, with_operator
    from rigrunner.workflow.overrides import overrides_for
    from rigrunner.workflow.planning import planned_run
    from rigrunner.workflow.prepare import no_load_for
    from rigrunner.workflow.record import execute

    planned = planned_run(find_procedure(procedure), find_station(station), realtime=realtime)
    overrides = overrides_for(planned, overridden, by, reason)
    named = with_operator(named_values(given), operator, planned.procedure)
    filed = read_answers(answers_file, planned.procedure) if answers_file else {}
    chosen = no_load_for(planned, runs, no_load)
    if planned.approval.is_draft:
        message(f"{planned.procedure.model.id} is a {planned.approval.sentence()}")
    with stop_on_signals(attended=not unattended) as stop, shown_progress() as progress:
        answers = UnattendedAnswers() if unattended else TerminalAnswers(stop, progress)
        inputs = answer_inputs(planned.procedure, {**filed, **named}, answers)
        person = inputs.get("operator", answers.by)
        finished = execute(
            planned,
            runs=runs,
            inputs=inputs,
            no_load=chosen,
            answers=answers,
            stop=stop,
            listeners=[stop, progress],
            operator=operator or "",
            overrides=overrides,
            pauses=None if unattended else TerminalPauses(stop, progress, operator or person),
            progress=progress.analysing,
        )
    tell_finished(finished, as_json=as_json)
    return finished.exit_code
