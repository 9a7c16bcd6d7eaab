"""The analyses as they were asked for, for the record: with the defaults of the plugins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.analysis.document import ALWAYS_SETTINGS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.analysis.lookup import Lookup
    from rigrunner.api.findings import Findings
    from rigrunner.procedure import AnalysisRef


def settings_as_asked(
    analyses: Sequence[AnalysisRef], found: Sequence[Findings], lookup: Lookup
) -> dict[str, object]:
    """Return the settings of analyses, each plugin's with its defaults, for JSON.

    `found` is what each of them found: its details may record its settings.
    """
    own = [{k: v for one in each.details for k, v in one.settings().items()} for each in found]
    named = [_resolved(lookup, each) for each, told in zip(analyses, own, strict=True) if not told]
    recorded = {key: value for told in own for key, value in told.items()}
    return {**(recorded or ALWAYS_SETTINGS), **({"named": named} if named else {})}


def _resolved(lookup: Lookup, reference: AnalysisRef) -> dict[str, object]:
    """Return an analysis with its settings, quantities as they are written."""
    settings = lookup.validated(reference.kind, reference.name, reference.settings)
    return {"name": reference.name, "settings": _as_text(settings.model_dump(exclude_none=True))}


def _as_text(value: object) -> object:
    if isinstance(value, dict):
        return {name: _as_text(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_as_text(each) for each in value]
    return value if isinstance(value, bool | int | float | str) else str(value)
