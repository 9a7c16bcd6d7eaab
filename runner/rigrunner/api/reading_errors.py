"""What a reading may be off by: one line for each error that the register knows."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal

Shape = Literal["rectangular", "triangular", "arcsine", "normal"]
Acts = Literal["gain", "offset", "each"]


@dataclass(frozen=True)
class ReadingError:
    """One error of a reading, as the register states it."""

    name: str
    """Such as 'gain of meter.resistance'."""
    acts: Acts
    """`gain`: one and the same share of all readings. `offset`: one and the same for all readings.
    `each`: within its limits at each reading; what two readings share of it nobody states."""
    u: float
    """The standard uncertainty, in the SI unit of the channel; of a gain a share of the reading."""
    dof: float = inf
    distribution: Shape = "rectangular"
    source: str = ""
    """Who states it; '' where the register does not say."""

    def at(self, value: float) -> float:
        """Return the standard uncertainty of a reading of that value, in the SI unit."""
        return self.u * abs(value) if self.acts == "gain" else self.u
