"""Compare what two arguments name: two procedures, or two stored runs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner.api.analysis.requirements import partner_words
from rigrunner.api.errors import UsageError
from rigrunner.procedure import load_procedure
from rigrunner.run.approval import approval_state
from rigrunner.run.locate import find_procedure, find_run
from rigrunner.runfile import read
from rigrunner.station import parse_station
from rigrunner.tools.comparing.procedures import ProcedureTexts, procedure_changes
from rigrunner.tools.comparing.results import SECTION as RESULTS
from rigrunner.tools.comparing.results import result_changes
from rigrunner.tools.comparing.tree import Change, changes
from rigrunner.yamlfile import parse

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from rigrunner.api.instruments import Instrument
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.runfile import RunHeader, StoredRun

_STATION = ("id", "rig", "devices", "plugins", "instruments")


@dataclass(frozen=True)
class Comparison:
    """What was compared, and the differences."""

    before: str
    """Names the first one."""
    after: str
    changes: tuple[Change, ...]
    verdict: str
    """The conclusion where nothing that matters is different."""

    @property
    def same(self) -> bool:
        """Whether nothing that matters is different."""
        return not any(change.matters for change in self.changes)


def compare(before: str, after: str, runs: Path) -> Comparison:
    """Compare two procedures, or two runs in the folder of runs.

    Raises UsageError if an argument names neither, or they name one of each; InvalidFileError and
    DataError for files that cannot be read.
    """
    first, second = _find_procedure(before), _find_procedure(after)
    if first and second:
        return compare_procedures(load_procedure(first), load_procedure(second))
    if not first and not second:
        return compare_runs(_find_run(before, runs), _find_run(after, runs))
    procedure, run = (before, after) if first else (after, before)
    _find_run(run, runs)
    message = f"'{procedure}' is a procedure, and '{run}' is a run"
    raise UsageError(message, hint="name two procedures, or two runs")


def compare_runs(before: Path, after: Path) -> Comparison:
    """Compare two stored runs; raise DataError for one that cannot be read."""
    first, second = read(before), read(after)
    return Comparison(
        _run_title(first.header),
        _run_title(second.header),
        tuple(run_changes(first, second)),
        "no relevant difference",
    )


def compare_procedures(before: LoadedProcedure, after: LoadedProcedure) -> Comparison:
    """Compare two loaded procedures."""
    return _compare_texts(_description(before), _texts(before), _description(after), _texts(after))


def compare_with_run(run: RunHeader, after: LoadedProcedure) -> Comparison:
    """Compare the stored procedure of a run with a current one."""
    return _compare_texts(_run_title(run), texts_of(run), _description(after), _texts(after))


def _find_procedure(word: str) -> Path | None:
    """Return the procedure file that an argument names, or None."""
    try:
        path = find_procedure(word)
    except UsageError:
        return None
    return path if path.suffix in {".yaml", ".yml"} else None


def _find_run(word: str, runs: Path) -> Path:
    try:
        return find_run(word, runs)
    except UsageError as error:
        message = f"there is no procedure and no run '{word}'"
        raise UsageError(message, hint=error.message) from error


def _compare_texts(
    before: str, first: ProcedureTexts, after: str, second: ProcedureTexts
) -> Comparison:
    if first.text == second.text and first.called == second.called:
        verdict = "no difference: the texts are the same"
    else:
        verdict = "the only differences are in comments, layout or notation"
    return Comparison(before, after, tuple(procedure_changes(first, second)), verdict)


def _texts(loaded: LoadedProcedure) -> ProcedureTexts:
    return ProcedureTexts(loaded.document.name, loaded.text, loaded.called_texts)


def _description(loaded: LoadedProcedure) -> str:
    model, state = loaded.model, approval_state(loaded)
    return f"{loaded.document.name}: {model.id}, revision {model.revision}; {state.sentence()}"


def _run_title(header: RunHeader) -> str:
    return f"{header.run_id}: {header.procedure_id}, {header.started_utc[:16]}"


def run_changes(before: StoredRun, after: StoredRun) -> Iterator[Change]:
    """Yield the differences of two runs, except their dates.

    The results come first, then what matters. Results that differ by no more than their combined
    uncertainty are listed, but do not matter.
    """
    differences = list(_changes(before, after))
    order = dict.fromkeys(change.section for change in differences)
    relevant = {change.section for change in differences if change.matters}
    sections = sorted(order, key=lambda name: (name != RESULTS, name not in relevant))
    for section in sections:
        section_changes = (change for change in differences if change.section == section)
        yield from sorted(section_changes, key=lambda change: not change.matters)


def _changes(before: StoredRun, after: StoredRun) -> Iterator[Change]:
    first, second = before.header, after.header
    yield from procedure_changes(texts_of(first), texts_of(second))
    yield from changes("state of the procedure", _state(first), _state(second))
    first_station = parse(first.station_text, first.station_id).data
    second_station = parse(second.station_text, second.station_id).data
    for key in _STATION:
        if key == "instruments":  # without a register the instruments are listed as added
            yield from changes(key, first_station.get(key, []), second_station.get(key, []))
        else:
            yield from changes(f"station, {key}", first_station.get(key), second_station.get(key))
    yield from changes("inputs", dict(first.inputs), dict(second.inputs))
    yield from changes("people", dict(first.people), dict(second.people))
    yield from changes("programs and devices", dict(first.provenance), dict(second.provenance))
    yield from changes("outcome", before.info.outcome, after.info.outcome)
    names, other_names = (list(run.info.recording_names) for run in (before, after))
    yield from changes("recordings", names, other_names)
    for name in {**before.partners, **after.partners}:
        partners = [run.partners.get(name) for run in (before, after)]
        first_id, second_id = (partner and partner.header.run_id for partner in partners)
        for change in changes(partner_words(name), first_id, second_id):
            # another partner run matters only by its effect on the results
            yield replace(change, matters=None in partners)
    register, other = _register(first), _register(second)
    channels = [channel for channel in register if other.get(channel) == register[channel]]
    yield from result_changes(before.result_document, after.result_document, channels)


def _register(header: RunHeader) -> Mapping[str, Instrument]:
    """Return the calibrated instruments of a run, by their channels."""
    station = parse_station(header.station_text, header.station_id, stored=True)
    return station.register


def texts_of(header: RunHeader) -> ProcedureTexts:
    """Return the procedure of a run as it was stored."""
    return ProcedureTexts(header.procedure_id, header.procedure_text, header.called_texts)


def _state(header: RunHeader) -> str:
    approval = header.approval
    by = f" by {approval['by']}" if approval.get("by") else ""
    return f"{approval.get('state', 'draft')}{by}"
