"""`rigrunner queue release`: release an entry."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import runs_option
from rigrunner.cli.queueing import by_option

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="release")
@click.argument("entry", type=int)
@by_option
@runs_option
def command(entry: int, *, by: str, runs: Path) -> None:
    """Release a proposed or held entry, so that it waits for its turn."""
    from rigrunner.queue import Queue

    Queue(runs).release(entry, by)
