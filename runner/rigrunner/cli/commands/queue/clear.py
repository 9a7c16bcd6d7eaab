"""`rigrunner queue clear`: remove the entries that are over."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import runs_option

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="clear")
@runs_option
def command(*, runs: Path) -> None:
    """Remove finished entries. Their runs stay."""
    from rigrunner.cli.output import message
    from rigrunner.queue import Queue

    removed = Queue(runs).clear()
    message(f"Removed {removed} {'entry' if removed == 1 else 'entries'}.")
