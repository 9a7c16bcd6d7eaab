"""A file with an analysis alone, to analyse stored runs in another way."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from rigrunner.api.settings import ListOf, Settings
from rigrunner.procedure.analyses import AnalysisRef


class AnalysisFile(Settings):
    """What it names stands in place of what the procedure of a run has; the rest stays."""

    rigrunner: Literal["analysis/1"]
    """Type and version of this file."""
    analysis: dict[str, Any] = Field(default_factory=dict)
    """Settings of the analysis that gives the procedure's measurand."""
    named: ListOf[AnalysisRef] = ()
    """In place of all analyses that name their results; none: they stay."""
