"""The identification of a run: procedure, station, specimen, instruments, settings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING

from rigrunner.api.analysis.requirements import partner_words
from rigrunner.api.events import Outcome
from rigrunner.api.results import REPLAYED
from rigrunner_reports.section import Section

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rigrunner.api import RunData
    from rigrunner.api.results import Result

APPROVED = "approved"
OVERRIDE = "override"
STEP = " \N{SINGLE RIGHT-POINTING ANGLE QUOTATION MARK} "
"""Separates the parts of a setting's path."""

FIRST, LAST = 200, 100
"""The first and the last events that are shown of very many; the run's log has all."""

Facts = tuple[tuple[str, str], ...]


def facts(result: Result) -> Facts:
    """Return the facts at the head of the report."""
    run, approval = result.run, result.run.approval
    state = "draft, not for certification"
    if approval.get("state") == APPROVED:
        state = f"approved by {approval['by']} on {approval['utc'][:10]}"
    started, ended = moment(run.started_utc), moment(run.ended_utc)
    day = len("2026-01-31 ")
    performed = f"{started} to {ended[day:] if ended[:day] == started[:day] else ended} UTC"
    pairs = [
        ("Run", run.run_id),
        ("Procedure", f"{run.procedure_id}, revision {run.procedure_revision}"),
        ("State", state),
        ("Station", run.station_id + (f", mandrel {run.mandrel}" if run.mandrel else "")),
        ("Performed", performed),
        *((name.capitalize(), value) for name, value in {**run.inputs, **run.people}.items()),
        ("Outcome", run.outcome),
    ]
    partners = run.partners.items()
    pairs += [(_capital(partner_words(name)), partner.run_id) for name, partner in partners]
    return tuple(pairs)


def warnings(result: Result) -> tuple[str, ...]:
    """Return the warnings above the main number: a run that did not end as it should."""
    runs = [(_capital(name), run) for name, run in _runs(result)]
    return tuple(
        f"{name} stopped at a limit: what the procedure does after it was not measured."
        if run.outcome == Outcome.STOPPED_AT_LIMIT
        else f"{name} ended as '{run.outcome}', not as completed: it is not a full test."
        for name, run in runs
        if run.outcome != Outcome.COMPLETED
    )


def shown_events(events: Sequence[Mapping[str, str]]) -> tuple[Mapping[str, str], ...]:
    """Return the events to show: all, or the first and the last, and the number between."""
    between = events[FIRST:-LAST]
    if not between:
        return tuple(events)
    kinds = ", ".join(
        f"{count} of kind '{kind}'"
        for kind, count in Counter(event["kind"] for event in between).items()
    )
    gap = {"utc": "", "kind": "more", "text": f"{len(between)} more: {kinds}; run.log has all"}
    return (*events[:FIRST], gap, *events[-LAST:])


def replay_warning(provenance: Mapping[str, str]) -> tuple[str, ...]:
    """Return the warning that the run is no measurement, if it is a replay."""
    if not provenance.get(REPLAYED):
        return ()
    words = "this run is a replay, and no instrument was asked; Provenance names its tape"
    return (f"Not for certification: {words}.",)


def restrictions(result: Result) -> tuple[str, ...]:
    """Return the restrictions on the use of the run, if its procedure was not approved."""
    texts = []
    for name, run in _runs(result):
        if run.approval.get("state") != APPROVED:
            note = run.approval.get("note", "")
            reason = f" ({note})" if note else ""
            texts.append(f"Not for certification: the procedure of {name} was a draft{reason}.")
    return tuple(texts)


def import_notes(result: Result) -> tuple[str, ...]:
    """Return who made imported recordings, and who is responsible for the rest."""
    runs: dict[tuple[str, str], list[str]] = {}
    for name, run in _runs(result):
        if run.imported:
            whose = run.imported.get("program", ""), run.imported.get("by", "")
            runs.setdefault(whose, []).append(name)
    return tuple(
        f"{program} made the recordings of {' and of '.join(names)}, not Rigrunner. Set-points,"
        f" conditions, zeros and times are as {by} states them; what else the procedure asks for"
        " was not seen."
        for (program, by), names in runs.items()
    )


def _runs(result: Result) -> tuple[tuple[str, RunData], ...]:
    """Return the run and its partner runs, as text."""
    partners = ((f"the {partner_words(name)}", run) for name, run in result.run.partners.items())
    return (("this run", result.run), *partners)


def _capital(words: str) -> str:
    return words[0].upper() + words[1:]


def overrides(events: Iterable[Mapping[str, str]]) -> tuple[str, ...]:
    """Return the overrides before the run, with person and reason."""
    return tuple(event["text"] for event in events if event["kind"] == OVERRIDE)


def moment(utc: str) -> str:
    """Return '2026-03-02 09:15:00' for an ISO time."""
    return utc[:19].replace("T", " ")


def settings(result: Result) -> Facts:
    """Return the settings of the analysis, one per line; without a method, those that are given."""
    chosen = result.settings
    if not chosen.get("primary"):
        chosen = {key: value for key, value in chosen.items() if value}
    return tuple(_flat(chosen, ()))


def _flat(value: object, path: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """Yield (path, text); a plugin {name, settings} adds its name to the path."""
    if isinstance(value, Mapping) and set(value) == {"name", "settings"}:
        inner = tuple(_flat(value["settings"], (*path, str(value["name"]))))
        yield from inner or ((STEP.join(path), str(value["name"])),)
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from _flat(item, (*path, str(key)))
    elif isinstance(value, list | tuple) and any(isinstance(item, Mapping) for item in value):
        for item in value:
            yield from _flat(item, path)
    else:
        yield STEP.join(path), _text(value)


def _text(value: object) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_text(item) for item in value) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "none" if value is None else f"{value:.12g}" if isinstance(value, float) else str(value)


SECTIONS = (
    Section("run", "The run", 110, lambda _, page: page),
    Section("provenance", "Provenance", 120, lambda _, page: page),
)
