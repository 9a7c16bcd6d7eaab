"""The identity of a case of a study: equal cases give the same rig and the same recordings."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.random import Generator


@dataclass(frozen=True)
class Case:
    """One rig of a study."""

    simulator: str
    fault: str
    """Name of its fault; empty for a healthy rig."""
    study_seed: int
    number: int

    def rng(self, words: str) -> Generator:
        """Return the source of its random numbers; `words` distinguish the studies."""
        return np.random.default_rng([self.study_seed, zlib.crc32(words.encode()), self.number])
