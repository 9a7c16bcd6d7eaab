"""The analyses as they were asked for, for the record: with the defaults of the plugins."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.analysis.lookup import Lookup
    from rigrunner.api.findings import Findings
    from rigrunner.procedure import AnalysisRef

_NONE: Mapping[str, object] = {
    "despike": None,
    "outliers": None,
    "fits": [],
    "compensations": [],
    "primary": None,
}
"""What documents of the format `result/1` have where no analysis records its settings itself."""


def settings_as_asked(
    analyses: Sequence[AnalysisRef], found: Sequence[Findings], lookup: Lookup
) -> dict[str, object]:
    """Return the settings of analyses, each plugin's with its defaults, for JSON.

    `found` is what each of them found: its details may record its settings.
    """
    own = [{k: v for one in each.details for k, v in one.settings().items()} for each in found]
    named = [_resolved(lookup, each) for each, told in zip(analyses, own, strict=True) if not told]
    recorded = {key: value for told in own for key, value in told.items()}
    return {**(recorded or _NONE), **({"named": named} if named else {})}


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
