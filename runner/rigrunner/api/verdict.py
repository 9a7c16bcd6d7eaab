"""Verdicts: limits, decision rules, and decisions, made at once or later.

Result file, archive, panel, certificate and report are views of this one model. A decision rule
(JCGM 106, 8; ILAC-G8:09/2019, 4.2) is a plugin; it states the verdict on a value by its distance
from the limits. Verdict, reason, risks and the marginal state follow.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from math import inf, isfinite, isinf, nan, ulp
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.units import from_si, with_symbol
from rigrunner.moved import moved

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.measurands import LimitedMeasurand
    from rigrunner.api.quantity import Estimate

MEAN = "mean"
"""What is decided on besides single set-points: the mean over all."""
CERTAIN = 0.9999
"""A greater probability is not printed as a number, which would suggest certainty."""


_ROUNDINGS = 4
"""Each of two conversions of units rounds twice at most: by factor and by offset."""
_DIGITS = (4, 6, 9, 12, 17)
"""A value is shown with the fewest digits with which it differs from the limit that it missed."""


def probability_text(probability: float) -> str:
    """Return a probability in per cent, without a false 0 or 100."""
    if probability > CERTAIN:
        return "> 99.99 %"
    return "< 0.01 %" if probability < 1 - CERTAIN else f"{100 * probability:.2f} %"


def risk_text(risk: float) -> str:
    """Return the greatest value of a risk in per cent, for 'at most'; never 0."""
    return f"{max(100 * risk, 100 * (1 - CERTAIN)):.2f} %"


class Verdict(StrEnum):
    """The result of a decision; a run without limits has none."""

    PASS = "pass"  # noqa: S105  (a verdict, not a password)
    CONDITIONAL_PASS = "conditional pass"  # noqa: S105  (a verdict, not a password)
    INCONCLUSIVE = "inconclusive"
    CONDITIONAL_FAIL = "conditional fail"
    FAIL = "fail"


WORST_FIRST = (
    Verdict.FAIL,
    Verdict.INCONCLUSIVE,
    Verdict.CONDITIONAL_FAIL,
    Verdict.CONDITIONAL_PASS,
    Verdict.PASS,
)
"""A run fails if one of its limits fails, and passes if all pass."""


def worst(verdicts: Iterable[Verdict | None]) -> Verdict | None:
    """Return the worst of some verdicts; None for none."""
    return min((verdict for verdict in verdicts if verdict), key=WORST_FIRST.index, default=None)


@dataclass(frozen=True)
class Limits:
    """Limits of a value; infinite for no limit."""

    lower: float
    upper: float
    unit: str = "N·m"
    """Unit of the limits, and of the values that they apply to."""
    shown_in: str = ""
    """Unit of limits and values in texts, such as °C for K; '' for `unit`."""

    @classmethod
    def between(
        cls, lower: float | None, upper: float | None, unit: str = "N·m", *, shown_in: str = ""
    ) -> Limits:
        """Return limits, with infinity for None."""
        bounds = -inf if lower is None else lower, inf if upper is None else upper
        return cls(*bounds, unit, shown_in)

    def __str__(self) -> str:
        """Return the limits as text: '≤ 0.95 N·m', '0.2 N·m to 0.95 N·m'."""
        return self._text("≥ {}", "≤ {}", "{} to {}")

    @property
    def in_words(self) -> str:
        """The limits in English: '0.5 N·m or less'; '20 °C to 26 °C'."""
        return self._text("{} or more", "{} or less", "{} to {}")

    @property
    def in_signs(self) -> str:
        """The limits in signs, for pages in any language: '≤ 0.5 N·m'; '20 °C … 26 °C'."""
        return self._text("≥ {}", "≤ {}", "{} … {}")

    def shown(self, value: float, digits: int = 12) -> str:
        """Return a value in the unit of texts."""
        number, symbol = value, self.shown_in or self.unit
        if symbol != self.unit:
            number = from_si(value, symbol)
        return with_symbol(f"{number:.{digits}g}", symbol)

    def shown_apart(self, value: float) -> str:
        """Return the same, with the fewest digits with which it differs from a limit beside it."""
        limits = {self.shown(limit) for limit in self.edges(0.0) if not _is_on(limit, value)}
        texts = (self.shown(value, digits) for digits in _DIGITS)
        return next((text for text in texts if text not in limits), self.shown(value, 17))

    def allow(self, value: float) -> bool:
        """Return whether a value is within the limits, limits included; NaN is not.

        A value that only the rounding of units takes beyond a limit is on it: 0.9 mV, read in mV,
        is 0.0009000000000000001 V.
        """
        inside = self.lower <= value <= self.upper
        return inside or any(_is_on(limit, value) for limit in self.edges(0.0))

    def violated(self, value: float, by: float = 0.0) -> Limits:
        """Return the limit that a value violates by a margin; both limits for none."""
        # `not >=`, as nan is inside no limit.
        if not isinf(self.lower) and not value - self.lower >= by:
            return replace(self, upper=inf)
        if not isinf(self.upper) and not self.upper - value >= by:
            return replace(self, lower=-inf)
        return self

    def margin(self, value: float) -> float:
        """Return the distance of the value inside the nearer limit; negative outside."""
        return min(value - self.lower, self.upper - value)

    def edges(self, inward: float) -> tuple[float, ...]:
        """Return the limits moved inwards by that much (outwards if negative), lower one first."""
        moved = (self.lower + inward, self.upper - inward)
        return tuple(edge for edge in moved if not isinf(edge))

    def can_be_within(self, guard: float) -> bool:
        """Return whether a value can be inside both limits by that much."""
        return self.upper - self.lower >= 2 * guard

    def _text(self, at_least: str, at_most: str, between: str) -> str:
        low, high = self.shown(self.lower), self.shown(self.upper)
        if isinf(self.lower):
            return at_most.format(high)
        return at_least.format(low) if isinf(self.upper) else between.format(low, high)


def _is_on(limit: float, value: float) -> bool:
    return abs(value - limit) <= _ROUNDINGS * ulp(limit)


@dataclass(frozen=True)
class Zone:
    """Values inside their limits by a margin get this verdict, or a better one."""

    verdict: Verdict
    """Any but `fail`, the verdict outside all zones."""
    margin: float
    """Least distance inside the nearer limit, in its unit; negative: greatest distance outside."""
    width: str = ""
    """The distance as text for the reason: 'U', 'w = 0.5 U'; '' for 0."""


class DecisionRule(Protocol):
    """States the verdict on a value by its position relative to its limits.

    It gets the limits and the estimate, whose uncertainty is known and not zero. It must not depend
    on `estimate.value`: the zones apply to every value with that uncertainty.
    """

    @property
    def words(self) -> Mapping[str, str]:
        """The rule in one sentence, by language: 'en', and 'de' if known."""
        ...

    def __call__(self, limits: Limits, estimate: Estimate) -> Sequence[Zone]:
        """Return the zones from the best verdict to the worst, with decreasing margins."""
        ...


@dataclass(frozen=True, kw_only=True)
class LimitDecision:
    """The decision on one result by one limit, with all that is needed to understand it."""

    of: str = MEAN
    """What the limit applies to: 'mean', one set-point, such as '35 Hz', or a named result and its
    place."""
    named: str = ""
    """Name of the result."""
    verdict: Verdict
    reason: str
    """One sentence."""
    limits: Limits
    """Limits of the result, in the unit of every number here."""
    source: str
    """Source of the limits."""
    result: Estimate | None = None
    """The result; None if there is none."""
    coordinates: Mapping[str, CoordinateValue] = field(default_factory=dict)
    """Place of the result; empty for a mean, and for the only result of its name."""
    guard_band: float = nan
    """w: a result inside the limits by at least w passes; nan if unknown."""
    false_accept_risk: float = nan
    """The highest probability that an item which this rule passes does not conform.

    The specific risk of false acceptance for this uncertainty (JCGM 106, 3.3.13); nan if unknown,
    or if no result could pass.
    """
    false_reject_risk: float = nan
    """The highest probability that an item which this rule fails conforms."""
    probability: float = nan
    """Probability that the true value is within the limits (JCGM 106, 7); nan if unknown."""
    uncompensated: Verdict | None = None
    """The verdict of the same rule on the uncorrected value; None where there is none."""
    marginal: bool = False
    """Whether a change of the result within the marginal band would change the verdict."""
    measurand: LimitedMeasurand | None = None
    """The measurand that the limit is stated for."""

    if not TYPE_CHECKING:  # a checker would take any name

        def __getattr__(self, name: str) -> Any:
            """Return a name that has moved from this class; raise AttributeError for any other."""
            return moved(f"{__name__}.LimitDecision", name)(self)

    @property
    def passes(self) -> bool:
        """Whether the verdict is `pass`."""
        return self.verdict is Verdict.PASS

    @property
    def badness(self) -> tuple[int, float, float]:
        """Sort key of the limits of a run; the deciding one comes first.

        Verdict, probability and, if this is nearly 1 or nearly 0 for several, the distance from the
        limit in standard uncertainties.
        """
        result, distance = self.result, -inf
        if result is not None and result.u > 0:
            distance = self.limits.margin(result.value) / result.u
        # Where it is not known, the limit comes before those with a known probability. Beyond what
        # is printed only the tails of two distributions differ, and the last digits of a computer.
        clipped = min(max(self.probability, 1 - CERTAIN), CERTAIN)
        probability = clipped if isfinite(self.probability) else -inf
        return WORST_FIRST.index(self.verdict), probability, distance


@dataclass(frozen=True, kw_only=True)
class Decision:
    """The verdict on the results of a run: all limits, and the decision rule."""

    rule: str
    """The rule with its description: 'simple: ...'."""
    rule_in: Mapping[str, str] = field(default_factory=dict)
    """The description in other languages, if available."""
    parts: tuple[LimitDecision, ...]
    """The decisions on mean and set-points, at least one."""

    @cached_property
    def deciding(self) -> LimitDecision:
        """The deciding limit: the worst one, as it applies to the run.

        Among equal verdicts it is the one with the least probability of conformity. Its reason
        names the result if there are several means. The verdict on the uncorrected value is the
        worst of all limits.
        """
        worst_part = min(self.parts, key=lambda part: part.badness)
        uncompensated = worst(part.uncompensated for part in self.parts)
        uncompensated = None if worst_part.uncompensated is None else uncompensated
        return replace(worst_part, reason=self._reason(worst_part), uncompensated=uncompensated)

    @property
    def verdict(self) -> Verdict:
        """The verdict of the deciding limit."""
        return self.deciding.verdict

    @property
    def reason(self) -> str:
        """The reason of the deciding limit, in one sentence."""
        return self.deciding.reason

    def words(self, part: LimitDecision) -> str:
        """Return what a limit applies to, with the name of a corrected result among others."""
        if part.uncompensated is not None and len({other.named for other in self.parts}) > 1:
            return f"{part.named}, {part.of}"
        return part.of

    def _reason(self, part: LimitDecision) -> str:
        if (words := self.words(part)) != part.of or part.uncompensated is None:
            # Not of a name: 'V' may be another result than 'v'.
            start = words[:1] if words.startswith(part.named) else words[:1].upper()
            return f"{start}{words[1:]}: {part.reason}"
        if len(self.parts) == 1 and part.of == MEAN:
            return part.reason
        where = "The mean" if part.of == MEAN else f"At {part.of}"
        return f"{where}: {part.reason[:1].lower()}{part.reason[1:]}"


@dataclass(frozen=True, kw_only=True)
class LaterDecision:
    """A later decision on a stored run by another rule or limit, recorded beside it."""

    file: str
    decided_utc: str
    by: str
    why: str
    """The stated reason for the new decision."""
    verdict: str
    reason: str
    rule: str
    limit_text: str
    limit_source: str
    verdict_before: str
    """The verdict until then; 'none' without one."""
    rule_before: str
    limit_before: str
