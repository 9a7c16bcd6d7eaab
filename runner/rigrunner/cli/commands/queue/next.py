"""`rigrunner queue next`: run the next specimen, like `rigrunner run`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import json_option, runs_option
from rigrunner.cli.queueing import by_option
from rigrunner.run.locate import find_procedure, find_station

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.errors import ExitCode


@click.command(name="next")
@click.option(
    "--station", default="", help="The station; needed if entries of several are waiting."
)
@click.option("--unattended", is_flag=True, help="Use the answers in the procedure.")
@click.option("--realtime", is_flag=True, help="Run a simulated rig in real time.")
@by_option
@runs_option
@json_option
def command(
    *, station: str, unattended: bool, realtime: bool, by: str, runs: Path, as_json: bool
) -> ExitCode:
    """Run the next specimen of the queue.

    Its entry is marked as started before the run begins, so that no specimen runs twice.
    """
    from rigrunner.api.errors import UsageError
    from rigrunner.cli.attending import attended_run
    from rigrunner.cli.finishing import show_finished
    from rigrunner.cli.left_rig import TerminalPerson
    from rigrunner.cli.output import message
    from rigrunner.queue import Queue
    from rigrunner.run.inputs import with_operator
    from rigrunner.run.partners import partners_for
    from rigrunner.run.planning import planned_run
    from rigrunner.tools.by_hand.settling import settle_left

    queue = Queue(runs)
    entry = queue.next(station)
    if entry is None:
        raise UsageError("no entry of the queue is waiting", hint="see 'rigrunner queue list'")
    file = find_station(entry.station)
    planned = planned_run(find_procedure(entry.procedure), file, realtime=realtime)
    person = TerminalPerson(attended=not unattended)
    settle_left(file, person)
    chosen = partners_for(planned, runs, entry.partners)
    inputs = with_operator(entry.inputs, entry.operator or None, planned.procedure)
    message(f"Entry {entry.id}: {entry.specimen or entry.procedure} on {entry.station}")
    with queue.started(entry.id, by):
        try:
            finished = attended_run(
                planned,
                inputs,
                runs=runs,
                partners=chosen,
                operator=entry.operator,
                unattended=unattended,
                listeners=[queue.began(entry.id)],
                person=person,
                before=entry.remarks(),
            )
        except BaseException as error:
            queue.give_back(entry.id, f"the run did not start: {error}")
            raise
    show_finished(finished, as_json=as_json)
    return finished.exit_code
