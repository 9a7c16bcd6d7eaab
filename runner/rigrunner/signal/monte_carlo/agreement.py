"""Whether the GUM's interval agrees with that of a Monte Carlo method (JCGM 101:2008, 8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.signal.coverage import expanded
from rigrunner.signal.monte_carlo.intervals import Interval, numerical_tolerance

if TYPE_CHECKING:
    from rigrunner.api.data import Estimate


@dataclass(frozen=True)
class Difference:
    """How far the ends of two coverage intervals lie apart."""

    low: float
    high: float

    def within(self, tolerance: float) -> bool:
        """Return whether both ends agree."""
        return max(self.low, self.high) <= tolerance


def gum_interval(estimate: Estimate, p: float = 0.95) -> Interval:
    """Return y -/+ U with U = k u (JCGM 100, 6.3.1)."""
    width = expanded(estimate, p)
    return Interval(estimate.value - width, estimate.value + width)


def difference(gum: Interval, monte_carlo: Interval) -> Difference:
    """Return d_low and d_high (8.1.3 b)."""
    return Difference(abs(gum.low - monte_carlo.low), abs(gum.high - monte_carlo.high))


def tolerance(estimate: Estimate, digits: int) -> float:
    """Return what both ends may differ by: half the last digit that matters of u (8.1.3 a)."""
    return numerical_tolerance(estimate.u, digits)
