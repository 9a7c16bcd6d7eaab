"""A finding of the doctor, and what it checks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from datetime import datetime
    from pathlib import Path

    from rigrunner.registry import Registry

State = Literal["ok", "warn", "fail"]


@dataclass(frozen=True)
class Finding:
    """The finding of one check."""

    name: str
    state: State
    found: str
    fix: str = ""


@dataclass(frozen=True)
class Surroundings:
    """What is checked, beside the installation itself."""

    runs: Path
    registry: Registry
    now: datetime
    station: Path | None = None
    """The station to check too."""
