"""An interval that a value may be in, and how probable it is that the true value is (JCGM 106)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isinf
from typing import TYPE_CHECKING

from scipy.special import ndtr, stdtr

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

    For a value that is distributed as t (normal, for infinite degrees of freedom) about the
    estimate, scaled by its standard uncertainty; nothing else is known of the item beforehand.
    """
    if estimate.u == 0:
        return float(limits.margin(estimate.value) >= 0)
    return _cumulative(limits.upper, estimate) - _cumulative(limits.lower, estimate)


def _cumulative(limit: float, estimate: Estimate) -> float:
    if isinf(limit):
        return 1.0 if limit > 0 else 0.0
    z = (limit - estimate.value) / estimate.u
    return float(ndtr(z) if isinf(estimate.dof) else stdtr(estimate.dof, z))
