"""Checks on decision rules."""

from __future__ import annotations

from math import inf, isinf, isnan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.analysis.verdict.rule import ROUNDING, AppliedRule
from rigrunner.api.data import Estimate
from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import DecisionRuleRecord
from rigrunner.api.verdict import WORST_FIRST, Limits, Verdict
from rigrunner_testing.check import AnyCheck, Nonconformity, check, demand

if TYPE_CHECKING:
    from rigrunner.api.data import Array
    from rigrunner_testing.subjects import Subject

U = 0.05
"""Standard uncertainty of each value, in the unit of the limits."""
FEW = 4.0
"""Degrees of freedom of a result from few cycles."""
LIMITS = (Limits(-inf, 1.0), Limits(-1.0, inf), Limits(-1.0, 1.0))
NARROW = Limits(-0.04, 0.04)
"""Limits that are closer together than the uncertainty is wide."""
FAR = 40 * U
"""How far outside a limit the values begin: beyond any margin, also with FEW degrees of freedom."""
STEP = U / 10
FINE = U / 50
"""The step between values of which risks are counted: they differ by 0.008 at most."""
DRAWS = 200_000
"""The standard deviation of a counted risk is 0.0011 at most."""
CLOSE = 0.02
"""Tolerance of a stated risk, for the number of draws and the steps between values."""


@check(fix="give a list of Zone of rigrunner.api.verdict, the best verdict first")
def gives_zones(subject: Subject) -> None:
    """It gives zones with falling margins and increasingly worse verdicts, none of them `fail`."""
    for limits in (*LIMITS, NARROW):
        for dof in (inf, FEW):
            try:
                _rule(subject).zones(limits, Estimate(0.0, U, dof))
            except PluginError as error:
                raise Nonconformity(error.message) from error


@check(fix="give `words` a sentence in English: {'en': '...'}, and others that you know")
def says_what_it_does(subject: Subject) -> None:
    """It describes itself in one sentence, in English at least."""
    try:
        words = _rule(subject).zones.words
    except PluginError as error:
        raise Nonconformity(error.message) from error
    strange = [text for text in words.values() if "\n" in text or text.strip() != text]
    demand(not strange, f"its words are {strange[:1]}, expected one line without blanks around it")


@check(
    fix="pass what is far within the limits, and give zones that end: what is in none fails",
    needs=("gives_zones",),
)
def passes_the_good_and_fails_the_bad(subject: Subject) -> None:
    """A value far within its limits passes, and one far outside fails."""
    for limits in LIMITS:
        good, bad = _values(limits)[[-1, 0]]
        for value, expected in ((good, Verdict.PASS), (bad, Verdict.FAIL)):
            verdict, _ = _rule(subject).verdict(limits, Estimate(value, U))
            demand(
                verdict is expected,
                f"{value:g} with u = {U:g} and {limits} gets '{verdict}', not '{expected}'",
            )


@check(
    fix="let the zones depend on the uncertainty, not on `estimate.value`",
    needs=("gives_zones",),
)
def farther_within_is_no_worse(subject: Subject) -> None:
    """A value further within its limits never gets a worse verdict."""
    rule = _rule(subject)
    for limits in (*LIMITS, NARROW):
        last = 0
        for value in _values(limits):
            verdict, _ = rule.verdict(limits, Estimate(value, U))
            rank = WORST_FIRST.index(verdict)
            demand(
                rank >= last,
                f"{value:g} gets '{verdict}' with {limits}, and '{WORST_FIRST[last]}' farther out",
            )
            last = rank


@check(fix="treat lower and upper limit in the same way", needs=("gives_zones",))
def lower_and_upper_limit_are_alike(subject: Subject) -> None:
    """Mirrored, value and limits get the same verdict."""
    rule = _rule(subject)
    for limits in (*LIMITS, NARROW):
        mirror = Limits(-limits.upper, -limits.lower)
        for value in _values(limits):
            verdict, _ = rule.verdict(limits, Estimate(value, U))
            other, _ = rule.verdict(mirror, Estimate(-value, U))
            demand(
                verdict is other,
                f"{value:g} with {limits} gets '{verdict}', and {-value:g} with {mirror} '{other}'",
            )


@check(fix="take no absolute distances: a unit of the limits may be any", needs=("gives_zones",))
def the_unit_does_not_matter(subject: Subject) -> None:
    """In another unit, value, uncertainty and limits give the same verdict."""
    rule = _rule(subject)
    for limits in LIMITS:
        milli = Limits(1000 * limits.lower, 1000 * limits.upper, "mN·m")
        for value in _values(limits) + STEP / 3:  # beside the edges: of these, rounding decides
            verdict, _ = rule.verdict(limits, Estimate(value, U))
            other, _ = rule.verdict(milli, Estimate(1000 * value, 1000 * U, unit="mN·m"))
            demand(verdict is other, f"{value:g} N·m gets '{verdict}', in mN·m '{other}'")


@check(
    fix="give the verdict `pass` no negative margin, or say `passes_outside=True` in the record",
    needs=("gives_zones",),
)
def passes_nothing_outside_the_limits(subject: Subject) -> None:
    """Nothing outside its limits passes, unless the record allows it."""
    if subject.record_as(DecisionRuleRecord).passes_outside:
        return
    rule = _rule(subject)
    for limits in (*LIMITS, NARROW):
        for value in _values(limits):
            verdict, _ = rule.verdict(limits, Estimate(value, U))
            outside = limits.margin(value) < -ROUNDING * U
            demand(not (outside and verdict is Verdict.PASS), f"{value:g} passes {limits}")


@check(fix="let no margin within the limits fall with the uncertainty", needs=("gives_zones",))
def less_certain_is_no_better(subject: Subject) -> None:
    """For the same value within its limits, a greater uncertainty never gives a better verdict."""
    rule = _rule(subject)
    for limits in LIMITS:
        for value in _values(limits):
            if limits.margin(value) < 0:
                continue
            verdict, _ = rule.verdict(limits, Estimate(value, U))
            doubtful, _ = rule.verdict(limits, Estimate(value, 2 * U))
            is_better = WORST_FIRST.index(doubtful) > WORST_FIRST.index(verdict)
            demand(
                not is_better,
                f"{value:g} with {limits}: '{verdict}', and '{doubtful}' with twice the u",
            )


@check(
    fix="let the zones depend on nothing but limits and uncertainty: the risks are those of them",
    needs=("farther_within_is_no_worse", "passes_the_good_and_fails_the_bad"),
)
def stated_risks_are_those_of_its_verdicts(subject: Subject) -> None:
    """Over random true values, the counted risks of wrong verdicts are the stated ones."""
    rule = _rule(subject)
    for dof in (inf, FEW):
        rng = np.random.default_rng(1)
        draws = rng.standard_normal(DRAWS) if isinf(dof) else rng.standard_t(dof, DRAWS)
        errors = np.sort(U * draws)
        for limits in (*LIMITS, NARROW):
            passed: list[float] = []
            failed: list[float] = []
            for value in _values(limits, FINE):
                verdict, _ = rule.verdict(limits, Estimate(value, U, dof))
                if verdict in {Verdict.PASS, Verdict.FAIL}:
                    # The share of the errors with which the true value is within the limits.
                    ends = np.searchsorted(errors, [limits.lower - value, limits.upper - value])
                    conforming = float(ends[1] - ends[0]) / DRAWS
                    (passed if verdict is Verdict.PASS else failed).append(conforming)
            counted = 1 - min(passed) if passed else None
            estimate = Estimate(0.0, U, dof)
            _check_risk("pass", counted, rule.false_accept_risk(limits, estimate), limits)
            _check_risk("fail", max(failed), rule.false_reject_risk(limits, estimate), limits)


def _check_risk(what: str, counted: float | None, stated: float, limits: Limits) -> None:
    if counted is None:
        demand(isnan(stated), f"nothing can pass {limits}, and the stated risk is {stated:.3f}")
        return
    demand(
        abs(stated - counted) <= CLOSE,
        f"of a false {what} with {limits} the stated risk is {stated:.3f}, counted {counted:.3f}",
    )


def _rule(subject: Subject) -> AppliedRule:
    """Return the rule as the analysis applies it."""
    rule = Scrutiny(subject.registry).make(subject.kind, subject.name, subject.settings)
    return AppliedRule(subject.name, rule)


def _values(limits: Limits, step: float = STEP) -> Array:
    """Return values (n,) from far outside to the middle, or as far within; exact at the edges."""
    if isinf(limits.lower):
        return limits.upper + np.arange(FAR, -FAR, -step)
    if isinf(limits.upper):
        return limits.lower + np.arange(-FAR, FAR, step)
    return limits.lower + np.arange(-FAR, (limits.upper - limits.lower) / 2, step)


CHECKS: tuple[AnyCheck, ...] = (
    gives_zones,
    says_what_it_does,
    passes_the_good_and_fails_the_bad,
    farther_within_is_no_worse,
    lower_and_upper_limit_are_alike,
    the_unit_does_not_matter,
    passes_nothing_outside_the_limits,
    less_certain_is_no_better,
    stated_risks_are_those_of_its_verdicts,
)
