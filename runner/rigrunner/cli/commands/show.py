"""`rigrunner show`: the content and results of a stored run."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import DataError, ExitCode
from rigrunner.api.events import Alarm
from rigrunner.api.results import REPLAYED
from rigrunner.api.summaries import pairs, table, table_cells
from rigrunner.cli.facts import info_document, salvaged_lines
from rigrunner.cli.options import json_option, run_argument, runs_option
from rigrunner.cli.output import message, result, result_json
from rigrunner.cli.summary import summary
from rigrunner.run.locate import find_run

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from rigrunner.api.data import Measurement
    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.readings import ReadingLimit
    from rigrunner.run.decisions import DecisionFile
    from rigrunner.runfile import StoredRun

MOST_ALARMS = 20
"""Alarms shown on a terminal. A step with many attempts may raise thousands."""


@click.command(name="show")
@run_argument
@runs_option
@json_option
def command(run: str, runs: Path, *, as_json: bool) -> ExitCode:
    """Show the recordings, events and results of a stored run.

    RUN is a run folder, its run.h5, or the beginning of its name in the folder of runs. For a
    damaged run it shows which recordings are intact and what is lost, with exit code 5.
    """
    from rigrunner.run.decisions import later_decisions
    from rigrunner.run.stored import open_run

    path = find_run(run, runs)
    try:
        stored = open_run(path).stored
    except DataError as error:
        return _show_damaged(path, error, as_json=as_json)
    notes = [*salvaged_lines(stored.header.salvaged), *stored.notes]
    later: tuple[DecisionFile, ...] = ()
    try:
        later = later_decisions(stored, path if path.is_dir() else path.parent)
    except DataError as error:
        notes.append(str(error))
    if as_json:
        result_json(
            {
                **info_document(stored.info),
                "zeros": dict(stored.zeros),
                "alarms": _alarms(stored),
                "measurements": [_row(row) for row in stored.measurements],
                "superseded_measurements": [_row(row) for row in stored.superseded_measurements],
                "provenance": dict(stored.header.provenance),
                "imported": dict(stored.header.imported),
                "partner_runs": {
                    name: info_document(run.info) for name, run in stored.partners.items()
                },
                "result": stored.result_document,
                "later_decisions": [dict(decision.document) for decision in later],
            }
        )
        return ExitCode.PASS
    result(pairs(list(_fact_rows(stored))))
    for name in dict.fromkeys(row.name for row in stored.measurements):
        rows = [row for row in stored.measurements if row.name == name]
        result(f"\nMeasured: {name}\n{_table_text(rows)}")
    if stored.superseded_measurements:
        count = len(stored.superseded_measurements)
        result(f"\nRows of repeated steps, not evaluated: {count} (--json prints them)")
    if stored.result_document is not None:
        result(f"\n{summary(stored.result_document)}")
    if later:
        decisions = []
        for decision in (file.summary for file in later):
            verdict, when = decision.verdict.upper(), decision.decided_utc
            words = f"{verdict} by {decision.by}, {when}: {decision.why}"
            rule = f"({decision.rule}; {decision.limit_text})"
            decisions.append((f"decided again in {decision.file}", f"{words} {rule}"))
        result(f"\n{pairs(decisions)}")
    for note in notes:
        message(f"note: {note}")
    return ExitCode.PASS


def _show_damaged(path: Path, error: DataError, *, as_json: bool) -> ExitCode:
    """Show the intact parts of a damaged run; raise the error if there are none."""
    from rigrunner.run.salvaging import damaged_run, lost_text

    try:
        damaged = damaged_run(path)
    except DataError:
        raise error from None
    if not damaged.lost:
        raise error
    lost = [(str(part.path), f"{part.kind}: {part.what}") for part in damaged.lost]
    if as_json:
        result_json(
            {
                "run": damaged.header.run_id,
                "path": str(damaged.path),
                "damaged": True,
                "sha256": damaged.sha256,
                "recordings": list(damaged.recordings),
                "lost": dict(lost),
            }
        )
        return ExitCode.DATA
    header = damaged.header
    facts = [
        ("run", header.run_id),
        ("procedure", header.procedure_title),
        ("station", header.station_id),
        ("started", header.started_utc),
        ("file", f"{damaged.path} is DAMAGED: {lost_text(damaged)}"),
        ("SHA-256 of the file", damaged.sha256),
        *((f"sound {place.partition('/')[0]}", name)
          for place, name in zip(damaged.sound, damaged.recordings, strict=True)),
    ]  # fmt: skip
    result(pairs([(name, text) for name, text in facts if text]))
    for name, text in lost:
        message(f"lost: {name}: {text}")
    message(
        f"hint: restore the file from a copy or a backup, or save the intact recordings:"
        f" 'rigrunner recover --salvage {header.run_id}'"
    )
    return ExitCode.DATA


def _fact_rows(stored: StoredRun) -> Iterator[tuple[str, str]]:
    from rigrunner.api.analysis.requirements import partner_words

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
    if imported := header.imported:
        files = sum(name.startswith("file ") for name in imported)
        words = (
            f"recorded by {imported.get('program')}; read by {imported.get('importer')}"
            f" from {files} file{'s' if files > 1 else ''} on {imported.get('utc', '')[:10]};"
            f" {imported.get('by')} answers for {imported.get('mapping')}"
        )
        yield "imported", words
    alarms = _alarms(stored)
    yield from (("alarm", text) for text in alarms[:MOST_ALARMS])
    if len(alarms) > MOST_ALARMS:
        yield "alarms", f"{len(alarms) - MOST_ALARMS} more: see --json"
    names = info.recording_names
    yield "recordings", f"{len(names)}, from {names[0]} to {names[-1]}" if names else "none"
    for name, run in stored.partners.items():
        yield partner_words(name), run.header.run_id
    yield "SHA-256 of the data", stored.digest


def _table_text(rows: Sequence[Measurement]) -> str:
    """Return the rows of one table as text, with their verdicts and limits if there are any."""
    header, cells = table_cells(rows)
    texts = len({member for row in rows for member in row.readings})
    align = "r" * (len(header) - texts) + "l" * texts
    limits: dict[ValueLimit | ReadingLimit, None] = {}
    for row in rows:
        limits |= dict.fromkeys(row.limits) | dict.fromkeys(row.expected)
    if limits:
        header, align = [*header, "verdict"], f"{align}l"
        for cell, row in zip(cells, rows, strict=True):
            missed = [decision.of for decision in row.decisions if not decision.passes]
            passed = "pass" if row.decisions else ""
            cell.append(f"FAIL: {', '.join(missed)}" if missed else passed)
    allowed = [f"{limit.of}: limit {limit.limits.in_words}" for limit in limits]
    return "\n".join([table(header, cells, align), *allowed])


def _alarms(stored: StoredRun) -> list[str]:
    """Return the failures and the messages of drivers, in order."""
    return [f"{alarm.source}: {alarm.text}" for alarm in stored.outline if isinstance(alarm, Alarm)]


def _row(row: Measurement) -> dict[str, Any]:
    limits = [
        {**asdict(limit), "verdict": str(limit.decision(row.values[limit.of]).verdict)}
        for limit in row.limits
        if limit.of in row.values
    ]
    return {**asdict(row), "limits": limits}
