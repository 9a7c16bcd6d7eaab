"""Limits of measured values, as the steps of a procedure state them.

Every view of a missed limit is made of the `LimitDecision` that a limit gives: table, run file,
report, panel, certificate.
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
"""The statistics of a recording that may have limits, as procedures and tables name them."""
STATED_BY = "the procedure"
"""The source of these limits."""


@dataclass(frozen=True)
class ValueLimit:
    """The limit that a step sets on one of its values, as plans, events and run files have it.

    Numbers in the SI unit of the value. Its meaning is in `limits`.
    """

    of: str
    """The value: a channel, 'role.name', or of a recording 'role.name.statistic'."""
    minimum: float | None = None
    maximum: float | None = None
    unit: str = "1"
    """The symbol of the unit in which the procedure states the limit, and texts show the value."""
    marginal: float = 0.0
    """A value within the limit, but nearer to it than this, is marginal."""

    @classmethod
    def between(
        cls, of: str, low: Quantity | None, high: Quantity | None, marginal: float = 0.0
    ) -> ValueLimit:
        """Return the limit with these bounds, at least one; `marginal` in the SI unit."""
        written = high or low
        symbol = "1" if written is None else written.unit.symbol
        least, most = (None if each is None else each.si for each in (low, high))
        return cls(of, least, most, symbol, marginal)

    @cached_property  # each value that is measured is held against it
    def limits(self) -> Limits:
        """The limits in the SI unit of the value, shown in the unit of the procedure."""
        si = si_symbol(unit(self.unit).dimension)
        return Limits.between(self.minimum, self.maximum, si, shown_in=self.unit)

    def is_marginal(self, value: float) -> bool:
        """Say whether a value is within the limits, but nearer to one of them than `marginal`."""
        return self.limits.allow(value) and self.limits.margin(value) < self.marginal

    def decision(self, value: float) -> LimitDecision:
        """Return the decision on a value as it was read, without its uncertainty.

        That is simple acceptance (JCGM 106, 8.2); no risk is stated.
        """
        limits, marginal = self.limits, self.is_marginal(value)
        verdict = Verdict.PASS if limits.allow(value) else Verdict.FAIL
        allowed = limits.not_kept(value, self.marginal if marginal else 0.0).in_words
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
