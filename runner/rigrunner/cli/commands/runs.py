"""`rigrunner runs`: list the stored runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.api.summaries import table
from rigrunner.cli.facts import info_document
from rigrunner.cli.options import json_option, runs_option
from rigrunner.cli.output import message, result, result_json

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="runs")
@runs_option
@json_option
def command(runs: Path, *, as_json: bool) -> None:
    """List the stored runs."""
    from rigrunner.cli.left_rig import show_all_left
    from rigrunner.run.runs import list_runs

    listed = list_runs(runs)
    if as_json:
        result_json(
            [
                {**info_document(run.info), "in_progress": run.is_in_progress}
                if run.info is not None
                else {"run": run.name, "problem": run.problem}
                for run in listed
            ]
        )
    elif not listed:
        missing = "" if runs.is_dir() else ": there is no such folder"
        message(f"There are no runs in {runs}{missing}.")
    else:
        rows = [
            [run.name, run.state, str(len(run.info.recording_names) or "-")]
            if run.info is not None
            else [run.name, "unreadable", "-"]
            for run in listed
        ]
        result(table(["run", "outcome", "recordings"], rows, "llr"))
    show_all_left()
    interrupted = [run.name for run in listed if run.is_interrupted]
    if interrupted:
        message(f"Interrupted: {', '.join(interrupted)}.")
        message("  'rigrunner resume RUN' resumes it, 'rigrunner recover RUN' closes it as it is.")
