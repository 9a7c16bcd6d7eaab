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
        return not any(each.matters for each in self.changes)


def compare(before: str, after: str, runs: Path) -> Comparison:
    """Compare two procedures, or two runs in the folder of runs.

    Raises UsageError if an argument names neither, or they name one of each; InvalidFileError and
    DataError for files that cannot be read.
    """
    first, second = _procedure(before), _procedure(after)
    if first and second:
        return compare_procedures(load_procedure(first), load_procedure(second))
    if not first and not second:
        return compare_runs(_run(before, runs), _run(after, runs))
    procedure, other = (before, after) if first else (after, before)
    _run(other, runs)
    message = f"'{procedure}' is a procedure, and '{other}' is a run"
    raise UsageError(message, hint="name two procedures, or two runs")


def compare_runs(before: Path, after: Path) -> Comparison:
    """Compare two stored runs; raise DataError for one that cannot be read."""
    first, second = read(before), read(after)
    return Comparison(
        _named(first.header),
        _named(second.header),
        tuple(run_changes(first, second)),
        "no relevant difference",
    )


def compare_procedures(before: LoadedProcedure, after: LoadedProcedure) -> Comparison:
    """Compare two loaded procedures."""
    return _of_texts(_described(before), _texts(before), _described(after), _texts(after))


def compare_with_run(run: RunHeader, after: LoadedProcedure) -> Comparison:
    """Compare the stored procedure of a run with a current one."""
    return _of_texts(_named(run), texts_of(run), _described(after), _texts(after))


def _procedure(word: str) -> Path | None:
    """Return the procedure file that an argument names, or None."""
    try:
        path = find_procedure(word)
    except UsageError:
        return None
    return path if path.suffix in {".yaml", ".yml"} else None


def _run(word: str, runs: Path) -> Path:
    try:
        return find_run(word, runs)
    except UsageError as error:
        message = f"there is no procedure and no run '{word}'"
        raise UsageError(message, hint=error.message) from error


def _of_texts(before: str, first: ProcedureTexts, after: str, second: ProcedureTexts) -> Comparison:
    if first.text == second.text and first.called == second.called:
        verdict = "no difference: the texts are the same"
    else:
        verdict = "the only differences are in comments, layout or notation"
    return Comparison(before, after, tuple(procedure_changes(first, second)), verdict)


def _texts(loaded: LoadedProcedure) -> ProcedureTexts:
    return ProcedureTexts(loaded.document.name, loaded.text, loaded.called_texts)


def _described(loaded: LoadedProcedure) -> str:
    model, state = loaded.model, approval_state(loaded)
    return f"{loaded.document.name}: {model.id}, revision {model.revision}; {state.sentence()}"


def _named(header: RunHeader) -> str:
    return f"{header.run_id}: {header.procedure_id}, {header.started_utc[:16]}"


def run_changes(before: StoredRun, after: StoredRun) -> Iterator[Change]:
    """Yield the differences of two runs, except their dates.

    The results come first, then what matters. Results that differ by no more than their combined
    uncertainty are listed, but do not matter.
    """
    found = list(_changes(before, after))
    order = dict.fromkeys(each.section for each in found)
    heavy = {each.section for each in found if each.matters}
    sections = sorted(order, key=lambda name: (name != RESULTS, name not in heavy))
    for section in sections:
        ours = (each for each in found if each.section == section)
        yield from sorted(ours, key=lambda each: not each.matters)


def _changes(before: StoredRun, after: StoredRun) -> Iterator[Change]:
    first, second = before.header, after.header
    yield from procedure_changes(texts_of(first), texts_of(second))
    yield from changes("state of the procedure", _state(first), _state(second))
    station, other = (parse(each.station_text, each.station_id).data for each in (first, second))
    for key in _STATION:
        if key == "instruments":  # without a register the instruments are listed as added
            yield from changes(key, station.get(key, []), other.get(key, []))
        else:
            yield from changes(f"station, {key}", station.get(key), other.get(key))
    yield from changes("inputs", dict(first.inputs), dict(second.inputs))
    yield from changes("people", dict(first.people), dict(second.people))
    yield from changes("programs and devices", dict(first.provenance), dict(second.provenance))
    yield from changes("outcome", before.info.outcome, after.info.outcome)
    names, other_names = (list(each.info.recording_names) for each in (before, after))
    yield from changes("recordings", names, other_names)
    for name in {**before.partners, **after.partners}:
        partners = [each.partners.get(name) for each in (before, after)]
        had, has = (each and each.header.run_id for each in partners)
        for each in changes(partner_words(name), had, has):
            # another partner run matters only by its effect on the results
            yield replace(each, matters=None in partners)
    registers = [_register(each) for each in (first, second)]
    channels = [name for name, each in registers[0].items() if registers[1].get(name) == each]
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
