"""An interval that a value may be in, and how probable it is that the true value is (JCGM 106)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isinf
from typing import TYPE_CHECKING

from rigrunner.signal.coverage import cumulative

if TYPE_CHECKING:
    from rigrunner.api.data import Estimate
    from rigrunner.procedure import Limit


@dataclass(frozen=True)
class Limits:
    """What a value may be, in the unit of the measurand; infinite where there is no limit."""

    lower: float
    upper: float
    unit: str = "N·m"

    @classmethod
    def between(cls, lower: float | None, upper: float | None) -> Limits:
        """Return limits with infinity where there is none."""
        return cls(-inf if lower is None else lower, inf if upper is None else upper)

    @classmethod
    def of(cls, limit: Limit) -> Limits:
        """Return the limits that a procedure names."""
        return cls.between(limit.min, limit.max)

    def __str__(self) -> str:
        """Return the limits as a person writes them."""
        if isinf(self.lower):
            return f"≤ {self.upper:.6g} {self.unit}"
        if isinf(self.upper):
            return f"≥ {self.lower:.6g} {self.unit}"
        return f"{self.lower:.6g} {self.unit} to {self.upper:.6g} {self.unit}"

    def margin(self, value: float) -> float:
        """Return how far inside the nearer limit the value is; negative outside."""
        return min(value - self.lower, self.upper - value)

    def edges(self, inward: float) -> tuple[float, ...]:
        """Return the limits moved inward by that much (outward if negative), lower one first."""
        moved = (self.lower + inward, self.upper - inward)
        return tuple(edge for edge in moved if not isinf(edge))

    def can_be_within(self, guard: float) -> bool:
        """Return whether any value is inside both limits by that much."""
        return self.upper - self.lower >= 2 * guard


def probability(limits: Limits, estimate: Estimate) -> float:
    """Return the probability that the true value is within the limits (JCGM 106, 7).

    By the distribution that the coverage interval of the estimate has too; nothing else is known of
    the item beforehand.
    """
    if estimate.u == 0:
        return float(limits.margin(estimate.value) >= 0)
    return cumulative(estimate, limits.upper) - cumulative(estimate, limits.lower)
