"""`rigrunner queue move`: change the order."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import runs_option

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="move")
@click.argument("entry", type=int)
@click.option(
    "--before",
    type=int,
    metavar="ENTRY",
    help="Put it in front of this entry; by default at the end.",
)
@runs_option
def command(entry: int, before: int | None, *, runs: Path) -> None:
    """Move an entry in front of another one, or to the end."""
    from rigrunner.queue import Queue

    Queue(runs).move(entry, before)
