"""The stored runs: search, details and files."""

from __future__ import annotations

import json
from math import nan
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from rigrunner.analysis.verdict.document import verdict_in
from rigrunner.run.finish import RESULT_FILE
from rigrunner.run.locate import run_names
from rigrunner.run.log import event_text
from rigrunner.run.runs import listed_run
from rigrunner.run.set_points import other_results, results_in
from rigrunner.run.stored import run_data
from rigrunner.runfile import read
from rigrunner_panel.errors import not_found
from rigrunner_panel.view.result import with_uncertainty
from rigrunner_panel.view.sections import Value

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


SHOWN = (".html", ".json", ".pdf", ".h5", ".log", ".svg", ".txt")
"""The files of a run's folder that may be downloaded."""


class RunItem(BaseModel):
    """One row of the history."""

    run: str
    state: str
    problem: str = ""
    procedure: str = ""
    title: str = ""
    station: str = ""
    specimen: str = ""
    operator: str = ""
    started_utc: str = ""
    outcome: str = ""
    interrupted: bool = False
    """Whether it is not sealed and not running: it can be resumed, or closed as it is."""
    verdict: str = ""
    headline: Value | None = None
    result: str = ""
    """For a run without a headline: the decisive or only named result, with its U."""


class RunDetail(BaseModel):
    """One stored run."""

    item: RunItem
    inputs: dict[str, str]
    people: dict[str, str]
    approval: dict[str, str]
    ended_utc: str
    reason: str
    sealed: bool
    recordings: tuple[str, ...]
    digest_sha256: str
    result: dict[str, Any] | None
    events: tuple[dict[str, str], ...]
    notes: tuple[str, ...]


class History:
    """The runs in one folder. Data of sealed runs are cached, because they do not change."""

    def __init__(self, runs: Path) -> None:
        self.runs = runs
        self._cache: dict[str, tuple[int, RunItem]] = {}
        """By name: when the run's file was changed, in ns, and its row."""

    def items(self) -> Iterator[RunItem]:
        """Yield all runs, newest first."""
        names = run_names(self.runs)
        for removed in set(self._cache).difference(names):
            self._cache.pop(removed, None)  # another thread may have done it
        for name in reversed(names):
            yield self.item(name)

    def folder(self, run: str) -> Path:
        """Return the folder of a listed run; raise PanelError."""
        if run not in run_names(self.runs):
            raise not_found(f"there is no run '{run[:80]}'", "see GET /api/v1/runs")
        return self.runs / run

    def detail(self, run: str) -> RunDetail:
        """Return everything about a run except its samples; raise PanelError or DataError."""
        stored = read(self.folder(run))
        document = stored.result_document
        events = ((event.utc, event_text(event)) for event in stored.events)
        return RunDetail(
            item=self.item(run),
            inputs=dict(stored.header.inputs),
            people=dict(run_data(stored).people),
            approval=dict(stored.header.approval),
            ended_utc=stored.info.ended_utc,
            reason=stored.info.reason,
            sealed=stored.info.sealed,
            recordings=stored.info.recording_names,
            digest_sha256=stored.digest,
            result=None if document is None else {**document, "results": results_in(document)},
            events=tuple({"utc": utc, "text": text} for utc, text in events if text),
            notes=stored.notes,
        )

    def files(self, run: str) -> list[Path]:
        """Return the files of a run that may be downloaded."""
        folder = self.folder(run)
        return [path for path in sorted(folder.iterdir()) if self._is_shown(path)]

    def file(self, run: str, name: str) -> Path:
        """Return one of these files, never one outside the run's folder; raise PanelError."""
        for path in self.files(run):
            if path.name == name:
                return path
        raise not_found(f"run {run[:80]} has no file '{name[:80]}'")

    def _is_shown(self, path: Path) -> bool:
        inside = path.resolve().is_relative_to(self.runs.resolve())
        return inside and path.is_file() and path.suffix in SHOWN and path.name[:1] != "."

    def item(self, name: str) -> RunItem:
        """Return one row of the history."""
        sealed = self.runs / name / "run.h5"
        changed_ns = sealed.stat().st_mtime_ns if sealed.is_file() else 0
        cached_ns, item = self._cache.get(name, (0, None))
        if item is None or cached_ns != changed_ns:
            item = _item(self.runs, name)
            if changed_ns:
                self._cache[name] = changed_ns, item
        return item


def _item(runs: Path, name: str) -> RunItem:
    listed = listed_run(runs, name)
    if listed.info is None:
        return RunItem(run=name, state=listed.state, problem=listed.problem)
    header = listed.info.header
    verdict, headline, result = _result(runs / name / RESULT_FILE)
    return RunItem(
        run=name,
        state=listed.state,
        procedure=header.procedure_id,
        title=header.procedure_title,
        station=header.station_id,
        specimen=header.inputs.get("specimen", ""),
        operator=header.people.get("operator") or header.inputs.get("operator", ""),
        started_utc=header.started_utc,
        outcome=listed.info.outcome if listed.info.sealed else "",
        interrupted=listed.is_interrupted,
        verdict=verdict,
        headline=headline,
        result=result,
    )


def _result(path: Path) -> tuple[str, Value | None, str]:
    """Return verdict, headline and named result from a run's result.json, if readable."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        verdict, value = verdict_in(document), document["headline"]["compensated"]
        if value is None:
            return verdict, None, _deciding_text(document)
        fields = {"value": value["value"], "U": value["expanded_uncertainty_95"]}
        fields |= {"unit": value["unit"]}
        return verdict, Value(**fields), ""
    except (OSError, ValueError, KeyError, TypeError):
        return "", None, ""


def _deciding_text(document: dict[str, Any]) -> str:
    estimate, results = (document.get("decision") or {}).get("result"), other_results(document)
    results = [result for result in results if result["estimate"] == estimate] or results
    if len(results) != 1:
        return ""
    estimate, width = results[0]["estimate"], results[0]["estimate"]["expanded_uncertainty_95"]
    shown = with_uncertainty(estimate["value"], nan if width is None else width)
    return f"{results[0]['name']}: {shown} {estimate['unit']}"
