"""What the analysis of torque yields and needs, known from its settings and their plugins alone."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api import PluginError, Requirements

if TYPE_CHECKING:
    from rigrunner.api import AnalysisContext, ResultDefinition
    from rigrunner.api.analysis_context import Plugins
    from rigrunner_bearings.api.measurand import MeasurandKind
    from rigrunner_bearings.torque.settings import TorqueSettings


def definitions(spec: TorqueSettings, context: AnalysisContext) -> tuple[ResultDefinition, ...]:
    """Return the definition of the compensated torque; none where nothing is compensated.

    Raises PluginError if none of several compensations is the primary one.
    """
    if spec.compensations and spec.primary_plugin is None:
        raise PluginError("none of the compensations is the primary one")
    kind = kind_of(spec, context.plugins)
    definition = spec.yields(context.symbol, context.measurand, kind)
    return () if definition is None else (definition,)


def kind_of(spec: TorqueSettings, plugins: Plugins) -> MeasurandKind | None:
    """Return which torque the primary method yields of what is recorded; None if it is silent."""
    plugin = spec.primary_plugin
    if plugin is None:
        return None
    kind = getattr(plugins.record("compensation", plugin.name), "yields", None)
    return None if kind is None else spec.measured(kind)


def requirements(spec: TorqueSettings, context: AnalysisContext) -> Requirements:
    """Return which runs without load it takes; without one its compensations do not apply."""
    del context
    partners = () if spec.no_load is None else spec.no_load.partners()
    return Requirements(partners=tuple(replace(partner, optional=True) for partner in partners))
