"""`rigrunner queue skip`: skip an entry."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import runs_option
from rigrunner.cli.queueing import by_option, reason_option

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="skip")
@click.argument("entry", type=int)
@reason_option(required=True)
@by_option
@runs_option
def command(entry: int, *, reason: str, by: str, runs: Path) -> None:
    """Skip an entry, or close one whose run was interrupted."""
    from rigrunner.queue import Queue

    Queue(runs).skip(entry, by, reason)
