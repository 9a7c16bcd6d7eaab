"""`rigrunner show`: what a stored run holds and found."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import DataError
from rigrunner.api.results import REPLAYED
from rigrunner.cli.facts import info_document
from rigrunner.cli.measured import measured
from rigrunner.cli.options import json_option, run_argument, runs_option
from rigrunner.cli.output import message, result, result_json
from rigrunner.cli.summary import summary
from rigrunner.cli.table import pairs
from rigrunner.workflow.locate import find_run

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.results import LaterDecision
    from rigrunner.runfile import StoredRun
    from rigrunner.workflow.decisions import DecisionFile


@click.command(name="show")
@run_argument
@runs_option
@json_option
def command(run: str, runs: Path, *, as_json: bool) -> None:
    """Show what a stored run holds and found.

    RUN is a run folder, its run.h5, or the beginning of its name in the folder of runs.
    """
    from rigrunner.workflow.decisions import later_decisions
    from rigrunner.workflow.stored import open_run

    found = find_run(run, runs)
    stored = open_run(found).stored
    later: tuple[DecisionFile, ...] = ()
    problem = ""
    try:
        later = later_decisions(stored, found if found.is_dir() else found.parent)
    except DataError as error:
        problem = str(error)
    if as_json:
        result_json(
            {**_document(stored), "later_decisions": [dict(each.document) for each in later]}
        )
        return
    result(pairs(list(_facts(stored))))
    if stored.measurements:
        result(f"\n{measured(stored.measurements)}")
    if stored.result_document is not None:
        result(f"\n{summary(stored.result_document)}")
    if later:
        result(f"\n{pairs([_later(each.summary) for each in later])}")
    for note in (*stored.notes, *([problem] if problem else [])):
        message(f"note: {note}")


def _later(found: LaterDecision) -> tuple[str, str]:
    words = f"{found.verdict.upper()} by {found.by}, {found.decided_utc}: {found.why}"
    return f"decided again in {found.file}", f"{words} ({found.rule}; {found.limit_text})"


def _facts(stored: StoredRun) -> Iterator[tuple[str, str]]:
    header, info = stored.header, stored.info
    yield "run", header.run_id
    yield (
        "procedure",
        f"{header.procedure_title} ({header.procedure_id} {header.procedure_revision})",
    )
    yield "station", header.station_id
    if tape := header.provenance.get(REPLAYED):
        yield "replayed from", f"{tape}; not for certification"
    yield "started", header.started_utc
    yield "ended", info.ended_utc or "never"
    yield "outcome", f"{info.outcome}: {info.reason}" if info.reason else info.outcome
    yield "sealed", "yes" if info.sealed else "no"
    yield from header.inputs.items()
    if header.imported:
        yield "imported", _imported(header.imported)
    yield "recordings", _recordings(info.recording_names)
    if stored.no_load is not None:
        yield "no-load run", stored.no_load.header.run_id
    yield "SHA-256", stored.digest


def _imported(imported: Mapping[str, str]) -> str:
    files = sum(name.startswith("file ") for name in imported)
    return (
        f"recorded by {imported.get('program')}; read by {imported.get('importer')} from {files}"
        f" file{'s' if files > 1 else ''} on {imported.get('utc', '')[:10]};"
        f" {imported.get('by')} answers for {imported.get('mapping')}"
    )


def _recordings(names: Sequence[str]) -> str:
    return f"{len(names)}, from {names[0]} to {names[-1]}" if names else "none"


def _document(stored: StoredRun) -> dict[str, Any]:
    return {
        **info_document(stored.info),
        "zeros": dict(stored.zeros),
        "measurements": [asdict(each) for each in stored.measurements],
        "provenance": dict(stored.header.provenance),
        "imported": dict(stored.header.imported),
        "no_load_run": None if stored.no_load is None else info_document(stored.no_load.info),
        "result": stored.result_document,
    }
