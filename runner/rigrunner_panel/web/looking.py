"""Stored runs: history, one run, its files, comparison."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any

from rigrunner.run.interrupted import recover
from rigrunner.runfile import read
from rigrunner.tools.comparing.compare import compare_runs
from rigrunner_panel.errors import not_found
from rigrunner_panel.web.answers import (
    Again,
    ChangeView,
    ComparisonAnswer,
    Done,
    OneRun,
    Runs,
)

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner_panel.catalogue import What
    from rigrunner_panel.history import RunItem
    from rigrunner_panel.web.asked import Asked
    from rigrunner_panel.web.panel import Panel
    from rigrunner_panel.web.requests import Why

MOST = 200
_EXACT = ("procedure", "station", "outcome", "verdict")


def runs(panel: Panel, asked: Asked) -> Runs:
    """Return the stored runs that are looked for, newest first."""
    query = asked.query
    asked_for = query.get("limit", "")
    is_number = asked_for.isascii() and asked_for.isdigit()
    limit = min(max(int(asked_for), 1), MOST) if is_number else 50
    before = query.get("before", "")
    found = (
        each
        for each in panel.history.items()
        if (not before or each.run < before) and _fits(each, query)
    )
    items = list(islice(found, limit + 1))
    return Runs(items=items[:limit], more=len(items) > limit)


def run(panel: Panel, asked: Asked) -> OneRun:
    """Return one run, with its result and the addresses of its files."""
    name = asked.path["run"]
    detail = panel.history.detail(name)
    links = panel.links(name, panel.history.files(name))
    return OneRun(**dict(detail), files=links)


def again(panel: Panel, asked: Asked) -> Again:
    """Return what the next specimen is started with."""
    header = read(panel.history.folder(asked.path["run"])).header
    inputs = {name: text for name, text in header.inputs.items() if name != "specimen"}
    return Again(
        procedure=named_file(panel, "procedure", header.procedure_id, header.procedure_text),
        station=named_file(panel, "station", header.station_id, header.station_text),
        inputs=inputs,
        operator=header.people.get("operator") or header.inputs.get("operator", ""),
    )


def recover_stored(panel: Panel, asked: Asked) -> Done:
    """Close an interrupted run as it is."""
    body: Why = asked.body
    recover(panel.history.folder(asked.path["run"]), panel.clock, asked.by, body.reason.strip())
    return Done()


def compare(panel: Panel, asked: Asked) -> ComparisonAnswer:
    """Return in words what is different between two runs."""
    first, second = (panel.history.folder(asked.query.get(key, "")) for key in ("before", "after"))
    found = compare_runs(first, second)
    return ComparisonAnswer(
        before=found.before,
        after=found.after,
        same=found.same,
        verdict=found.verdict if found.same else "",
        changes=[
            ChangeView(section=each.section, text=each.text, matters=each.matters)
            for each in found.changes
        ],
    )


def file(panel: Panel, asked: Asked) -> Path:
    """Return a file of a run."""
    return panel.history.file(asked.path["run"], asked.path["name"])


def picture(panel: Panel, asked: Asked) -> Path:
    """Return the picture of a prompt."""
    found = panel.pictures.get(asked.path["key"])
    if found is None or not found.is_file():
        raise not_found("there is no such picture", "is the file beside the procedure?")
    return found


def named_file(panel: Panel, what: What, identity: str, text: str) -> str:
    """Return the file that a run was made with: the same text, or else the first of that id.

    Empty where there is none. Two files of one id are two versions, or two benches.
    """
    fitting = [each for each in panel.catalogue.entries(what) if each.id == identity]
    same = [each for each in fitting if each.path.read_bytes().decode("utf-8", "replace") == text]
    return next((each.name for each in (*same, *fitting)), "")


def _fits(item: RunItem, query: Mapping[str, str]) -> bool:
    told: dict[str, Any] = item.model_dump()
    if any(query.get(key) and told[key] != query[key] for key in _EXACT):
        return False
    text = " ".join(str(each) for each in told.values()).casefold()
    return all(word in text for word in query.get("search", "").casefold().split())
