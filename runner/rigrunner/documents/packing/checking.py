"""Check that a run file is intact, before it is packed and before it is unpacked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.runfile import file_differences, read_info, refuse_crashing

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.runfile import RunInfo


def require_sound(file: Path) -> RunInfo:
    """Return the contents of a run file; raise DataError if it is damaged."""
    refuse_crashing(file)
    differences = file_differences(file)
    if differences:
        raise DataError(
            f"{file} has changed since it was sealed: {differences[0]}",
            hint=f"'rigrunner verify {file}' lists all that differs",
        )
    return read_info(file)
