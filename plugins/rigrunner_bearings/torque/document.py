"""What the analysis of torque adds to `result.json`."""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING

from rigrunner.api.plugin_refs import LABEL
from rigrunner.signal.as_json.budget import budget
from rigrunner.signal.as_json.checks import checks_of
from rigrunner.signal.as_json.curves import curve_of
from rigrunner.signal.as_json.values import Json, estimate, number, plain, quantity
from rigrunner.signal.bands import bands
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.signal.swings import kept_cycles
from rigrunner_bearings.torque.settings import StartsSpec

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api import Array, Curve, Points, Rejection
    from rigrunner.api.analysis_context import Plugins
    from rigrunner.api.plugin_refs import PluginRef
    from rigrunner.signal.as_json.values import Json
    from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.torque import FittedTorque, TorqueDetails
    from rigrunner_bearings.api.validation import Agreement, Validation
    from rigrunner_bearings.torque.settings import TorqueSettings

TORQUE = "N·m"


def torque_document(found: TorqueDetails) -> Json:
    """Return headline, points, compensations, fits and validation, by their keys."""
    return {
        "headline": _headline(found),
        "points": [_point(point) for point in found.loaded],
        "no_load_points": [_point(point) for point in found.no_load],
        "compensations": {name: _compensation(each) for name, each in found.compensations.items()},
        "fits": [fit(each) for each in found.fits],
        "validation": None if found.validation is None else validation(found.validation),
    }


def settings_document(spec: TorqueSettings, plugins: Plugins) -> Json:
    """Return the settings of the analysis, each plugin's with its defaults."""
    starts, checked = spec.starts, spec.validate_
    fields = set(StartsSpec.model_fields)
    return {
        **({} if starts is None else {"starts": starts.model_dump(include=fields)}),
        "despike": None if spec.despike is None else spec.despike.model_dump(),
        "outliers": None if spec.outliers is None else _resolved(spec.outliers, plugins),
        "fits": [_resolved(each, plugins) for each in spec.fits],
        "compensations": [_resolved(each, plugins) for each in spec.compensations],
        "primary": spec.primary or None,
        **({} if checked is None else {"validate": checked.model_dump()}),
    }


def _resolved(reference: PluginRef, plugins: Plugins) -> Json:
    model = plugins.record(reference.kind, reference.name).settings_model
    settings = model.model_validate(dict(reference.settings))
    label = {} if reference.label == reference.name else {LABEL: reference.label}
    return {"name": reference.name, **label, "settings": settings.model_dump(mode="json")}


def _headline(found: TorqueDetails) -> Json:
    return {
        **({"name": found.name} if found.primary else {}),
        "method": found.primary or None,
        "compensated": estimate(found.headline),
        "budget": budget(found.headline_components, TORQUE),
        "raw_peak": estimate(found.raw_headline),
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
        "checks": checks_of(compensation.checks),
        "notes": list(compensation.notes),
    }


def _compensated(point: CompensatedPoint) -> Json:
    return {
        "set_frequency": quantity(point.set_frequency_hz, "Hz"),
        "frequency": quantity(point.frequency_hz, "Hz"),
        "raw": quantity(point.raw_nm, TORQUE),
        "rig": quantity(point.rig_nm, TORQUE),
        "torque": estimate(point.torque),
        "budget": budget(point.components, TORQUE),
    }


def fit(fitted: FittedTorque) -> Json:
    """Return a fit with its points; its curve is null where there is none."""
    return {
        "name": fitted.name,
        "problem": fitted.problem or None,
        "points": {
            "x": {"values": plain(fitted.points.x), "unit": fitted.points.x_unit},
            "y": {"values": plain(fitted.points.y), "unit": fitted.points.y_unit},
            "u_y": {"values": plain(fitted.points.u_y), "unit": fitted.points.y_unit},
        },
        "curve": None if fitted.curve is None else curve_of(fitted.curve),
        "at_the_points": None
        if fitted.curve is None
        else _at_the_points(fitted.curve, fitted.points),
    }


def _at_the_points(curve: Curve, points: Points) -> Json:
    """Return the curve and the half-widths of its bands at each x, in the unit of y."""
    found = bands(curve, points.x)
    return {
        "curve": plain(found.value),
        "confidence_95": plain(found.confidence),
        "prediction_95": plain(found.prediction),
        "unit": points.y_unit,
    }


def validation(found: Validation) -> Json:
    """Return both checks of a method's result."""
    equation, pipeline = found.equation, found.pipeline
    return {
        "method": found.method,
        "agrees": found.agrees,
        "statements": list(found.statements),
        "significant_digits": found.digits,
        "seed": found.seed,
        "equation": {
            "trials": equation.trials,
            "stable": equation.stable,
            "mean": _agreement(equation.mean),
            "points": [_agreement(each) for each in equation.points],
        },
        "pipeline": {
            "draws": pipeline.draws,
            "refused": pipeline.refused,
            "through_the_data": list(pipeline.through_the_data),
            "as_effects": list(pipeline.as_effects),
            "mean": _agreement(pipeline.mean),
            "points": [_agreement(each) for each in pipeline.points],
        },
    }


def _agreement(found: Agreement) -> Json:
    frequency = found.set_frequency_hz
    return {
        "set_frequency": None if frequency is None else quantity(frequency, "Hz"),
        "gum": estimate(found.gum),
        "mean": quantity(found.mean, TORQUE),
        "standard_uncertainty": quantity(found.u, TORQUE),
        "interval_95": {"low": found.low, "high": found.high, "unit": TORQUE},
        "ends_differ_by": quantity(found.apart, TORQUE),
        "tolerance": quantity(found.tolerance, TORQUE),
        "resolution": quantity(found.resolution, TORQUE),
        "agrees": found.agrees,
    }
