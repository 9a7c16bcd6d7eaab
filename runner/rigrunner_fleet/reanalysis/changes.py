"""In what way stored runs are analysed again: as their procedures say, but for what is changed."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.procedure import AnalysisSpec, analysis_contradictions

if TYPE_CHECKING:
    from rigrunner.procedure import Procedure
    from rigrunner.procedure.analyses import AnalysisRef

_OF_COMPENSATIONS = ("compensations", "primary_", "no_load")


@dataclass(frozen=True)
class Changes:
    """What stands in place of the procedure's own analysis."""

    analysis: AnalysisSpec | None = None
    """Of it only what was written counts."""
    primary: str = ""
    """The label of the method that the headline and the verdict use; '' leaves it."""
    named: tuple[AnalysisRef, ...] = ()
    """In place of the analyses that name their results; none: they stay."""

    def __call__(self, procedure: Procedure) -> Procedure:
        """Return the changed procedure; raise DataError where its parts contradict each other.

        One without compensations, such as that of a no-load run, stays without.
        """
        if self.named:
            procedure = procedure.with_named_analyses(self.named)
        given = self.analysis
        named = {} if given is None else {n: getattr(given, n) for n in given.model_fields_set}
        if self.primary:
            named["primary_"] = self.primary
        if not procedure.torque_analysis.compensations:
            named = {name: each for name, each in named.items() if name not in _OF_COMPENSATIONS}
        if not named:
            return procedure
        changed = procedure.with_torque_analysis(procedure.torque_analysis.model_copy(update=named))
        for problem in analysis_contradictions(changed):
            raise DataError(f"{problem.field}: {problem.message}", hint=problem.hint)
        return changed

    def describe(self) -> str:
        """Return the changes as a text that is the same for the same changes."""
        named = ({each.name: dict(each.plugin.settings)} for each in self.named if each.plugin)
        told = [
            self.primary,
            *(json.dumps(each, default=str, ensure_ascii=False) for each in named),
        ]
        if self.analysis is not None and self.analysis.model_fields_set:
            told.insert(0, self.analysis.model_dump_json(exclude_unset=True))
        return " ".join(filter(None, told)) or "none"
