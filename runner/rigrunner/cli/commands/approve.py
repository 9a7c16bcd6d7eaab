"""`rigrunner approve`: approve a procedure, or show its approvals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import procedure_argument
from rigrunner.run.locate import find_procedure

if TYPE_CHECKING:
    from datetime import datetime


@click.command(name="approve")
@procedure_argument
@click.option("--by", metavar="NAME", help="Who approves it.")
@click.option(
    "--date",
    "on",
    type=click.DateTime(["%Y-%m-%d"]),
    metavar="DATE",
    help="When, such as 2026-01-31; by default now.",
)
@click.option("--show", is_flag=True, help="Show the state only.")
def command(procedure: str, by: str | None, on: datetime | None, *, show: bool) -> None:
    """Approve a procedure in its present form, or show its approvals.

    The approval is kept in a file beside it. An edit of the procedure, or of one that it calls,
    makes it a draft again.
    """
    from rigrunner.api.errors import UsageError
    from rigrunner.cli.output import message, result
    from rigrunner.clock import WallClock
    from rigrunner.procedure import load_procedure
    from rigrunner.run.approval import approval_state, approve, moment_of

    if show == bool(by or on):
        raise UsageError(
            "name the approver with --by, or give --show", hint="such as --by 'A. Jones'"
        )
    loaded = load_procedure(find_procedure(procedure))
    if not show:
        day = on.date() if on else None
        path = approve(loaded, by or "", moment_of(day, WallClock().utc()))
        message(f"Wrote {path}.")
    model, state = loaded.model, approval_state(loaded)
    result(f"{model.id}, revision {model.revision}: {state.sentence()}")
