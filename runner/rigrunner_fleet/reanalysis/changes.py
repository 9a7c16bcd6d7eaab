"""In what way stored runs are analysed again: as their procedures say, but for what is changed."""

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
    """What stands in place of the procedure's own analyses."""

    analysis: Mapping[str, Any] = field(default_factory=dict)
    """Settings of the analysis that gives the measurand, in place of its own."""
    primary: str = ""
    """The label of the method that the headline and the verdict use; '' leaves it."""
    named: tuple[AnalysisRef, ...] = ()
    """In place of the analyses that name their results; none: they stay."""

    def applied(self, procedure: Procedure, registry: Registry) -> Procedure:
        """Return the changed procedure; raise DataError where its parts contradict each other."""
        told = {**self.analysis, **({"primary": self.primary} if self.primary else {})}
        kept = []
        for index, each in enumerate(procedure.analysis):
            record = registry.record(each.kind, each.name)
            if not isinstance(record, AnalysisRecord) or record.changed is None:
                kept += [] if self.named else [each]
            elif told:
                own = registry.validated(each.kind, each.name, each.settings)
                given = registry.validated(each.kind, each.name, told)
                try:
                    settings = record.changed(own, given)
                except DataError as error:
                    at = f"analysis[{index}].{each.name}"
                    raise DataError(f"{at}.{error.message}", hint=error.hint) from error
                kept.append(each.model_copy(update={"settings": settings}))
            else:
                kept.append(each)
        return procedure.with_analyses((*kept, *self.named))

    def describe(self) -> str:
        """Return the changes as a text that is the same for the same changes."""
        told = [
            _text(self.analysis) if self.analysis else "",
            self.primary,
            *(_text({each.name: each.settings}) for each in self.named),
        ]
        return " ".join(filter(None, told)) or "none"


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
