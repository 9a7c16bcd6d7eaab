"""A study as JSON, and its report by a plugin."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from datetime import datetime
from math import isfinite
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import UsageError
from rigrunner.api.hooks import StudyFormatRecord
from rigrunner.clock import utc_text
from rigrunner.registry import load_registry

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.studies import StudyInput

KIND = "study_format"
_NAMES = {"Trend": "trend", "CapabilityStudy": "capability", "GaugeStudy": "gauge-rr"}


def write_study(study: StudyInput, path: Path) -> None:
    """Write the report of a study, in the format of the file's suffix; raise UsageError."""
    registry = load_registry()
    plugins = [plugin.record for plugin in registry.plugins if plugin.kind == KIND]
    records = [record for record in plugins if isinstance(record, StudyFormatRecord)]
    name = next((record.name for record in records if record.suffix == path.suffix), "")
    if not name:
        suffixes = ", ".join(sorted({record.suffix for record in records}))
        raise UsageError(f"no report is written as '{path.name}'", hint=f"end it with: {suffixes}")
    content = registry.make(KIND, name, {})(study)
    try:
        path.write_bytes(content)
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}") from error


def study_document(study: StudyInput) -> dict[str, Any]:
    """Return a study as JSON values: times as text, what is not finite as the text 'infinite'."""
    return {"format": f"rigrunner: {_NAMES[type(study).__name__]}/1", **_json(study)}


def _json(value: Any) -> Any:
    if is_dataclass(value):
        return {field.name: _json(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, (list, tuple)):
        return [_json(entry) for entry in value]
    if isinstance(value, datetime):
        return utc_text(value)
    if isinstance(value, float) and not isfinite(value):
        return "infinite"
    return {key: _json(entry) for key, entry in value.items()} if hasattr(value, "items") else value
