"""Decision rules: does the item conform, given the uncertainty (JCGM 106, ILAC-G8:09/2019)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isinf, isnan, nan
from typing import TYPE_CHECKING

from scipy.special import ndtr, stdtr

from rigrunner.api.results import Decision, Verdict
from rigrunner.signal.uncertainty import coverage_factor

if TYPE_CHECKING:
    from rigrunner.api.data import Estimate

RULES = {
    "simple": "simple acceptance, the value alone decides (w = 0)",
    "guard_band_u": "guard band w = U of 95 %; a value nearer to the limit is conditional",
}


@dataclass(frozen=True)
class Limits:
    """What a value may be, in the unit of the measurand; infinite where there is no limit."""

    lower: float
    upper: float
    source: str
    unit: str = "N·m"

    @classmethod
    def between(cls, lower: float | None, upper: float | None, source: str) -> Limits:
        """Return limits with infinity where a procedure names none."""
        return cls(-inf if lower is None else lower, inf if upper is None else upper, source)

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


def decide(
    limits: Limits, rule: str, compensated: Estimate | None, raw: Estimate | None, problem: str = ""
) -> Decision:
    """Return the verdict on a compensated torque, and what the rule would say of the raw one.

    `problem` says why there is no compensated torque, where there is none.
    """
    verdict, reason = _verdict(limits, rule, compensated, problem)
    return Decision(
        verdict=verdict,
        reason=reason,
        limit_text=str(limits),
        limit_source=limits.source,
        rule=f"{rule}: {RULES[rule]}",
        probability_of_conformity=nan if compensated is None else probability(limits, compensated),
        uncompensated=_verdict(limits, rule, raw, "")[0],
        lower_nm=limits.lower,
        upper_nm=limits.upper,
    )


def probability(limits: Limits, estimate: Estimate) -> float:
    """Return the probability that the true value is within the limits (JCGM 106, 7).

    For a value that is distributed as t (normal, for infinite degrees of freedom) about the
    estimate, scaled by its standard uncertainty.
    """
    if estimate.u == 0:
        return float(limits.margin(estimate.value) >= 0)
    return _cumulative(limits.upper, estimate) - _cumulative(limits.lower, estimate)


def _cumulative(limit: float, estimate: Estimate) -> float:
    if isinf(limit):
        return 1.0 if limit > 0 else 0.0
    z = (limit - estimate.value) / estimate.u
    return float(ndtr(z) if isinf(estimate.dof) else stdtr(estimate.dof, z))


def _verdict(
    limits: Limits, rule: str, estimate: Estimate | None, problem: str
) -> tuple[Verdict, str]:
    if estimate is None:
        return Verdict.INCONCLUSIVE, f"There is no result to decide on: {problem}"
    if not estimate.value > 0:
        value = f"{estimate.value:.4f} {limits.unit}"
        return Verdict.INCONCLUSIVE, f"{value} is no friction torque: friction does not drive."
    guard = 0.0 if rule == "simple" else coverage_factor(estimate.dof) * estimate.u
    if isnan(guard):
        return Verdict.INCONCLUSIVE, "The uncertainty of the result is not known."
    return _compared(limits, estimate.value, guard)


def _compared(limits: Limits, value: float, guard: float) -> tuple[Verdict, str]:
    margin = limits.margin(value)
    place = (
        f"{value:.4f} {limits.unit} is {abs(margin):.4f} {limits.unit} "
        f"{'within' if margin >= 0 else 'outside'} the limit {limits}"
    )
    if guard == 0:
        verdict = Verdict.PASS if margin >= 0 else Verdict.FAIL
        return verdict, f"{place}."
    width = f"U = {guard:.4f} {limits.unit}"
    if margin >= guard:
        return Verdict.PASS, f"{place}, by at least {width}."
    if margin >= 0:
        return Verdict.CONDITIONAL_PASS, f"{place}, but by less than {width}."
    if margin >= -guard:
        return Verdict.CONDITIONAL_FAIL, f"{place}, but by no more than {width}."
    return Verdict.FAIL, f"{place}, by more than {width}."
