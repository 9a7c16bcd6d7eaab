"""A batch of analyses: a folder with one result per run, a summary, and a journal."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError, UsageError
from rigrunner.jobs import journal
from rigrunner.run.lab_plugins import lab_registry, plugin_folders
from rigrunner.run.locate import find_station
from rigrunner.run.provenance import code_digest, software
from rigrunner.runfile.durable import writing
from rigrunner_fleet.reanalysis.summary import Summary, by_run, write_summary, write_text
from rigrunner_fleet.reanalysis.task import Reanalysis, Row

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from rigrunner.api.devices import StopToken
    from rigrunner.jobs import Workers
    from rigrunner_fleet.reanalysis.changes import Changes
    from rigrunner_fleet.reanalysis.selection import SelectedRun

DONE = "done.jsonl"
RESULT = "result.json"
TRACE = "traceback.txt"


@dataclass(frozen=True)
class Batch:
    """Analyses runs again: with what changes, and on which workers."""

    changes: Changes
    station: str | None
    """A station whose folder has plugins of its own."""
    workers: Workers
    stop: StopToken
    progress: Callable[[int, int], None]
    """Gets the number of finished runs, and of all; first those of an earlier call."""

    def run(self, runs: Sequence[SelectedRun], out: Path, *, raw: bool = False) -> Summary:
        """Analyse every run that is not finished in the folder, and return the outcomes of all.

        A failed run is listed, and the others continue; it is tried again the next time. With `raw`
        the summary has texts unchanged, even if a spreadsheet takes them for formulas. Raises
        UsageError if the folder holds something else, or results of other settings or software, and
        AbortedError once the token is set: finished results are kept.
        """
        if out.is_dir() and not (out / DONE).exists() and any(out.iterdir()):
            raise UsageError(
                f"{out} is not empty, and no batch of analyses is in it",
                hint="name a new folder",
            )
        station = None if self.station is None else str(find_station(self.station).resolve())
        versions = software(lab_registry(station))
        task = Reanalysis(self.changes, station, versions)
        failed: list[Row] = []
        # What a result depends on besides its run.
        code = code_digest(*plugin_folders(self.station))
        identity = {**versions, "code": code, "changes of the analysis": self.changes.describe()}
        with journal(out / DONE, identity) as finished:
            keys = {run: json.dumps([run.name, run.stamp]) for run in runs}
            remaining = [run for run in runs if keys[run] not in finished]
            done = len(runs) - len(remaining)
            self.progress(done, len(runs))
            for outcome in self.workers.outcomes(task, [run.path for run in remaining], self.stop):
                run = remaining[outcome.place]
                if outcome.answer.value is None:
                    _write(out / run.name, TRACE, outcome.answer.trace)
                    failed.append(Row(run=run.name, problem=outcome.problem))
                else:
                    _write(out / run.name, RESULT, outcome.answer.value.result)
                    finished.add(keys[run], {**outcome.answer.value.row, "run": run.name})
                done += 1
                self.progress(done, len(runs))
            rows = [Row(**finished[keys[run]]) for run in runs if keys[run] in finished]
        summary = Summary(tuple(rows), tuple(sorted(failed, key=by_run)), len(runs))
        write_summary(out, summary, raw=raw)
        if done < len(runs):
            raise AbortedError(
                f"{done} of {len(runs)} runs are done",
                hint=f"their results are in {out}: the same command continues with the rest",
            )
        return summary


def _write(folder: Path, name: str, text: str) -> None:
    """Write the result of a run in place of an earlier one, which is removed first."""
    with writing(folder):
        for old_name in (RESULT, TRACE):
            (folder / old_name).unlink(missing_ok=True)
    if text:
        write_text(folder / name, text)
