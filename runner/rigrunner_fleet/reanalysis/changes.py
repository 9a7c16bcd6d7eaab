"""Changes with which stored runs are analysed again: the rest is as in their procedures."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError, InvalidFileError
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.yamlfile import validate

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.procedure import AnalysisRef, Procedure
    from rigrunner.registry import Registry
    from rigrunner.yamlfile import Document


@dataclass(frozen=True)
class Changes:
    """Changes of a procedure's analyses, for a new analysis of its runs."""

    analysis: Mapping[str, Any] = field(default_factory=dict)
    """Settings of the analysis that gives the measurand, in place of its own."""
    primary: str = ""
    """The label of the method that the headline and the verdict use; '' leaves it."""
    named: tuple[AnalysisRef, ...] = ()
    """In place of the analyses that name their results; none: they stay."""

    def applied(self, procedure: Procedure, registry: Registry) -> Procedure:
        """Return the changed procedure; raise DataError where its parts contradict each other."""
        overrides = {**self.analysis, **({"primary": self.primary} if self.primary else {})}
        analyses = []
        for index, analysis in enumerate(procedure.analysis):
            record = registry.record(analysis.kind, analysis.name)
            if not isinstance(record, AnalysisRecord) or record.changed is None:
                analyses += [] if self.named else [analysis]
            elif overrides:
                own_settings = registry.validated(analysis.kind, analysis.name, analysis.settings)
                changes = registry.validated(analysis.kind, analysis.name, overrides)
                try:
                    settings = record.changed(own_settings, changes)
                except DataError as error:
                    place = f"analysis[{index}].{analysis.name}"
                    raise DataError(f"{place}.{error.message}", hint=error.hint) from error
                analyses.append(analysis.model_copy(update={"settings": settings}))
            else:
                analyses.append(analysis)
        return procedure.with_analyses((*analyses, *self.named))

    def describe(self) -> str:
        """Return the changes as a text that is the same for the same changes."""
        parts = [
            _text(self.analysis) if self.analysis else "",
            self.primary,
            *(_text({analysis.name: analysis.settings}) for analysis in self.named),
        ]
        return " ".join(filter(None, parts)) or "none"


def check_settings(document: Document, registry: Registry) -> None:
    """Raise InvalidFileError where a file's section `analysis` fits no analysis of a measurand."""
    refused: list[InvalidFileError] = []
    for plugin in registry.plugins:
        if isinstance(plugin.record, AnalysisRecord) and plugin.record.changed is not None:
            try:
                validate(plugin.record.settings_model, document, ("analysis",))
            except InvalidFileError as error:
                refused.append(error)
            else:
                return
    if not refused:
        hint = "no plugin is installed whose settings can be changed one by one"
        raise DataError("analysis: there is nothing to change", hint=hint)
    raise refused[0]


def _text(settings: Mapping[str, Any]) -> str:
    return json.dumps(dict(settings), default=str, ensure_ascii=False)
