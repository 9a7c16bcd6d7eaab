"""`rigrunner runs`: list the stored runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.summaries import table
from rigrunner.cli.facts import info_document
from rigrunner.cli.options import json_option, runs_option
from rigrunner.cli.output import message, result, result_json

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.run.runs import ListedRun


@click.command(name="runs")
@runs_option
@json_option
def command(runs: Path, *, as_json: bool) -> None:
    """List the stored runs."""
    from rigrunner.cli.left_rig import tell_all_left
    from rigrunner.run.runs import list_runs

    listed = list_runs(runs)
    if as_json:
        result_json([_document(run) for run in listed])
    elif not listed:
        missing = "" if runs.is_dir() else ": there is no such folder"
        message(f"There are no runs in {runs}{missing}.")
    else:
        result(table(["run", "outcome", "recordings"], [_row(run) for run in listed], "llr"))
    tell_all_left()
    _tell_interrupted([run.name for run in listed if run.is_interrupted])


def _tell_interrupted(names: list[str]) -> None:
    if names:
        message(f"Interrupted: {', '.join(names)}.")
        message("  'rigrunner resume RUN' resumes it, 'rigrunner recover RUN' closes it as it is.")


def _row(run: ListedRun) -> list[str]:
    if run.info is None:
        return [run.name, "unreadable", "-"]
    return [run.name, run.state, str(len(run.info.recording_names))]


def _document(run: ListedRun) -> dict[str, Any]:
    if run.info is None:
        return {"run": run.name, "problem": run.problem}
    return {**info_document(run.info), "in_progress": run.is_in_progress}
