"""Named diagnostics with a threshold: what is allowed, what was found, and what to do."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isnan
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Check

if TYPE_CHECKING:
    from collections.abc import Iterable


@dataclass(frozen=True, kw_only=True)
class Limit:
    """What a diagnostic allows, from `lower` to `upper`, both included.

    `good` is what is said where nothing is beyond; `advice` what to do where something is.
    """

    name: str
    good: str
    advice: str
    unit: str
    """In which value and limits are given: '1' for a bare number."""
    lower: float = -inf
    upper: float = inf

    def check(self, found: Iterable[tuple[float, str]], prefix: str = "") -> Check:
        """Return the check of values, each with the words for it should it be beyond."""
        values = list(found)
        bad = [words for value, words in values if self._margin(value) < 0]
        worst = min((value for value, _ in values), key=self._margin, default=None)
        return Check(
            f"{prefix}{self.name}",
            ok=not bad,
            text="; ".join(bad) or self.good,
            advice=self.advice if bad else "",
            value=worst,
            threshold=None if worst is None else self._nearer(worst),
            unit=self.unit,
        )

    def _margin(self, value: float) -> float:
        """Return how far within the limits a value is; negative beyond, and for a NaN."""
        return -inf if isnan(value) else min(value - self.lower, self.upper - value)

    def _nearer(self, value: float) -> float:
        return self.lower if value - self.lower < self.upper - value else self.upper


def skipped(name: str, why: str) -> Check:
    """Return a check that could not be made, which is not a failure."""
    return Check(name, ok=True, text=f"not checked: {why}")
