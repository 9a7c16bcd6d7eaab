"""Differences of two stored runs: results, actions, equipment and people."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.analysis.requirements import partner_words
from rigrunner.tools.comparing.procedures import ProcedureTexts, procedure_changes
from rigrunner.tools.comparing.results import SECTION as RESULTS
from rigrunner.tools.comparing.results import result_changes
from rigrunner.tools.comparing.tree import Change, changes
from rigrunner.yamlfile import parse

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.runfile import RunHeader, StoredRun

_STATION = ("id", "rig", "devices", "plugins", "instruments")


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
    yield from _of_stations(first, second)
    yield from changes("inputs", dict(first.inputs), dict(second.inputs))
    yield from changes("people", dict(first.people), dict(second.people))
    yield from changes("programs and devices", dict(first.provenance), dict(second.provenance))
    yield from changes("outcome", before.info.outcome, after.info.outcome)
    yield from _of_recordings(before, after)
    for name in {**before.partners, **after.partners}:
        yield from _of_partners(name, before.partners.get(name), after.partners.get(name))
    yield from result_changes(before.result_document, after.result_document)


def texts_of(header: RunHeader) -> ProcedureTexts:
    """Return the procedure of a run as it was stored."""
    return ProcedureTexts(header.procedure_id, header.procedure_text, header.called_texts)


def _state(header: RunHeader) -> str:
    approval = header.approval
    by = f" by {approval['by']}" if approval.get("by") else ""
    return f"{approval.get('state', 'draft')}{by}"


def _of_stations(before: RunHeader, after: RunHeader) -> Iterator[Change]:
    first, second = (parse(each.station_text, each.station_id).data for each in (before, after))
    for key in _STATION:
        section = key if key == "instruments" else f"station, {key}"
        empty: list[object] | None = [] if key == "instruments" else None
        yield from changes(section, first.get(key, empty), second.get(key, empty))


def _of_recordings(before: StoredRun, after: StoredRun) -> Iterator[Change]:
    first, second = before.info.recording_names, after.info.recording_names
    yield from changes("recordings", list(first), list(second))


def _of_partners(name: str, before: StoredRun | None, after: StoredRun | None) -> Iterator[Change]:
    """Report another partner run. It matters only by its effect on the results."""
    first, second = (each and each.header.run_id for each in (before, after))
    for each in changes(partner_words(name), first, second):
        yield replace(each, matters=before is None or after is None)
