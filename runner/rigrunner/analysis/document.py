"""The content of `result.json`: the numbers of a Result, each with its unit, nothing else.

Full precision (the shortest text that reads back as the same float), stable keys, no waveforms.
JSON has no NaN and no infinity: unknown is null with its reason beside it, infinite degrees of
freedom are the text "infinite".
"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from rigrunner.analysis.verdict.document import decision, limits, verdict
from rigrunner.api.partner_keys import KEYS, ONLY
from rigrunner.api.units import si_symbol
from rigrunner.signal.as_json.budget import budget
from rigrunner.signal.as_json.checks import checks_of
from rigrunner.signal.as_json.values import (
    coordinates_of,
    estimate,
    plain,
    quantity,
)

if TYPE_CHECKING:
    from rigrunner.api.data import RunData
    from rigrunner.api.findings import MeasurementResult, ResultDefinition
    from rigrunner.api.results import Result
    from rigrunner.signal.as_json.values import Json

FORMAT = "rigrunner: result/1"
ALWAYS: Json = {
    "headline": {"method": None, "compensated": None, "budget": [], "raw_peak": None},
    "points": [],
    "no_load_points": [],
    "compensations": {},
    "fits": [],
    "validation": None,
}
"""What every document of this format has, also of a run whose analyses add none of it."""
ALWAYS_SETTINGS: Json = {
    "despike": None,
    "outliers": None,
    "fits": [],
    "compensations": [],
    "primary": None,
}
"""The content of its key `analysis` where no analysis records its settings."""


def document(result: Result) -> Json:
    """Return the result as plain dicts, lists, texts, numbers, bools and null."""
    # The keys of ALWAYS are in every document; of the keys below, those that have a content.
    details = ALWAYS | {k: v for each in result.details for k, v in each.document().items()}
    results = [_measurement_result(measured) for measured in result.results]
    missing = [
        {
            "name": result.name,
            "symbol": result.of.symbol or None,
            "text": result.of.text or None,
            "unit": result.of.unit,
            "coordinates": coordinates_of(result.coordinates),
            "why": result.why,
        }
        for result in result.missing
    ]
    tables = [
        {
            "of": each.of,
            "title": each.title,
            "columns": list(each.columns),
            "rows": plain(each.rows),
        }
        for each in result.tables
    ]
    partners = {name: _run(run) for name, run in result.run.partners.items()}
    # result/1 always has the key of the first of them, and of the other where there is such a run.
    by_key = {key: partners.pop(name, None) for name, key in KEYS.items()}
    return {
        "format": FORMAT,
        "measurand": {"symbol": result.symbol, "name": result.measurand, "unit": result.unit},
        "run": _run(result.run),
        **{key: run for key, run in by_key.items() if run is not None or key == KEYS[ONLY]},
        **({"partner_runs": partners} if partners else {}),
        "analysis": plain(result.settings),
        "revisions": dict(result.revisions),
        "headline": details.pop("headline"),
        **({"results": results} if results else {}),
        **({"missing": missing} if missing else {}),
        **({"tables": tables} if tables else {}),
        **{
            name: [plain(asdict(item)) for item in items]
            for name, items in (("figures", result.figures), ("sections", result.sections))
            if items
        },
        "verdict": verdict(result),
        "limits": limits(result.limits),
        "decision": None if result.decision is None else decision(result.decision),
        "checks": checks_of(result.checks),
        "notes": list(result.notes),
        **details,
    }


def _measurement_result(result: MeasurementResult) -> Json:
    return {
        "name": result.name,
        "symbol": result.of.symbol or None,
        "text": result.of.text or None,
        **_identity(result.of),
        "coordinates": coordinates_of(result.coordinates),
        "estimate": estimate(result.estimate),
        "readings": int(result.readings),
        "budget": budget(result.components, result.of.unit),
    }


def _identity(definition: ResultDefinition) -> Json:
    """Return which measurand it is, for programs and in words, where that is known."""
    if definition.measurand is not None:
        return {"measurand": {"id": definition.measurand.id, "text": str(definition.measurand)}}
    return {"measurand": {"id": definition.id, "text": definition.words}} if definition.id else {}


def _run(run: RunData) -> Json:
    return {
        "id": run.run_id,
        "digest_sha256": run.digest,
        "procedure": {
            "id": run.procedure_id,
            "revision": run.procedure_revision,
            "title": run.procedure_title,
        },
        "station": run.station_id,
        "mandrel": run.mandrel,
        "started_utc": run.started_utc,
        "ended_utc": run.ended_utc,
        "outcome": run.outcome,
        "inputs": dict(run.inputs),
        "people": dict(run.people),
        "approval": dict(run.approval),
        "imported": dict(run.imported),
        "zeros": {name: quantity(value, _unit_of(run, name)) for name, value in run.zeros.items()},
        "instruments": {
            name: {"serial": instrument.serial, "certificate": instrument.certificate}
            for name, instrument in run.instruments.items()
        },
    }


def _unit_of(run: RunData, channel: str) -> str:
    """Return the SI unit of a channel, '' if nothing states it."""
    if instrument := run.instruments.get(channel):
        return si_symbol(instrument.quantity)
    recorded = [recording.units for recording in run.recordings]
    measured = [row.units for row in run.measurements]
    return next((units[channel] for units in (*recorded, *measured) if channel in units), "")
