"""`rigrunner queue hold`: hold an entry."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import runs_option
from rigrunner.cli.queueing import by_option, reason_option

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="hold")
@click.argument("entry", type=int)
@reason_option(required=False)
@by_option
@runs_option
def command(entry: int, *, reason: str, by: str, runs: Path) -> None:
    """Hold an entry until it is released."""
    from rigrunner.queue import Queue

    Queue(runs).hold(entry, by, reason)
