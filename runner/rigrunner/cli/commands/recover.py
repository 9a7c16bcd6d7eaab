"""`rigrunner recover`: close an interrupted run, or salvage a damaged one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import json_option, run_argument, runs_option
from rigrunner.run.locate import find_run

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="recover")
@run_argument
@runs_option
@click.option("--by", default="", metavar="NAME", help="Who closes it; by default who began it.")
@click.option("--reason", default="", metavar="TEXT", help="Why it is not resumed.")
@click.option(
    "--salvage", is_flag=True, help="Save the intact parts of a damaged run.h5 in a new folder."
)
@json_option
def command(run: str, runs: Path, *, by: str, reason: str, salvage: bool, as_json: bool) -> None:
    """Close an interrupted run as it is, or salvage a damaged one.

    An interrupted run ends as 'aborted'; what was recorded is kept, and can be shown and
    reported. The rig is not touched.

    With --salvage the intact recordings of a damaged run.h5 are saved in a new run beside it, which
    names the damaged file and lists what is lost. It is never certified; the damaged file stays.
    """
    if salvage:
        _salvage(run, runs, by, reason, as_json=as_json)
        return
    from rigrunner.cli.facts import info_document
    from rigrunner.cli.output import message, result, result_json
    from rigrunner.cli.resuming import on_disk
    from rigrunner.clock import WallClock
    from rigrunner.run.interrupted import has_ended, person, read_interrupted, recover

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


def _salvage(run: str, runs: Path, by: str, reason: str, *, as_json: bool) -> None:
    from rigrunner.cli.facts import info_document, salvaged_lines
    from rigrunner.cli.output import message, result, result_json
    from rigrunner.clock import WallClock
    from rigrunner.run.salvaging import salvage
    from rigrunner.runfile import read

    folder = salvage(find_run(run, runs), WallClock(), by.strip() or "operator", reason.strip())
    stored = read(folder)
    if as_json:
        result_json(info_document(stored.info))
        return
    names = stored.info.recording_names
    result(f"{folder}: {len(names)} recordings saved, {stored.info.reason}")
    for line in salvaged_lines(stored.header.salvaged):
        message(line)
