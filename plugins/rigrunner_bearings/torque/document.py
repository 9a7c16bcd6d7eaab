"""What the analysis of torque adds to `result.json`, and its record as documents take it."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.details import PlotColumn, RunPlot
from rigrunner.api.plugin_refs import LABEL
from rigrunner.signal.as_json.budget import budget
from rigrunner.signal.as_json.checks import checks_of
from rigrunner.signal.as_json.curves import curve_of
from rigrunner.signal.as_json.values import Json, estimate, number, plain, quantity
from rigrunner.signal.bands import bands
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.signal.swings import kept_cycles
from rigrunner_bearings.torque.settings import NO_LOAD, StartsSpec

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api import Rejection, RunData
    from rigrunner.api.analysis_context import Plugins
    from rigrunner.api.certificate import CertifiedDetails
    from rigrunner.api.plugin_refs import PluginRef
    from rigrunner.signal.as_json.values import Json
    from rigrunner_bearings.api.compensations import Compensation
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.torque import FittedTorque
    from rigrunner_bearings.api.validation import Agreement, Validation
    from rigrunner_bearings.torque.settings import TorqueSettings


TORQUE = "N·m"


def _resolved(reference: PluginRef, plugins: Plugins) -> Json:
    model = plugins.record(reference.kind, reference.name).settings_model
    settings = model.model_validate(dict(reference.settings))
    label = {} if reference.label == reference.name else {LABEL: reference.label}
    return {"name": reference.name, **label, "settings": settings.model_dump(mode="json")}


def _point(point: PeakPoint) -> Json:
    kept = point.peak_nm[point.peak_kept]
    deviation = float(kept.std(ddof=1)) if len(kept) > 1 else nan
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
            "standard_deviation": quantity(deviation, TORQUE),
            "per_cycle": {"values": plain(point.peak_nm), "unit": TORQUE},
            "cycles_kept": int(point.peak_kept.sum()),
            "rejected": _rejections(point.peak_rejections),
        },
        "waveform": {
            "sample_rate": quantity(point.sample_rate_hz, "Hz"),
            "cycles_kept": int(kept_cycles(point).sum()),
            "rejected": _rejections(point.waveform_rejections),
        }
        if isinstance(point, SwingPoint)
        else None,
    }


def _rejections(rejections: Iterable[Rejection]) -> list[Json]:
    return [
        {
            "cycle": rejection.index,
            "value": quantity(rejection.value, TORQUE),
            "rule": rejection.rule,
            "statistic": number(rejection.statistic),
            "critical": number(rejection.critical),
        }
        for rejection in rejections
    ]


def _compensation(compensation: Compensation) -> Json:
    return {
        "measurand": compensation.measurand,
        "not_applicable": compensation.not_applicable or None,
        "points": [
            {
                "set_frequency": quantity(point.set_frequency_hz, "Hz"),
                "frequency": quantity(point.frequency_hz, "Hz"),
                "raw": quantity(point.raw_nm, TORQUE),
                "rig": quantity(point.rig_nm, TORQUE),
                "torque": estimate(point.torque),
                "budget": budget(point.components, TORQUE),
            }
            for point in compensation.points
        ],
        "parameters": {
            name: estimate(parameter) for name, parameter in compensation.parameters.items()
        },
        "curve": None if compensation.curve is None else curve_of(compensation.curve),
        "checks": checks_of(compensation.checks),
        "notes": list(compensation.notes),
    }


def fit(fitted: FittedTorque) -> Json:
    """Return a fit with its points; its curve is null where there is none.

    At the points it has the curve and the half-widths of its bands, in the unit of y.
    """
    at_points = None if fitted.curve is None else bands(fitted.curve, fitted.points.x)
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
        if at_points is None
        else {
            "curve": plain(at_points.value),
            "confidence_95": plain(at_points.confidence),
            "prediction_95": plain(at_points.prediction),
            "unit": fitted.points.y_unit,
        },
    }


def validation(result: Validation) -> Json:
    """Return both checks of a method's result."""
    equation, pipeline = result.equation, result.pipeline
    return {
        "method": result.method,
        "agrees": result.agrees,
        "statements": list(result.statements),
        "significant_digits": result.digits,
        "seed": result.seed,
        "equation": {
            "trials": equation.trials,
            "stable": equation.stable,
            "mean": _agreement(equation.mean),
            "points": [_agreement(agreement) for agreement in equation.points],
        },
        "pipeline": {
            "draws": pipeline.draws,
            "refused": pipeline.refused,
            "through_the_data": list(pipeline.through_the_data),
            "as_effects": list(pipeline.as_effects),
            "mean": _agreement(pipeline.mean),
            "points": [_agreement(agreement) for agreement in pipeline.points],
        },
    }


def _agreement(agreement: Agreement) -> Json:
    frequency = agreement.set_frequency_hz
    return {
        "set_frequency": None if frequency is None else quantity(frequency, "Hz"),
        "gum": estimate(agreement.gum),
        "mean": quantity(agreement.mean, TORQUE),
        "standard_uncertainty": quantity(agreement.u, TORQUE),
        "interval_95": {"low": agreement.low, "high": agreement.high, "unit": TORQUE},
        "ends_differ_by": quantity(agreement.apart, TORQUE),
        "tolerance": quantity(agreement.tolerance, TORQUE),
        "resolution": quantity(agreement.resolution, TORQUE),
        "agrees": agreement.agrees,
    }


@dataclass(frozen=True, eq=False, kw_only=True)
class DocumentedTorque(TorqueDetails):
    """What the analysis of torque keeps, with what documents state of it."""

    spec: TorqueSettings
    plugins: Plugins

    def settings(self) -> Mapping[str, object]:
        """Return the settings as every result records them, with the defaults of the plugins."""
        spec, plugins = self.spec, self.plugins
        starts, validate = spec.starts, spec.validate_
        fields = set(StartsSpec.model_fields)
        return {
            **({} if starts is None else {"starts": starts.model_dump(include=fields)}),
            "despike": None if spec.despike is None else spec.despike.model_dump(),
            "outliers": None if spec.outliers is None else _resolved(spec.outliers, plugins),
            "fits": [_resolved(reference, plugins) for reference in spec.fits],
            "compensations": [_resolved(reference, plugins) for reference in spec.compensations],
            "primary": spec.primary or None,
            **({} if validate is None else {"validate": validate.model_dump()}),
        }

    def document(self) -> Mapping[str, object]:
        """Return its parts of `result.json`."""
        methods = self.compensations.items()
        return {
            "headline": {
                **({"name": self.name} if self.primary else {}),
                "method": self.primary or None,
                "compensated": estimate(self.headline),
                "budget": budget(self.headline_components, TORQUE),
                "raw_peak": estimate(self.raw_headline),
            },
            "points": [_point(point) for point in self.loaded],
            "no_load_points": [_point(point) for point in self.no_load],
            "compensations": {name: _compensation(compensation) for name, compensation in methods},
            "fits": [fit(fitted) for fitted in self.fits],
            "validation": None if self.validation is None else validation(self.validation),
        }

    def plot(self) -> RunPlot | None:
        """Return raw and compensated torque of the primary method; None where there is none."""
        primary = self.compensations.get(self.primary)
        if primary is None or not primary.points:
            return None
        points = primary.points
        raw = [point.peak_nm[point.peak_kept].mean() for point in self.loaded]
        columns = {
            "frequency": ([point.frequency_hz for point in points], "Hz", "frequency"),
            "compensated": ([point.torque.value for point in points], TORQUE, "compensated torque"),
            "compensated_errors": (
                [point.torque.u for point in points],
                TORQUE,
                "standard uncertainty",
            ),
            "raw": (raw, TORQUE, "raw peak torque"),
        }
        return RunPlot(
            name="torque",
            title="torque over frequency",
            columns={
                name: PlotColumn(np.array(values), unit, f"{long_name} / {unit}")
                for name, (values, unit, long_name) in columns.items()
            },
            axis="frequency",
            signal="compensated",
            beside=("raw",),
        )

    def certified(self, run: RunData) -> CertifiedDetails:
        """Return its parts of a certificate; raise DataError where it gave no result."""
        from rigrunner_bearings.torque.certified import certified_torque  # noqa: PLC0415  (pydantic)

        return certified_torque(self, run, run.partners.get(NO_LOAD))
