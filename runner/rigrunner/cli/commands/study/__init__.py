"""`rigrunner study`: what Rigrunner's own statements are worth, measured on simulated rigs."""

from __future__ import annotations

import click

from rigrunner.cli.lazy import LazyGroup
from rigrunner.cli.output import result

SUMMARIES = {
    "diagnostics": "Measure false alarms and misses of the checks.",
    "coverage": "Measure errors, and how often the stated interval holds the truth.",
    "faults": "Measure how many wrong results pass in silence, with faults put in.",
}


@click.group(
    name="study",
    cls=LazyGroup,
    invoke_without_command=True,
    package=__name__,
    summaries=SUMMARIES,
)
@click.pass_context
def command(context: click.Context) -> None:
    """Measure what checks and uncertainties are worth, on random simulated rigs.

    The same seed gives the same rigs and the same tables.
    """
    if context.invoked_subcommand is None:
        result(context.get_help())
