"""Limits of measured values, as stated by the steps of a procedure.

Table, run file, report, panel and certificate show a missed limit from the `LimitDecision` of the
limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import nan
from typing import TYPE_CHECKING

from rigrunner.api.quantity import Estimate
from rigrunner.api.units import si_symbol, unit
from rigrunner.api.verdict import LimitDecision, Limits, Verdict

if TYPE_CHECKING:
    from rigrunner.api.quantity import Quantity

STATISTICS = ("mean", "minimum", "maximum", "peak_to_peak", "rms")
"""The statistics of a recording that can have limits, as procedures and tables name them."""
STATED_BY = "the procedure"
"""The source of these limits."""


@dataclass(frozen=True)
class ValueLimit:
    """The limit that a step sets for one of its values, in plans, events and run files.

    Numbers are in the SI unit of the value. `limits` are the limits with their meaning.
    """

    of: str
    """The value: a channel, 'role.name', or a statistic of a recording, 'role.name.statistic'."""
    minimum: float | None = None
    maximum: float | None = None
    unit: str = "1"
    """Symbol of the unit of the limit in the procedure, in which texts show the value."""
    marginal: float = 0.0
    """A value inside the limit by less than this is marginal."""

    @classmethod
    def between(
        cls, of: str, low: Quantity | None, high: Quantity | None, marginal: float = 0.0
    ) -> ValueLimit:
        """Return the limit with these bounds, at least one; `marginal` in the SI unit."""
        bound = high or low
        symbol = "1" if bound is None else bound.unit.symbol
        lower, upper = (None if bound is None else bound.si for bound in (low, high))
        return cls(of, lower, upper, symbol, marginal)

    @cached_property  # it is needed for each measured value
    def limits(self) -> Limits:
        """The limits in the SI unit of the value, displayed in the unit of the procedure."""
        si = si_symbol(unit(self.unit).dimension)
        return Limits.between(self.minimum, self.maximum, si, shown_in=self.unit)

    def is_marginal(self, value: float) -> bool:
        """Return whether a value is within the limits, but by less than `marginal`."""
        # A value that only rounding takes beyond a limit is within it, with a margin below 0.
        return self.limits.allow(value) and max(self.limits.margin(value), 0.0) < self.marginal

    def decision(self, value: float) -> LimitDecision:
        """Return the decision on a value as read, without its uncertainty.

        This is simple acceptance (JCGM 106, 8.2); no risk is stated.
        """
        limits, marginal = self.limits, self.is_marginal(value)
        verdict = Verdict.PASS if limits.allow(value) else Verdict.FAIL
        allowed = limits.violated(value, self.marginal if marginal else 0.0).in_words
        mark = ", marginal" if marginal else ""
        return LimitDecision(
            of=self.of,
            verdict=verdict,
            reason=f"{self.of} is {limits.shown_apart(value)}{mark} (limit: {allowed})",
            limits=limits,
            source=STATED_BY,
            result=Estimate(value, nan, unit=limits.unit),
            uncompensated=verdict,
            marginal=marginal,
        )
