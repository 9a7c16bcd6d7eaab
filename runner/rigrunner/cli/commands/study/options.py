"""What the studies share on the command line: processes, seed, and how far they are."""

from __future__ import annotations

from contextlib import contextmanager
from sys import stderr
from typing import TYPE_CHECKING

import click

from rigrunner.cli.output import message

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    Progress = Callable[[int, int], None]

LINES = 20
"""Of progress, where there is no terminal to draw a bar on."""

jobs_option = click.option(
    "--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="Processes to use."
)
seed_option = click.option(
    "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Names the rigs."
)
markdown_option = click.option(
    "--markdown", "as_markdown", is_flag=True, help="Print Markdown, as in the documentation."
)


@contextmanager
def progress_shown() -> Iterator[Progress]:
    """Give a bar on a terminal, and a line now and then elsewhere."""
    if not stderr.isatty():
        yield _line
        return
    with click.progressbar(length=1, label="rigs", file=stderr) as bar:

        def move(done: int, of: int) -> None:
            bar.length = of
            bar.update(done - bar.pos)

        yield move


def _line(done: int, of: int) -> None:
    if done * LINES // of > (done - 1) * LINES // of:
        message(f"{done} of {of} rigs")
