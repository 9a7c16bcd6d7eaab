"""`rigrunner compare`: the differences of two procedures or two runs."""

from __future__ import annotations

from dataclasses import asdict
from itertools import groupby
from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import json_option, runs_option

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.errors import ExitCode
    from rigrunner.tools.comparing.compare import Comparison


@click.command(name="compare")
@click.argument("before", metavar="A")
@click.argument("after", metavar="B")
@runs_option
@json_option
def command(before: str, after: str, runs: Path, *, as_json: bool) -> ExitCode:
    """List the differences between two procedures or two runs.

    A and B are procedures, or stored runs. The exit code is 1 if a relevant difference was found,
    else 0. A difference of results is relevant beyond their combined uncertainty. Gain and offset
    errors of an instrument with one calibration in both runs cancel as far as they are equal; other
    errors, such as an accuracy in one figure, count as independent.
    """
    from rigrunner.api.errors import ExitCode
    from rigrunner.cli.output import result, result_json
    from rigrunner.tools.comparing.compare import compare

    comparison = compare(before, after, runs)
    if as_json:
        changes = [asdict(change) for change in comparison.changes]
        names = {"a": comparison.before, "b": comparison.after}
        result_json({**names, "same": comparison.same, "changes": changes})
    else:
        lines = [f"A  {comparison.before}", f"B  {comparison.after}"]
        for section, group in groupby(comparison.changes, key=lambda change: change.section):
            lines += [f"\n{section}", *(f"  {change.text}" for change in group)]
        lines += ["", comparison.verdict if comparison.same else _count(comparison)]
        result("\n".join(lines))
    return ExitCode.PASS if comparison.same else ExitCode.FAIL


def _count(comparison: Comparison) -> str:
    """Return how many changes matter, and how many others there are."""
    count = sum(change.matters for change in comparison.changes)
    others = len(comparison.changes) - count
    note = f", and {others} that {'does' if others == 1 else 'do'} not matter" if others else ""
    return f"{count} difference{'s' if count > 1 else ''}{note}"
