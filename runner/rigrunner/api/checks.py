"""Checks with a threshold: the allowed range, the value found, and advice."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isnan, nextafter
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Check, Consequence

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.analysis import Bias


NOT_CHECKED = "not checked: "
"""Start of the text of a check that could not be made."""
ABOVE_ZERO = nextafter(0.0, 1.0)
"""The smallest number above 0."""


@dataclass(frozen=True, kw_only=True)
class Limit:
    """The limits of a check, from `lower` to `upper`, both included.

    `good` is the text if all values are inside; `advice` is what to do otherwise.
    """

    name: str
    good: str
    advice: str
    unit: str
    """Unit of value and limits: '1' for a number without unit."""
    lower: float = -inf
    upper: float = inf
    decisive: bool = False
    """Whether a value outside makes the verdict inconclusive."""

    @property
    def allowed(self) -> str:
        """The allowed range as text: 'at most 2 %', '0.01 to 0.3', 'above 0 N·m'."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        if self.lower == ABOVE_ZERO:
            return f"above 0{unit}"
        if self.upper == inf:
            return f"at least {self.lower:g}{unit}"
        if self.lower == -inf:
            return f"at most {self.upper:g}{unit}"
        return f"{self.lower:g} to {self.upper:g}{unit}"

    def check(self, items: Iterable[tuple[float, str]], prefix: str = "") -> Check:
        """Return the check of values, each with its text for being outside."""
        values = list(items)
        bad = [text for value, text in values if self._margin(value) < 0]
        worst = min((value for value, _ in values), key=self._margin, default=None)
        nearer = None
        if worst is not None:
            nearer = self.lower if worst - self.lower < self.upper - worst else self.upper
        return Check(
            f"{prefix}{self.name}",
            ok=not bad,
            text="; ".join(bad) or self.good,
            advice=self.advice if bad else "",
            value=worst,
            threshold=nearer,
            unit=self.unit,
            decisive=self.decisive,
        )

    def _margin(self, value: float) -> float:
        """Return the distance of a value inside the limits; negative outside, and for a NaN."""
        return -inf if isnan(value) else min(value - self.lower, self.upper - value)


def skipped(name: str, why: str) -> Check:
    """Return a check that could not be made, which is not a failure."""
    return Check(name, ok=True, text=f"{NOT_CHECKED}{why}")


def effect_words(check: Check) -> str:
    """Return the consequence of a judged check for the result as text; '' for none.

    '+0.012 N·m on the mean, +0.031 N·m at 35 Hz; in the budget as 'drive line''.
    """
    follows = _FOLLOWS[check.consequence].format(name=check.name)
    mean, *points = check.biases or (None,)
    if mean is None:
        if check.consequence is Consequence.INCONCLUSIVE:
            return f"its effect cannot be estimated; {follows}{' there' if check.of else ''}"
        return follows
    moved = [f"{_moved(mean)} on the mean"]
    if len(points) > 1:
        worst = max(points, key=lambda point: point.contribution)
        moved.append(f"{_moved(worst)} at {worst.of}")
    return "; ".join([", ".join(moved), *([follows] if follows else [])])


_FOLLOWS = {
    Consequence.NOTHING: "",
    Consequence.NOTE: "a note: no result moves by as much as matters",
    Consequence.BUDGET: "in the budget as '{name}'",
    Consequence.INCONCLUSIVE: "no verdict",
}


def _moved(bias: Bias) -> str:
    return f"{bias.value:+.4f} ± {bias.u:.4f} {bias.unit}"


def is_skipped(check: Check) -> bool:
    """Return whether a check could not be made, by its text, which older files have too."""
    return check.ok and check.text.startswith(NOT_CHECKED)


def forbidden(checks: Iterable[Check]) -> str:
    """Return the first check that forbids to decide, as a sentence; '' where none does."""
    for check in checks:
        if check.consequence is Consequence.INCONCLUSIVE:
            advice = f" ({check.advice})" if check.advice else ""
            effect = f"; {words}" if (words := effect_words(check)) else ""
            return f"The check '{check.name}' failed: {check.text}{effect}{advice}."
    return ""
