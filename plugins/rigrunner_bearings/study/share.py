"""Rates with their intervals: of independent rigs, and of several values per rig."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING

from scipy.special import betaincinv

if TYPE_CHECKING:
    from rigrunner.api import Array

CONFIDENCE = 0.95


def rate_interval(hits: float, total: float) -> tuple[float, float]:
    """Return the 95 % interval total a rate (Clopper and Pearson, Biometrika 26, 1934)."""
    tail = (1 - CONFIDENCE) / 2
    lower = betaincinv(hits, total - hits + 1, tail) if hits > 0 else 0.0
    upper = betaincinv(hits + 1, total - hits, 1 - tail) if hits < total else 1.0
    return float(lower), float(upper)


@dataclass(frozen=True)
class Share:
    """A number of hits among `of` independent values."""

    hits: int
    of: int

    @property
    def rate(self) -> float:
        """The share of hits."""
        return self.hits / self.of

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the rate."""
        return rate_interval(self.hits, self.of)

    def document(self) -> dict[str, object]:
        """Return the content for JSON."""
        return {"hits": self.hits, "of": self.of, "interval_95": list(self.interval)}


@dataclass(frozen=True)
class Clustered:
    """The rate of hits among values, of which those of one rig are correlated.

    `effective` is the number of independent values with the same scatter.
    """

    rate: float
    of: int
    effective: float

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval: Clopper and Pearson's for the effective number of values.

        Korn and Graubard, Survey Methodology 24(2), 1998.
        """
        return rate_interval(self.rate * self.effective, self.effective)


def clustered(hits: Array) -> Clustered:
    """Return the rate of hits of shape (rigs, values), 1 or 0.

    The effective number is p(1 - p) over the variance of the mean of the rigs' own rates; if
    all rigs have the same rate it is unknown, and each rig counts once.
    """
    rigs, values = hits.shape
    rates = hits.mean(axis=1)
    rate = float(rates.mean())
    variance = float(rates.var(ddof=1)) / rigs if rigs > 1 else 0.0
    effective = rate * (1 - rate) / variance if variance > 0 else float(rigs)
    bounded = min(effective, float(rigs * values)) if isfinite(effective) else float(rigs)
    return Clustered(rate, rigs * values, max(bounded, 1.0))
