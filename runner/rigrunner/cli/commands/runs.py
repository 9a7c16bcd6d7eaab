"""`rigrunner runs`: what is stored."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rigrunner.cli.facts import info_document
from rigrunner.cli.options import json_option, runs_option
from rigrunner.cli.output import message, result, result_json
from rigrunner.cli.table import table

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.runfile import RunInfo
    from rigrunner.workflow.runs import ListedRun


@click.command(name="runs")
@runs_option
@json_option
def command(runs: Path, *, as_json: bool) -> None:
    """List the stored runs."""
    from rigrunner.workflow.runs import list_runs

    listed = list_runs(runs)
    if as_json:
        result_json([_document(run) for run in listed])
    elif not listed:
        message(f"There are no runs in {runs}.")
    else:
        result(table(["run", "outcome", "recordings"], [_row(run) for run in listed], "llr"))


def _row(run: ListedRun) -> list[str]:
    if run.info is None:
        return [run.name, "unreadable", "-"]
    return [run.name, _outcome(run.info), str(len(run.info.recording_names))]


def _outcome(info: RunInfo) -> str:
    return info.outcome if info.sealed else f"{info.outcome}, not sealed"


def _document(run: ListedRun) -> dict[str, Any]:
    if run.info is None:
        return {"run": run.name, "problem": run.problem}
    return info_document(run.info)
