"""The analysis as it was asked for, for the record: with the defaults of the plugins."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.analysis.lookup import Lookup
    from rigrunner.procedure import AnalysisSpec, NamedAnalysisRef, PluginRef


def settings_as_asked(
    spec: AnalysisSpec, lookup: Lookup, analyses: Sequence[NamedAnalysisRef] = ()
) -> dict[str, object]:
    """Return the settings of an analysis, each plugin's with its defaults, for JSON."""
    checked = spec.validate_
    return {
        **({} if spec.starts is None else {"starts": spec.starts.model_dump()}),
        "despike": None if spec.despike is None else spec.despike.model_dump(),
        "outliers": _resolved(lookup, "outlier_rule", spec.outliers),
        "fits": [_resolved(lookup, "fit", each) for each in spec.fits],
        "compensations": [_resolved(lookup, "compensation", each) for each in spec.compensations],
        "primary": spec.primary or None,
        **({} if checked is None else {"validate": checked.model_dump()}),
        **({"named": [_resolved_text(lookup, each) for each in analyses]} if analyses else {}),
    }


def _resolved_text(lookup: Lookup, reference: PluginRef) -> dict[str, object]:
    """Return an analysis with its settings, quantities as they are written."""
    model = lookup.settings_of(reference.kind, reference.name)
    told = model.model_validate(dict(reference.settings)).model_dump(exclude_none=True)
    return {"name": reference.name, "settings": _as_text(told)}


def _as_text(value: object) -> object:
    if isinstance(value, dict):
        return {name: _as_text(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_as_text(each) for each in value]
    return value if isinstance(value, bool | int | float | str) else str(value)


def _resolved(lookup: Lookup, kind: str, reference: PluginRef | None) -> dict[str, object] | None:
    if reference is None:
        return None
    model = lookup.settings_of(kind, reference.name)
    settings = model.model_validate(dict(reference.settings))
    label = {} if reference.label == reference.name else {"as": reference.label}
    return {"name": reference.name, **label, "settings": settings.model_dump(mode="json")}
