"""The procedure language: models and loading."""

from __future__ import annotations

from rigrunner.procedure.analysis_spec import AnalysisSpec, Despike, NoLoadSpec, PluginRef
from rigrunner.procedure.loading import LoadedProcedure, load_procedure, parse_procedure
from rigrunner.procedure.model import Acceptance, Input, Limit, Measurand, Procedure

__all__ = [
    "Acceptance",
    "AnalysisSpec",
    "Despike",
    "Input",
    "Limit",
    "LoadedProcedure",
    "Measurand",
    "NoLoadSpec",
    "PluginRef",
    "Procedure",
    "load_procedure",
    "parse_procedure",
]
