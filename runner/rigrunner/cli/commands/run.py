"""`rigrunner run`: run a procedure on a station, up to the sealed folder and its report."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import (
    answers_option,
    debugger_option,
    json_option,
    named_values,
    override_options,
    partner_option,
    procedure_argument,
    record_option,
    replay_option,
    runs_option,
    set_option,
    station_option,
)
from rigrunner.run.locate import find_procedure, find_station

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.api.errors import ExitCode


@click.command(name="run")
@procedure_argument
@station_option
@runs_option
@set_option
@answers_option
@partner_option
@click.option("--unattended", is_flag=True, help="Use the answers in the procedure.")
@click.option("--realtime", is_flag=True, help="Run a simulated rig in real time.")
@click.option("--operator", metavar="NAME", help="Who does the run.")
@override_options
@debugger_option
@record_option
@replay_option
@json_option
def command(
    procedure: str,
    station: str,
    runs: Path,
    assigned: tuple[str, ...],
    partners: Mapping[str, str],
    *,
    overridden: tuple[str, ...],
    operator: str | None,
    by: str,
    reason: str,
    answers_file: Path | None,
    record: Path | None,
    replay: Path | None,
    unattended: bool,
    realtime: bool,
    debugger: bool,
    as_json: bool,
) -> ExitCode:
    """Run a procedure on a station.

    PROCEDURE is a file, or the name of a shipped procedure.
    """
    from rigrunner.cli.attending import attended_run
    from rigrunner.cli.finishing import show_finished
    from rigrunner.cli.left_rig import TerminalPerson
    from rigrunner.cli.output import message, no_time_limits
    from rigrunner.run.inputs import read_answers, with_operator
    from rigrunner.run.overrides import overrides_for
    from rigrunner.run.partners import partners_for
    from rigrunner.run.planning import planned_run
    from rigrunner.run.taping import inputs_on, overrides_on, tape_for
    from rigrunner.tools.by_hand.settling import settle_left

    if debugger:
        message(no_time_limits())
    tape = tape_for(record, replay)
    path, file = find_procedure(procedure), find_station(station)
    planned = planned_run(path, file, realtime=realtime, tape=tape, time_limits=not debugger)
    alone = unattended or replay is not None
    person = TerminalPerson(attended=not alone)
    if replay is None:
        settle_left(file, person, always=record is not None)
    overrides = overrides_on(tape) or overrides_for(planned, overridden, by, reason)
    from_options = with_operator(named_values(assigned), operator, planned.procedure)
    from_file = read_answers(answers_file, planned.procedure) if answers_file else {}
    chosen = partners_for(planned, runs, partners)
    if planned.approval.is_draft:
        message(f"{planned.procedure.model.id} is a {planned.approval.sentence()}")
    if replay is not None:
        message(f"Replaying the tape {replay}: no instrument is used.")
    finished = attended_run(
        planned,
        {**inputs_on(tape), **from_file, **from_options},
        runs=runs,
        partners=chosen,
        operator=operator or "",
        unattended=alone,
        person=person,
        overrides=overrides,
    )
    show_finished(finished, as_json=as_json)
    for text in tape.notes() if tape else ():
        if text not in str(finished.error):
            message(f"note: {text}")
    return finished.exit_code
