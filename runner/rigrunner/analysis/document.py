"""The content of `result.json`: the numbers of a Result, each with its unit, nothing else.

Full precision (the shortest text that reads back as the same float), stable keys, no waveforms.
JSON knows no NaN and no infinity: unknown is null with its reason beside it, infinite degrees of
freedom are the text "infinite".
"""

from __future__ import annotations

from math import isfinite, isinf
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.uncertainty import coverage_factor

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.analysis import (
        Check,
        CompensatedPoint,
        Compensation,
        Component,
        Curve,
        Rejection,
        SwingPoint,
    )
    from rigrunner.api.data import Estimate, RunData
    from rigrunner.api.results import Decision, FittedTorque, Result

FORMAT = "rigrunner: result/1"
TORQUE = "N·m"
Json = dict[str, object]


def document(result: Result) -> Json:
    """Return the result as plain dicts, lists, texts, numbers, bools and null."""
    return {
        "format": FORMAT,
        "measurand": {"symbol": result.symbol, "name": result.measurand, "unit": TORQUE},
        "run": _run(result.run),
        "no_load_run": None if result.no_load_run is None else _run(result.no_load_run),
        "analysis": _plain(result.settings),
        "headline": _headline(result),
        "decision": None if result.decision is None else _decision(result.decision),
        "checks": _checks(result.checks),
        "notes": list(result.notes),
        "points": [_point(point) for point in result.loaded],
        "no_load_points": [_point(point) for point in result.no_load],
        "compensations": {name: _compensation(each) for name, each in result.compensations.items()},
        "fits": [_fit(fit) for fit in result.fits],
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
        "zeros": {name: quantity(value, TORQUE) for name, value in run.zeros.items()},
        "instruments": {
            name: {"serial": each.serial, "certificate": each.certificate}
            for name, each in run.instruments.items()
        },
    }


def _headline(result: Result) -> Json:
    return {
        "method": result.primary or None,
        "compensated": estimate(result.headline),
        "raw_peak": estimate(result.raw_headline),
    }


def _decision(decision: Decision) -> Json:
    return {
        "verdict": str(decision.verdict),
        "reason": decision.reason,
        "limit": decision.limit_text,
        "lower_limit": quantity(decision.lower_nm, TORQUE),
        "upper_limit": quantity(decision.upper_nm, TORQUE),
        "limit_source": decision.limit_source,
        "rule": decision.rule,
        "probability_of_conformity": number(decision.probability_of_conformity),
        "verdict_uncompensated": str(decision.uncompensated),
    }


def _checks(checks: Iterable[Check]) -> list[Json]:
    return [
        {"name": each.name, "ok": each.ok, "text": each.text, "advice": each.advice}
        for each in checks
    ]


def _point(point: SwingPoint) -> Json:
    kept = point.peak_nm[point.peak_kept]
    return {
        "recording": point.recording,
        "set_frequency": quantity(point.set_frequency_hz, "Hz"),
        "frequency": estimate(point.frequency_hz),
        "load": quantity(point.load_n, "N"),
        "sample_rate": quantity(point.sample_rate_hz, "Hz"),
        "cycles": point.cycles,
        "spikes_replaced": point.spikes,
        "raw_peak": {
            "mean": quantity(float(kept.mean()), TORQUE),
            "standard_deviation": quantity(float(kept.std(ddof=1)), TORQUE),
            "per_cycle": {"values": _plain(point.peak_nm), "unit": TORQUE},
            "cycles_kept": int(point.peak_kept.sum()),
            "rejected": _rejections(point.peak_rejections),
        },
        "waveform": {
            "cycles_kept": int(point.kept.sum()),
            "rejected": _rejections(point.waveform_rejections),
        },
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
        "curve": None if compensation.curve is None else _curve(compensation.curve),
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
        "budget": [_component(each) for each in point.components],
    }


def _component(component: Component) -> Json:
    return {
        "name": component.name,
        "standard_uncertainty": quantity(component.u, TORQUE),
        "degrees_of_freedom": degrees_of_freedom(component.dof),
        "distribution": component.distribution,
        "common_to_all_points": component.common,
    }


def _fit(fit: FittedTorque) -> Json:
    return {
        "name": fit.name,
        "problem": fit.problem or None,
        "points": {
            "x": {"values": _plain(fit.points.x), "unit": fit.points.x_unit},
            "y": {"values": _plain(fit.points.y), "unit": fit.points.y_unit},
            "u_y": {"values": _plain(fit.points.u_y), "unit": fit.points.y_unit},
        },
        "curve": None if fit.curve is None else _curve(fit.curve),
    }


def _curve(curve: Curve) -> Json:
    standard = np.sqrt(np.diag(curve.covariance))
    return {
        "formula": curve.formula,
        "coefficients": {
            name: {"value": number(value), "standard_uncertainty": number(u), "unit": unit}
            for name, value, u, unit in zip(
                curve.names, curve.coefficients, standard, curve.units, strict=True
            )
        },
        "covariance": _plain(curve.covariance),
        "degrees_of_freedom": degrees_of_freedom(curve.dof),
        "residual_standard_deviation": number(curve.residual_s),
        "residuals": _plain(curve.residuals),
        "r_squared": number(curve.r_squared),
        "valid_from": number(curve.valid_x[0]),
        "valid_to": number(curve.valid_x[1]),
    }


def estimate(value: Estimate | None) -> Json | None:
    """Return a value with its standard and 95 % expanded uncertainty; None stays None."""
    if value is None:
        return None
    k = coverage_factor(value.dof)
    return {
        "value": number(value.value),
        "standard_uncertainty": number(value.u),
        "degrees_of_freedom": degrees_of_freedom(value.dof),
        "coverage_factor_95": number(k),
        "expanded_uncertainty_95": number(k * value.u),
        "unit": value.unit,
    }


def quantity(value: float, unit: str) -> Json:
    """Return a number with its unit."""
    return {"value": number(value), "unit": unit}


def number(value: float) -> float | None:
    """Return a float that JSON can hold; None for what is not a finite number."""
    return float(value) if isfinite(value) else None


def degrees_of_freedom(dof: float) -> float | str | None:
    """Return the degrees of freedom, or the text 'infinite'."""
    return "infinite" if isinf(dof) else number(dof)


def _plain(value: object) -> object:
    """Return nested mappings, sequences and arrays as JSON values."""
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, dict):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return number(value) if isinstance(value, float) else value
