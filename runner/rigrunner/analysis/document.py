"""The content of `result.json`: the numbers of a Result, each with its unit, nothing else.

Full precision (the shortest text that reads back as the same float), stable keys, no waveforms.
JSON knows no NaN and no infinity: unknown is null with its reason beside it, infinite degrees of
freedom are the text "infinite".
"""

from __future__ import annotations

from dataclasses import asdict
from math import nan
from typing import TYPE_CHECKING

from rigrunner.analysis.document_budget import budget
from rigrunner.analysis.document_fits import curve_of, fit
from rigrunner.analysis.document_validation import validation
from rigrunner.analysis.document_values import (
    coordinates_of,
    estimate,
    number,
    plain,
    quantity,
)
from rigrunner.analysis.verdict.document import decision, limits, verdict
from rigrunner.api.analysis import SwingPoint
from rigrunner.api.checks import effect_words
from rigrunner.api.instruments import torque_instruments
from rigrunner.signal.swings import kept_cycles

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.analysis.document_values import Json
    from rigrunner.api.analysis import (
        Bias,
        Check,
        CompensatedPoint,
        Compensation,
        PeakPoint,
        Rejection,
    )
    from rigrunner.api.data import Array, RunData
    from rigrunner.api.findings import MeasurementResult, ResultDefinition, Table
    from rigrunner.api.results import Result

FORMAT = "rigrunner: result/1"
TORQUE = "N·m"


def document(result: Result) -> Json:
    """Return the result as plain dicts, lists, texts, numbers, bools and null."""
    named, after = [_named(each) for each in result.results], result.no_load_run_after
    return {
        "format": FORMAT,
        "measurand": {"symbol": result.symbol, "name": result.measurand, "unit": TORQUE},
        "run": _run(result.run),
        "no_load_run": None if result.no_load_run is None else _run(result.no_load_run),
        **({} if after is None else {"no_load_run_after": _run(after)}),
        "analysis": plain(result.settings),
        "revisions": dict(result.revisions),
        "headline": _headline(result),
        **({"results": named} if named else {}),
        **({"tables": [_table(each) for each in result.tables]} if result.tables else {}),
        **{
            name: [plain(asdict(each)) for each in given]
            for name, given in (("figures", result.figures), ("sections", result.sections))
            if given
        },
        "verdict": verdict(result),
        "limits": limits(result.limits),
        "decision": None if result.decision is None else decision(result.decision),
        "checks": _checks(result.checks),
        "notes": list(result.notes),
        "points": [_point(point) for point in result.loaded],
        "no_load_points": [_point(point) for point in result.no_load],
        "compensations": {name: _compensation(each) for name, each in result.compensations.items()},
        "fits": [fit(each) for each in result.fits],
        "validation": None if result.validation is None else validation(result.validation),
    }


def _named(result: MeasurementResult) -> Json:
    return {
        "name": result.name,
        "symbol": result.of.symbol or None,
        "text": result.of.text or None,
        **_identity(result.of),
        "coordinates": coordinates_of(result.coordinates),
        "estimate": estimate(result.estimate),
        "readings": result.readings,
        "budget": budget(result.components, result.of.unit),
    }


def _identity(definition: ResultDefinition) -> Json:
    """Return which measurand it is, for programs and in words, where that is known."""
    if definition.measurand is not None:
        return {"measurand": {"id": definition.measurand.id, "text": str(definition.measurand)}}
    return {"measurand": {"id": definition.id, "text": definition.words}} if definition.id else {}


def _table(table: Table) -> Json:
    return {
        "of": table.of,
        "title": table.title,
        "columns": list(table.columns),
        "rows": plain(table.rows),
    }


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
        "mandrel": run.rig.mandrel,
        "started_utc": run.started_utc,
        "ended_utc": run.ended_utc,
        "outcome": run.outcome,
        "inputs": dict(run.inputs),
        "people": dict(run.people),
        "approval": dict(run.approval),
        "imported": dict(run.imported),
        "zeros": {name: quantity(value, TORQUE) for name, value in run.zeros.items()},
        "instruments": {
            name: {"serial": each.serial, "certificate": each.certificate}
            for name, each in torque_instruments(run.instruments.values()).items()
        },
    }


def _headline(result: Result) -> Json:
    return {
        **({"name": result.name} if result.primary else {}),
        "method": result.primary or None,
        "compensated": estimate(result.headline),
        "budget": budget(result.headline_components),
        "raw_peak": estimate(result.raw_headline),
    }


def _checks(checks: Iterable[Check]) -> list[Json]:
    return [
        {
            "name": each.name,
            "ok": each.ok,
            "text": each.text,
            "advice": each.advice,
            "value": None if each.value is None else number(each.value),
            "threshold": None if each.threshold is None else number(each.threshold),
            "unit": each.unit or None,
            "biases": [_bias(bias) for bias in each.biases],
            "consequence": each.consequence or None,
            "effect": effect_words(each),
        }
        for each in checks
    ]


def _bias(bias: Bias) -> Json:
    return {
        "of": bias.of,
        "value": number(bias.value),
        "standard_uncertainty": number(bias.u),
        "unit": bias.unit,
    }


def _point(point: PeakPoint) -> Json:
    kept = point.peak_nm[point.peak_kept]
    return {
        "recording": point.recording,
        "set_frequency": quantity(point.set_frequency_hz, "Hz"),
        "frequency": estimate(point.frequency_hz),
        "load": quantity(point.load_n, "N"),
        "motion": str(point.motion),
        "cycles": point.cycles,
        "spikes_replaced": point.spikes,
        "raw_peak": {
            "mean": quantity(float(kept.mean()), TORQUE),
            "standard_deviation": quantity(_deviation(kept), TORQUE),
            "per_cycle": {"values": plain(point.peak_nm), "unit": TORQUE},
            "cycles_kept": int(point.peak_kept.sum()),
            "rejected": _rejections(point.peak_rejections),
        },
        "waveform": _waveform(point) if isinstance(point, SwingPoint) else None,
    }


def _deviation(values: Array) -> float:
    return float(values.std(ddof=1)) if len(values) > 1 else nan


def _waveform(point: SwingPoint) -> Json:
    return {
        "sample_rate": quantity(point.sample_rate_hz, "Hz"),
        "cycles_kept": int(kept_cycles(point).sum()),
        "rejected": _rejections(point.waveform_rejections),
    }


def _rejections(rejections: Iterable[Rejection]) -> list[Json]:
    return [
        {
            "cycle": each.index,
            "value": quantity(each.value, TORQUE),
            "rule": each.rule,
            "statistic": number(each.statistic),
            "critical": number(each.critical),
        }
        for each in rejections
    ]


def _compensation(compensation: Compensation) -> Json:
    return {
        "measurand": compensation.measurand,
        "not_applicable": compensation.not_applicable or None,
        "points": [_compensated(point) for point in compensation.points],
        "parameters": {name: estimate(each) for name, each in compensation.parameters.items()},
        "curve": None if compensation.curve is None else curve_of(compensation.curve),
        "checks": _checks(compensation.checks),
        "notes": list(compensation.notes),
    }


def _compensated(point: CompensatedPoint) -> Json:
    return {
        "set_frequency": quantity(point.set_frequency_hz, "Hz"),
        "frequency": quantity(point.frequency_hz, "Hz"),
        "raw": quantity(point.raw_nm, TORQUE),
        "rig": quantity(point.rig_nm, TORQUE),
        "torque": estimate(point.torque),
        "budget": budget(point.components),
    }
