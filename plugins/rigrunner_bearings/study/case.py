"""What names one case of a study: the same names give the same rig and the same recordings."""

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
    """What is wrong with it, by its name; empty where nothing is."""
    study_seed: int
    number: int

    def rng(self, words: str) -> Generator:
        """Return the source of all that is drawn for it; the words part the studies."""
        return np.random.default_rng([self.study_seed, zlib.crc32(words.encode()), self.number])
