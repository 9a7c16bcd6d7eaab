"""`rigrunner recover`: a run that was broken off is closed as it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import json_option, run_argument, runs_option
from rigrunner.workflow.locate import find_run

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="recover")
@run_argument
@runs_option
@click.option("--by", default="", metavar="NAME", help="Who closes it; else who began it.")
@click.option("--reason", default="", metavar="TEXT", help="Why it does not go on.")
@json_option
def command(run: str, runs: Path, *, by: str, reason: str, as_json: bool) -> None:
    """Close a run that was broken off as it is.

    Its outcome is 'aborted'; what was recorded is kept, and can be shown and reported. The rig is
    not touched.
    """
    from rigrunner.cli.facts import info_document
    from rigrunner.cli.output import message, result, result_json
    from rigrunner.cli.resuming import on_disk
    from rigrunner.clock import WallClock
    from rigrunner.workflow.interrupted import has_ended, person, read_interrupted, recover

    folder = find_run(run, runs)
    before = read_interrupted(folder)
    stored = recover(folder, WallClock(), by.strip() or person(before), reason.strip())
    if as_json:
        result_json(info_document(stored.info))
    else:
        result(f"{stored.header.run_id}: {stored.info.outcome}, sealed")
        result(on_disk(stored))
    if not has_ended(before):
        message("The rig was not touched: see for yourself that it is safe.")
    if stored.info.outcome == "completed":
        message(f"It had been completed: 'rigrunner report {folder}' writes its report.")
