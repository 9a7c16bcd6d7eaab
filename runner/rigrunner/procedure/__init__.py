"""The procedure language: models and loading."""

from __future__ import annotations

from rigrunner.procedure.acceptance import Acceptance, AcceptanceFile
from rigrunner.procedure.analyses import AnalysisFile, AnalysisRef
from rigrunner.procedure.calls import load_procedure
from rigrunner.procedure.kinds import kinds_of
from rigrunner.procedure.loading import (
    InconsistentProcedureError,
    LoadedProcedure,
    parse_procedure,
    texts_digest,
)
from rigrunner.procedure.model import Measurand, Procedure
from rigrunner.procedure.named_results import check_result_limits
from rigrunner.procedure.questions import Input
from rigrunner.procedure.result_limits import Limit
from rigrunner.procedure.steps import Step

__all__ = [
    "Acceptance",
    "AcceptanceFile",
    "AnalysisFile",
    "AnalysisRef",
    "InconsistentProcedureError",
    "Input",
    "Limit",
    "LoadedProcedure",
    "Measurand",
    "Procedure",
    "Step",
    "check_result_limits",
    "kinds_of",
    "load_procedure",
    "parse_procedure",
    "texts_digest",
]
