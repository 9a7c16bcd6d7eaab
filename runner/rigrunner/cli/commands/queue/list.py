"""`rigrunner queue list`: list the entries in the order of their runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.api.summaries import table
from rigrunner.cli.options import json_option, runs_option
from rigrunner.cli.output import message, result, result_json

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="list")
@runs_option
@json_option
def command(*, runs: Path, as_json: bool) -> None:
    """List the entries of the queue in the order of their runs."""
    from rigrunner.queue import Queue

    items = Queue(runs).shown()
    if as_json:
        result_json(
            [
                {**item.entry.model_dump(), "status": item.status, "outcome": item.outcome}
                for item in items
            ]
        )
        return
    if not items:
        message("The queue is empty.")
        return
    rows = [
        (
            str(item.entry.id), item.entry.specimen, item.entry.procedure, item.entry.station,
            item.outcome or item.status, item.entry.by,
            item.entry.reason or item.entry.again or item.entry.run,
        )
        for item in items
    ]  # fmt: skip
    header = ("entry", "specimen", "procedure", "station", "status", "by", "reason or run")
    result(table(header, rows, "r"))
