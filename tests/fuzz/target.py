"""A reader as the fuzzer sees it."""

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
    """Returns valid files, made in an empty folder."""
    read: Callable[[Path], object]
    """Reads the file, which is alone in its folder."""
