"""Registers the built-in analyses. Their settings load on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import AnalysisRecord, Imported, hookimpl

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api import Objection, Requirements, ResultDefinition
    from rigrunner_plugins.analyses.curve.settings import CurveSettings
    from rigrunner_plugins.analyses.equation.settings import EquationSettings
    from rigrunner_plugins.analyses.settings import ReadingsSettings

    AnySettings = ReadingsSettings | EquationSettings | CurveSettings


@hookimpl
def rigrunner_analyses() -> list[AnalysisRecord]:
    """Return the analyses."""
    return [
        AnalysisRecord(
            name="readings",
            help="A statistic of recorded or measured values, with its uncertainty",
            settings="rigrunner_plugins.analyses.settings:ReadingsSettings",
            factory=Imported("rigrunner_plugins.analyses.readings:Readings"),
            live=Imported("rigrunner_plugins.analyses.live:LiveReadings"),
            yields=_yields,
            requires=_requires,
            objections=_objections,
            partner_problems=Imported("rigrunner_plugins.analyses.partner:partner_problems"),
            trial={
                "of": "meter.voltage",
                "per": ["load.current"],
                "result": {"name": "voltage", "symbol": "U", "unit": "V"},
            },
            trial_units={"meter.voltage": "V"},
        ),
        AnalysisRecord(
            name="equation",
            help="A measurement model: results from an equation with measured values",
            settings="rigrunner_plugins.analyses.equation.settings:EquationSettings",
            factory=Imported("rigrunner_plugins.analyses.equation.evaluation:EquationAnalysis"),
            yields=_yields,
            requires=_requires,
            objections=_objections,
            trial={
                "result": {"name": "resistance", "symbol": "R", "unit": "Ω"},
                "model": "R = U / I * (1 + alpha * (t - t0))",
                "inputs": {"U": "meter.voltage", "I": "meter.current", "t": "room.temperature"},
                "constants": {
                    "alpha": {"value": "0.00393 1/K", "limits": "±0.00002 1/K"},
                    "t0": "20 °C",
                },
                "per": ["load.current"],
            },
            trial_units={"meter.voltage": "V", "meter.current": "A", "room.temperature": "K"},
        ),
        AnalysisRecord(
            name="curve",
            help="A fit of values over x: its parameters, values, inverse, slope, hysteresis, ...",
            settings="rigrunner_plugins.analyses.curve.settings:CurveSettings",
            factory=Imported("rigrunner_plugins.analyses.curve.analysis:CurveAnalysis"),
            yields=_yields,
            requires=_requires,
            objections=_objections,
            trial={
                "of": "meter.voltage",
                "over": "load.current",
                "fit": {"polynomial": {"degree": 1}},
                "results": {
                    "slope": {"name": "resistance", "symbol": "R", "unit": "mΩ"},
                    "value": {"name": "voltage", "at": "11 A", "unit": "V"},
                },
            },
            trial_units={"meter.voltage": "V", "load.current": "A"},
        ),
    ]


def _yields(settings: AnySettings) -> tuple[ResultDefinition, ...]:
    return settings.yields()


def _requires(settings: AnySettings) -> Requirements:
    return settings.requires()


def _objections(settings: AnySettings, units: Mapping[str, str]) -> Iterable[Objection]:
    return settings.objections(units)
