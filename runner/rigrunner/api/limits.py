"""Limits of measured values, and the judgement on each value.

Every view of a missed limit is made of a `Judgement`: table, run file, report, panel, certificate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf, nextafter
from typing import TYPE_CHECKING

from rigrunner.api.units import unit

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.quantity import Quantity

_DIGITS = (4, 6, 9, 12, 17)
"""A value is shown with the fewest of these by which it differs from the bound that it missed."""
STATISTICS = ("mean", "minimum", "maximum", "peak_to_peak", "rms")
"""The statistics of a recording that may have limits, as procedures and tables name them."""


@dataclass(frozen=True)
class ValueLimit:
    """What one measured value may be; numbers in its SI unit."""

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

    def allows(self, value: float) -> bool:
        """Say whether a value is within the limit, the bounds included; NaN is not."""
        return (self.minimum is None or value >= self.minimum) and (
            self.maximum is None or value <= self.maximum
        )

    @cached_property  # each value that is measured is held against it
    def clear(self) -> tuple[float, float]:
        """The range in which a value is neither out of limits nor marginal, to be asked often.

        Where rounding could matter it is narrower by that: a value outside is to be judged.
        """
        low = -inf if self.minimum is None else self.minimum + self.marginal
        high = inf if self.maximum is None else self.maximum - self.marginal
        return (nextafter(low, inf), nextafter(high, -inf)) if self.marginal else (low, high)

    @property
    def text(self) -> str:
        """The limit in words: '0.5 N·m or less'; '20 °C to 26 °C'."""
        low, high = (self.shown(each) for each in (self.minimum, self.maximum))
        if low and high:
            return f"{low} to {high}"
        return f"{high} or less" if high else f"{low} or more"

    @property
    def sign_text(self) -> str:
        """The limit in signs, for pages in any language: '≤ 0.5 N·m'; '20 °C … 26 °C'."""
        low, high = (self.shown(each) for each in (self.minimum, self.maximum))
        if low and high:
            return f"{low} … {high}"
        return f"≤ {high}" if high else f"≥ {low}"

    def shown(self, value: float | None, digits: int = 12) -> str:
        """Return a value in the unit of the limit; '' for None."""
        return "" if value is None else f"{self.number(value):.{digits}g} {self.unit}"

    def number(self, value: float) -> float:
        """Return an SI value in the unit of the limit."""
        shown_in = unit(self.unit)
        return (value - shown_in.offset) / shown_in.factor


@dataclass(frozen=True)
class Judgement:
    """A measured value held against its limit."""

    limit: ValueLimit
    value: float
    """In the SI unit."""

    @property
    def passes(self) -> bool:
        """Whether the value is within its limit."""
        return self.limit.allows(self.value)

    @property
    def is_marginal(self) -> bool:
        """Whether the value passes, but is nearer to a bound than the limit's `marginal`."""
        return self.passes and any(
            sign * (self.value - bound) > -self.limit.marginal for _, bound, sign in self._bounds()
        )

    @property
    def verdict(self) -> str:
        """'pass' or 'fail'."""
        return "pass" if self.passes else "fail"

    @property
    def shown(self) -> str:
        """The value in the unit of its limit, with as many digits as show on which side it is."""
        bounds = [bound for _, bound, _ in self._bounds()]
        texts = (self.limit.shown(self.value, digits) for digits in _DIGITS)
        hidden = {self.limit.shown(bound) for bound in bounds if bound != self.value}
        return next(
            (text for text in texts if text not in hidden), self.limit.shown(self.value, 17)
        )

    @property
    def text(self) -> str:
        """Which value it is and what is allowed, in words, of one that fails or is marginal."""
        mark = "marginal: " if self.passes else ""
        for wanted, bound, sign in self._bounds():
            if not sign * (self.value - bound) <= -(self.limit.marginal if self.passes else 0.0):
                allowed = f"allowed is {self.limit.shown(bound)} or {wanted}"
                return f"{self.limit.of} is {self.shown}, {mark}{allowed}"
        return f"{self.limit.of} is {self.shown}, allowed is {self.limit.text}"

    def _bounds(self) -> Iterator[tuple[str, float, int]]:
        if self.limit.minimum is not None:
            yield "more", self.limit.minimum, -1
        if self.limit.maximum is not None:
            yield "less", self.limit.maximum, 1
