"""Stored runs: history, one run, its files, comparison."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any

from rigrunner.run.interrupted import recover
from rigrunner.runfile import read
from rigrunner.tools.comparing.compare import compare_runs
from rigrunner_panel.errors import not_found
from rigrunner_panel.web.answers import Again, ChangeView, ComparisonAnswer, Done, OneRun, Runs

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner_panel.catalogue import What
    from rigrunner_panel.history import RunItem
    from rigrunner_panel.web.operation import ApiRequest
    from rigrunner_panel.web.panel import Panel
    from rigrunner_panel.web.requests import Why

MOST = 200
_EXACT = ("procedure", "station", "outcome", "verdict")


def runs(panel: Panel, request: ApiRequest) -> Runs:
    """Return the stored runs that match the query, newest first."""
    query = request.query
    limit_text = query.get("limit", "")
    is_number = limit_text.isascii() and limit_text.isdigit()
    limit = min(max(int(limit_text), 1), MOST) if is_number else 50
    before = query.get("before", "")
    matching = (
        item
        for item in panel.history.items()
        if (not before or item.run < before) and _fits(item, query)
    )
    items = list(islice(matching, limit + 1))
    return Runs(items=items[:limit], more=len(items) > limit)


def run(panel: Panel, request: ApiRequest) -> OneRun:
    """Return one run, with its result and the addresses of its files."""
    name = request.path["run"]
    detail = panel.history.detail(name)
    links = panel.links(name, panel.history.files(name))
    return OneRun(**dict(detail), files=links)


def again(panel: Panel, request: ApiRequest) -> Again:
    """Return procedure, station and inputs for the next specimen."""
    header = read(panel.history.folder(request.path["run"])).header
    inputs = {name: text for name, text in header.inputs.items() if name != "specimen"}
    return Again(
        procedure=named_file(panel, "procedure", header.procedure_id, header.procedure_text),
        station=named_file(panel, "station", header.station_id, header.station_text),
        inputs=inputs,
        operator=header.people.get("operator") or header.inputs.get("operator", ""),
    )


def recover_stored(panel: Panel, request: ApiRequest) -> Done:
    """Close an interrupted run as it is."""
    body: Why = request.body
    recover(panel.history.folder(request.path["run"]), panel.clock, request.by, body.reason.strip())
    return Done()


def compare(panel: Panel, request: ApiRequest) -> ComparisonAnswer:
    """Return in words what is different between two runs."""
    folders = (panel.history.folder(request.query.get(key, "")) for key in ("before", "after"))
    comparison = compare_runs(*folders)
    return ComparisonAnswer(
        before=comparison.before,
        after=comparison.after,
        same=comparison.same,
        verdict=comparison.verdict if comparison.same else "",
        changes=[
            ChangeView(section=change.section, text=change.text, matters=change.matters)
            for change in comparison.changes
        ],
    )


def file(panel: Panel, request: ApiRequest) -> Path:
    """Return a file of a run."""
    return panel.history.file(request.path["run"], request.path["name"])


def picture(panel: Panel, request: ApiRequest) -> Path:
    """Return the picture of a prompt."""
    path = panel.pictures.get(request.path["key"])
    if path is None or not path.is_file():
        raise not_found("there is no such picture", "is the file beside the procedure?")
    return path


def named_file(panel: Panel, what: What, identity: str, text: str) -> str:
    """Return the name of a run's procedure or station: with the same text, or else the same id.

    Empty if there is none. Two files of one id are two versions, or two benches.
    """
    candidates = [entry for entry in panel.catalogue.entries(what) if entry.id == identity]
    candidates.sort(key=lambda entry: entry.path.read_bytes().decode("utf-8", "replace") != text)
    return candidates[0].name if candidates else ""


def _fits(item: RunItem, query: Mapping[str, str]) -> bool:
    fields: dict[str, Any] = item.model_dump()
    if any(query.get(key) and fields[key] != query[key] for key in _EXACT):
        return False
    text = " ".join(str(value) for value in fields.values()).casefold()
    return all(word in text for word in query.get("search", "").casefold().split())
