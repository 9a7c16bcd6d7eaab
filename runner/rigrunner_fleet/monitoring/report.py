"""Write the report of a study, by a plugin."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.api.hooks import StudyFormatRecord
from rigrunner.registry import load_registry

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.studies import StudyInput

KIND = "study_format"


def write_study(study: StudyInput, path: Path) -> None:
    """Write the report of a study, in the format of the file's suffix; raise UsageError."""
    registry = load_registry()
    found = [each.record for each in registry.plugins if each.kind == KIND]
    records = [each for each in found if isinstance(each, StudyFormatRecord)]
    name = next((each.name for each in records if each.suffix == path.suffix), "")
    if not name:
        suffixes = ", ".join(sorted({each.suffix for each in records}))
        raise UsageError(f"no report is written as '{path.name}'", hint=f"end it with: {suffixes}")
    content = registry.make(KIND, name, {})(study)
    try:
        path.write_bytes(content)
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}") from error
