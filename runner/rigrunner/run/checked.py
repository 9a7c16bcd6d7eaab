"""Checks of a procedure without a station; imports neither stations nor plans."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.procedure import check_result_limits, kinds_of, load_procedure
from rigrunner.registry import load_registry

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.procedure import LoadedProcedure


def checked_alone(procedure: Path, text: str | None = None) -> LoadedProcedure:
    """Load and check a procedure without a station; raise InvalidFileError.

    `text` replaces the content of the file.
    """
    registry = load_registry()
    loaded = load_procedure(procedure, kinds_of(registry), text=text)
    check_result_limits(loaded, registry)
    return loaded
