"""`rigrunner golden`: stored raw data through new software, held against references."""

from __future__ import annotations

import click

from rigrunner.cli.lazy import LazyGroup
from rigrunner.cli.output import result

SUMMARIES = {
    "record": "Make runs golden: what they give now becomes the reference.",
    "check": "Analyse golden runs again, and tell what moved.",
}


@click.group(
    name="golden",
    cls=LazyGroup,
    invoke_without_command=True,
    package=__name__,
    summaries=SUMMARIES,
)
@click.pass_context
def command(context: click.Context) -> None:
    """Hold what stored runs give against references, before new software is trusted.

    The runs' own files stay as they are.
    """
    if context.invoked_subcommand is None:
        result(context.get_help())
