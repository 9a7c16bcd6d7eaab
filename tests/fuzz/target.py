"""What a reader is to the fuzzer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


@dataclass(frozen=True)
class Target:
    """One reader of files."""

    name: str
    suffix: str
    seeds: Callable[[Path], list[bytes]]
    """Good files; given is an empty folder to make them in."""
    read: Callable[[Path], object]
    """Reads the file, which lies alone in a folder of its own."""
