"""`rigrunner queue repeat`: repeat the test of an entry."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import runs_option
from rigrunner.cli.queueing import by_option, reason_option

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="repeat")
@click.argument("entry", type=int)
@reason_option(required=True)
@by_option
@runs_option
def command(entry: int, *, reason: str, by: str, runs: Path) -> None:
    """Test the specimen of an entry again: a new entry waits behind it."""
    from rigrunner.cli.output import result
    from rigrunner.clock import WallClock
    from rigrunner.queue import Queue

    repeated = Queue(runs).repeat(entry, by, reason, WallClock().utc())
    result(f"{repeated.id}  {repeated.specimen}  {repeated.state}")
