"""Decision rules: what they say of a value, and the risk that they imply.

JCGM 106, 8, and ILAC-G8:09/2019, 4.2: simple acceptance, binary with a guard band, non-binary.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan
from typing import TYPE_CHECKING

from rigrunner.analysis.limits import probability
from rigrunner.api.results import Verdict
from rigrunner.signal.coverage import expanded

if TYPE_CHECKING:
    from rigrunner.analysis.limits import Limits
    from rigrunner.api.data import Estimate
    from rigrunner.procedure import Acceptance

WORDS = {
    "simple": "simple acceptance, the value alone decides (w = 0)",
    "guard_band_u": "guard band w = U of 95 %; what is not within the limit by w fails",
    "guard_band_fraction": "guard band w = {share:g} U of 95 %; what is not within the limit by w "
    "fails",
    "non_binary": "guard band w = U of 95 %; what is nearer to the limit than w is conditional",
}


@dataclass(frozen=True)
class DecisionRule:
    """A rule, with its guard band as a part of U."""

    name: str
    share: float
    """w = share · U."""
    marginal_nm: float = 0.0
    """A verdict that so small a difference would change is marginal."""

    @classmethod
    def of(cls, acceptance: Acceptance) -> DecisionRule:
        """Return the rule that a procedure names."""
        shares = {"simple": 0.0, "guard_band_fraction": acceptance.fraction or 0.0}
        share = shares.get(acceptance.rule, 1.0)
        return cls(acceptance.rule, share, acceptance.marginal or 0.0)

    def __str__(self) -> str:
        """Return the rule's name and what it does."""
        return f"{self.name}: {WORDS[self.name].format(share=self.share)}"

    @property
    def is_binary(self) -> bool:
        """Whether there is nothing between pass and fail."""
        return self.name != "non_binary"

    def guard(self, estimate: Estimate) -> float:
        """Return w in N·m, with U for 95 %; nan where the uncertainty is not known.

        Without a guard band it is 0 whatever the uncertainty.
        """
        return self.share * expanded(estimate) if self.share else 0.0

    def verdict(self, limits: Limits, estimate: Estimate) -> tuple[Verdict, str]:
        """Return the verdict on a value whose uncertainty is known, and why, in one sentence."""
        guard, margin = self.guard(estimate), limits.margin(estimate.value)
        unit = limits.unit
        place = (
            f"{estimate.value:.4f} {unit} is {abs(margin):.4f} {unit} "
            f"{'within' if margin >= 0 else 'outside'} the limit {limits}"
        )
        width = f"{self._width} = {guard:.4f} {unit}"
        if guard == 0:
            return (Verdict.PASS if margin >= 0 else Verdict.FAIL), f"{place}."
        if margin >= guard:
            return Verdict.PASS, f"{place}, by at least {width}."
        if self.is_binary:
            return _binary(place, width, margin, can_pass=limits.can_be_within(guard))
        if margin >= 0:
            return Verdict.CONDITIONAL_PASS, f"{place}, but by less than {width}."
        if margin >= -guard:
            return Verdict.CONDITIONAL_FAIL, f"{place}, but by no more than {width}."
        return Verdict.FAIL, f"{place}, by more than {width}."

    def is_marginal(self, limits: Limits, estimate: Estimate) -> bool:
        """Return whether a value that differs by the marginal band or less had another verdict."""
        if not self.marginal_nm:
            return False
        guard, margin = self.guard(estimate), limits.margin(estimate.value)
        turns = (guard,) if self.is_binary else (guard, 0.0, -guard)
        return min(abs(margin - turn) for turn in turns) <= self.marginal_nm

    def false_accept_risk(self, limits: Limits, estimate: Estimate) -> float:
        """Return the highest probability that an item with this uncertainty passes wrongly.

        Specific consumer's risk (JCGM 106, 3.3.13) at the acceptance limit, where it is greatest;
        nan where the guard bands leave no value that could pass.
        """
        guard = self.guard(estimate)
        if not limits.can_be_within(guard):
            return nan
        return max(1 - _conforming(limits, estimate, edge) for edge in limits.edges(guard))

    def false_reject_risk(self, limits: Limits, estimate: Estimate) -> float:
        """Return the highest probability that an item with this uncertainty fails wrongly.

        Specific producer's risk (JCGM 106, 3.3.14) where failing begins: at the acceptance limit
        of a binary rule, beyond the outer guard band of a non-binary one.
        """
        guard = self.guard(estimate)
        begins = -guard
        if self.is_binary:
            begins = guard if limits.can_be_within(guard) else 0.0
        return max(_conforming(limits, estimate, edge) for edge in limits.edges(begins))

    @property
    def _width(self) -> str:
        return "U" if self.share == 1 else f"w = {self.share:g} U"


def _binary(place: str, width: str, margin: float, *, can_pass: bool) -> tuple[Verdict, str]:
    if margin < 0:
        return Verdict.FAIL, f"{place}."
    if can_pass:
        return Verdict.FAIL, f"{place}, but by less than {width}: conformity is not demonstrated."
    why = f"no value is within both limits by {width}: so uncertain a result cannot pass"
    return Verdict.INCONCLUSIVE, f"{place}, but {why}."


def _conforming(limits: Limits, estimate: Estimate, value: float) -> float:
    return probability(limits, replace(estimate, value=value))
