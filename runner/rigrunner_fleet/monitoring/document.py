"""A study as JSON."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from datetime import datetime
from math import isfinite
from typing import TYPE_CHECKING, Any

from rigrunner.clock import utc_text

if TYPE_CHECKING:
    from rigrunner.api.studies import StudyInput

_KINDS = {"Trend": "trend", "CapabilityStudy": "capability", "GaugeStudy": "gauge-rr"}


def study_document(study: StudyInput) -> dict[str, Any]:
    """Return a study as JSON values: times as text, what is not finite as the text 'infinite'."""
    return {"format": f"rigrunner: {_KINDS[type(study).__name__]}/1", **_json(study)}


def _json(value: Any) -> Any:
    if is_dataclass(value):
        return {each.name: _json(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, (list, tuple)):
        return [_json(each) for each in value]
    if isinstance(value, datetime):
        return utc_text(value)
    if isinstance(value, float) and not isfinite(value):
        return "infinite"
    return {key: _json(each) for key, each in value.items()} if hasattr(value, "items") else value
