"""The verdict: limits, decision rules, and what was decided by them, at once or later.

The one model of it: result file, archive, panel, certificate and report are views of this. A rule
(JCGM 106, 8; ILAC-G8:09/2019, 4.2) is a plugin; it says what a value within or outside its limits
gets, and everything else follows: verdict, reason, risks, and whether the verdict is marginal.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from math import inf, isfinite, isinf, nan
from typing import TYPE_CHECKING, Protocol

from rigrunner.api.units import unit

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.measurand import MeasurandKind
    from rigrunner.api.quantity import Estimate

MEAN = "mean"
"""What is judged where not a single set-point is: the mean over all of them."""
CERTAIN = 0.9999
"""A probability beyond this is not printed as a number: it would look like certainty."""


_DIGITS = (4, 6, 9, 12, 17)
"""A value is shown with the fewest of these by which it differs from the limit that it missed."""


def probability_text(probability: float) -> str:
    """Return a probability in per cent, without a false 0 or 100."""
    if probability > CERTAIN:
        return "> 99.99 %"
    return "< 0.01 %" if probability < 1 - CERTAIN else f"{100 * probability:.2f} %"


class Verdict(StrEnum):
    """What was decided; a run without limits has none."""

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
"""A run fails if one of its limits does, and passes if all of them do."""


def worst(verdicts: Iterable[Verdict | None]) -> Verdict | None:
    """Return the worst of some verdicts; None where there is none."""
    return min((each for each in verdicts if each), key=WORST_FIRST.index, default=None)


@dataclass(frozen=True)
class Limits:
    """What a value may be; infinite where there is no limit."""

    lower: float
    upper: float
    unit: str = "N·m"
    """Of these numbers, and of the values that they are for."""
    shown_in: str = ""
    """The unit in which texts have limits and values, such as °C for K; '' for `unit`."""

    @classmethod
    def between(
        cls, lower: float | None, upper: float | None, unit: str = "N·m", *, shown_in: str = ""
    ) -> Limits:
        """Return limits with infinity where there is none."""
        ends = -inf if lower is None else lower, inf if upper is None else upper
        return cls(*ends, unit, shown_in)

    def __str__(self) -> str:
        """Return the limits as a person writes them: '≤ 0.95 N·m', '0.2 N·m to 0.95 N·m'."""
        return self._text("≥ {}", "≤ {}", "{} to {}", digits=6)

    @property
    def in_words(self) -> str:
        """The limits in words: '0.5 N·m or less'; '20 °C to 26 °C'."""
        return self._text("{} or more", "{} or less", "{} to {}")

    @property
    def in_signs(self) -> str:
        """The limits in signs, for pages in any language: '≤ 0.5 N·m'; '20 °C … 26 °C'."""
        return self._text("≥ {}", "≤ {}", "{} … {}")

    def shown(self, value: float, digits: int = 12) -> str:
        """Return a value in the unit that texts have."""
        number, symbol = value, self.shown_in or self.unit
        if symbol != self.unit:
            known = unit(symbol)
            number = (value - known.offset) / known.factor
        return f"{number:.{digits}g} {symbol}"

    def shown_apart(self, value: float) -> str:
        """Return the same, with the fewest digits by which it differs from a limit beside it."""
        limits = {self.shown(limit) for limit in self.edges(0.0) if limit != value}
        texts = (self.shown(value, digits) for digits in _DIGITS)
        return next((text for text in texts if text not in limits), self.shown(value, 17))

    def allow(self, value: float) -> bool:
        """Say whether a value is within the limits, these included; NaN is not."""
        return self.lower <= value <= self.upper

    def not_kept(self, value: float, by: float = 0.0) -> Limits:
        """Return the one limit that a value is not within by that much; both where it is."""
        if not isinf(self.lower) and not value - self.lower >= by:
            return replace(self, upper=inf)
        if not isinf(self.upper) and not self.upper - value >= by:
            return replace(self, lower=-inf)
        return self

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

    def _text(self, at_least: str, at_most: str, both: str, *, digits: int = 12) -> str:
        low, high = self.shown(self.lower, digits), self.shown(self.upper, digits)
        if isinf(self.lower):
            return at_most.format(high)
        return at_least.format(low) if isinf(self.upper) else both.format(low, high)


@dataclass(frozen=True)
class Zone:
    """The values that are within their limits by a margin get this verdict, or a better one."""

    verdict: Verdict
    """Any but `fail`, which is what a value outside all zones gets."""
    margin: float
    """How far within the nearer limit, in its unit; negative: how far outside at most."""
    width: str = ""
    """What that distance is, for the reason: 'U', 'w = 0.5 U'; '' where it is 0."""


class DecisionRule(Protocol):
    """Says which verdict a value gets by its place within or outside its limits.

    It receives the limits and the estimate, whose uncertainty is known and not zero, and says
    nothing of values by `estimate.value`: the same rule holds for every value of that uncertainty.
    """

    @property
    def words(self) -> Mapping[str, str]:
        """What it does, in one sentence by language: 'en', and 'de' where that is known."""
        ...

    def __call__(self, limits: Limits, estimate: Estimate) -> Sequence[Zone]:
        """Return the zones from the best verdict to the worst, their margins falling."""
        ...


@dataclass(frozen=True, kw_only=True)
class LimitDecision:
    """What one limit says of one result, with all that is needed to understand it."""

    of: str = MEAN
    """What is judged: 'mean', one set-point, such as '35 Hz', or a named result and its place."""
    named: str = ""
    """The name of the result."""
    verdict: Verdict
    reason: str
    """One sentence."""
    limits: Limits
    """What the result may be, in the unit of every number here."""
    source: str
    """Who says so."""
    result: Estimate | None = None
    """What was judged; None where there is nothing to judge."""
    coordinates: Mapping[str, CoordinateValue] = field(default_factory=dict)
    """Where that result holds; empty of a mean, and of the only result of its name."""
    guard_band: float = nan
    """w: a result passes that is within the limits by at least w; nan where unknown."""
    false_accept_risk: float = nan
    """The highest probability that an item which this rule passes does not conform.

    The specific risk of false acceptance, for this uncertainty (JCGM 106, 3.3.13); nan where
    unknown, or where no result could pass.
    """
    false_reject_risk: float = nan
    """The highest probability that an item which this rule fails conforms."""
    probability: float = nan
    """That the true value is within the limits (JCGM 106, 7); nan where unknown."""
    uncompensated: Verdict | None = None
    """What the same rule would say of the raw torque; None of another quantity."""
    marginal: bool = False
    """Whether a result different by no more than the marginal band had another verdict."""
    measurand: MeasurandKind | None = None
    """What the limit is a limit of."""
    load_n: float | None = None
    """The load that the limit is for, where it names one."""

    @property
    def passes(self) -> bool:
        """Whether the verdict is `pass`."""
        return self.verdict is Verdict.PASS

    @property
    def badness(self) -> tuple[int, float, float]:
        """What sorts the limits of a run, the one that decides first.

        Verdict, probability, and, where that is as good as certain of several, how many standard
        uncertainties the value is within its limit.
        """
        found, within = self.result, -inf
        if found is not None and found.u > 0:
            within = self.limits.margin(found.value) / found.u
        probability = self.probability if isfinite(self.probability) else -inf
        return WORST_FIRST.index(self.verdict), probability, within


@dataclass(frozen=True, kw_only=True)
class Decision:
    """The verdict on the results of a run: every limit, and the rule by which it was decided."""

    rule: str
    """The rule with its words: 'simple: ...'."""
    rule_in: Mapping[str, str] = field(default_factory=dict)
    """These words in other languages than English, where the rule has them."""
    parts: tuple[LimitDecision, ...]
    """Every limit on the mean and on the set-points, at least one."""

    @cached_property
    def deciding(self) -> LimitDecision:
        """The limit that decides: the worst, as it stands for the run.

        Among equal verdicts it is the one with the least probability of conformity. Its reason
        names what it is of where that is not the only mean; what the rule would say of the raw
        torque is the worst of all limits.
        """
        worst_part = min(self.parts, key=lambda part: part.badness)
        raw = worst(part.uncompensated for part in self.parts)
        raw = None if worst_part.uncompensated is None else raw
        return replace(worst_part, reason=self._reason(worst_part), uncompensated=raw)

    @property
    def verdict(self) -> Verdict:
        """That of the limit that decides."""
        return self.deciding.verdict

    @property
    def reason(self) -> str:
        """That of the limit that decides, in one sentence."""
        return self.deciding.reason

    def words(self, part: LimitDecision) -> str:
        """Return what a limit is of: a torque by its name where others are limited as well."""
        if part.uncompensated is not None and len({each.named for each in self.parts}) > 1:
            return f"{part.named}, {part.of}"
        return part.of

    def _reason(self, part: LimitDecision) -> str:
        if (words := self.words(part)) != part.of or part.uncompensated is None:
            return f"{words[:1].upper()}{words[1:]}: {part.reason}"
        if len(self.parts) == 1 and part.of == MEAN:
            return part.reason
        where = "The mean" if part.of == MEAN else f"At {part.of}"
        return f"{where}: {part.reason[:1].lower()}{part.reason[1:]}"


@dataclass(frozen=True, kw_only=True)
class LaterDecision:
    """A stored run decided again by another rule or limit, as put on record beside it."""

    file: str
    decided_utc: str
    by: str
    why: str
    """The reason that was given for deciding again."""
    verdict: str
    reason: str
    rule: str
    limit_text: str
    limit_source: str
    verdict_before: str
    """What held until then; 'none' where nothing had been decided."""
    rule_before: str
    limit_before: str
