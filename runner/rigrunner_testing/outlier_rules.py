"""Checks on rules for gross errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import Rejection
from rigrunner.api.errors import DataError
from rigrunner.api.hooks import OutlierRuleRecord
from rigrunner_testing.check import AnyCheck, applies, check, demand

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.analysis import OutlierRule
    from rigrunner.api.data import Array
    from rigrunner_testing.subjects import Subject

CYCLES = 30
PLANTED, GROSS = 20, 7.0
"""The place of the gross error, and its value: 100 standard deviations off."""
SAMPLES = 200
"""The number of random samples, each of fewer than CYCLES values."""


@check(fix="return a list of Rejection of rigrunner.api.analysis, an empty one for no gross error")
def gives_rejections(subject: Subject) -> None:
    """It gives a list of rejections, each a Rejection."""
    found = _rule(subject)(np.append(_normal(1), GROSS))
    demand(isinstance(found, (list, tuple)), f"it gave {found!r}, expected a list of Rejection")
    strange = [each for each in found if not isinstance(each, Rejection)]
    demand(not strange, f"it gave {strange[:1]!r}, expected a list of Rejection")


@check(
    fix="reject nothing where the scatter is zero, or of the size of rounding",
    needs=("gives_rejections",),
)
def nothing_of_constant_values(subject: Subject) -> None:
    """Of values that are equal but for rounding, it rejects none."""
    for constant in (0.0, 2.0, 0.1, -1e9):
        values = np.full(CYCLES, constant)
        _keeps(subject, values, f"{CYCLES} times {constant:g}")
        if constant:
            values[3], values[7] = np.nextafter(constant, np.inf), np.nextafter(constant, -np.inf)
            _keeps(subject, values, f"{CYCLES} times {constant:g}, one rounded up and one down")


def _keeps(subject: Subject, values: Array, what: str) -> None:
    found = _rule(subject)(values)
    demand(not found, f"of {what} it rejects {_indices(found)}")


@check(
    fix="scale the statistic by the scatter of the other values, and compare it with a limit",
    needs=("gives_rejections",),
)
def finds_a_gross_error(subject: Subject) -> None:
    """It finds one gross error, 100 standard deviations away, and gives its statistics."""
    record = subject.record_as(OutlierRuleRecord)
    applies(record.rejects, "its record says that it rejects nothing")
    values = _normal(1)
    values[PLANTED] = GROSS
    found = _rule(subject)(values)
    demand(PLANTED in _indices(found), f"it rejects {_indices(found)}, and {PLANTED} is the one")
    for each in found:
        demand(each.value == values[each.index], f"value {each.value} is not that of {each.index}")
        demand(each.rule == subject.name, f"the rule is called '{each.rule}' in what it rejects")
        beyond = each.statistic > each.critical
        demand(beyond, f"statistic {each.statistic} is not beyond {each.critical}")


@check(fix="correct the rule, or the example that the record states", needs=("gives_rejections",))
def published_rejections_hold(subject: Subject) -> None:
    """The published examples in the record, such as a standard's, are reproduced."""
    examples = subject.record_as(OutlierRuleRecord).examples
    applies(examples, "its record states no examples")
    for example in examples:
        rule: OutlierRule = subject.registry.make(subject.kind, subject.name, example.settings)
        found = _indices(rule(np.array(example.values)))
        demand(
            found == sorted(example.rejected),
            f"{example.source}: it rejects {found}, stated is {sorted(example.rejected)}",
        )


@check(fix="let nothing depend on the order of the values", needs=("gives_rejections",))
def order_of_values_does_not_matter(subject: Subject) -> None:
    """In another order the same values are rejected, with the same statistics."""
    rule = _rule(subject)
    for seed in range(20):
        values = np.random.default_rng(seed).standard_t(2, CYCLES)
        order = np.random.default_rng(seed + 100).permutation(CYCLES)
        found, moved = _statistics(rule(values)), _statistics(rule(values[order]))
        again = {int(order[index]): statistic for index, statistic in moved.items()}
        _same(found, again, "in another order")


@check(fix="use no absolute tolerances", needs=("gives_rejections",))
def shift_and_scale_do_not_matter(subject: Subject) -> None:
    """Shifted, scaled or mirrored, the same values are rejected, with the same statistics."""
    rule = _rule(subject)
    for seed in range(20):
        values = np.random.default_rng(seed).standard_t(2, CYCLES)
        found = _statistics(rule(values))
        for shift, scale in ((50.0, 1.0), (0.0, 1e-3), (-3.0, -40.0)):
            again = _statistics(rule(shift + scale * values))
            _same(found, again, f"times {scale:g} plus {shift:g}")


@check(
    fix="stop rejecting in time, or state `leaves_at_least` of the record as it is",
    needs=("gives_rejections",),
)
def leaves_as_many_as_it_says(subject: Subject) -> None:
    """It never leaves fewer values than its record states, nor names one twice."""
    least = subject.record_as(OutlierRuleRecord).leaves_at_least
    rule = _rule(subject)
    for seed in range(SAMPLES):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(0, CYCLES))
        try:
            found = _indices(rule(rng.standard_cauchy(n)))
        except DataError:  # it says that there are too few
            continue
        demand(len(set(found)) == len(found), f"of {n} values it rejects one twice: {found}")
        left = n - len(found)
        demand(
            left >= min(n, least),
            f"of {n} values it leaves {left}, and its record says at least {least}",
        )


@check(fix="copy what you change", needs=("gives_rejections",))
def leaves_the_values_alone(subject: Subject) -> None:
    """It does not change the values."""
    values = np.append(_normal(1), GROSS)
    before = values.copy()
    _rule(subject)(values)
    demand(np.array_equal(values, before), "it changes the values that it is given")


def _rule(subject: Subject) -> OutlierRule:
    rule: OutlierRule = subject.make()
    return rule


def _indices(found: Sequence[Rejection]) -> list[int]:
    return sorted(each.index for each in found)


def _statistics(found: Sequence[Rejection]) -> dict[int, float]:
    return {each.index: each.statistic for each in found}


def _same(found: dict[int, float], again: dict[int, float], how: str) -> None:
    """Require the same rejections with the same statistics, in any order."""
    same = set(found) == set(again) and all(
        np.isclose(again[index], statistic, rtol=1e-6) for index, statistic in found.items()
    )
    demand(same, f"by their statistics it rejects {found}, and {how} {again}")


def _normal(seed: int) -> Array:
    return np.random.default_rng(seed).normal(2.0, 0.05, CYCLES)


CHECKS: tuple[AnyCheck, ...] = (
    gives_rejections,
    nothing_of_constant_values,
    finds_a_gross_error,
    published_rejections_hold,
    order_of_values_does_not_matter,
    shift_and_scale_do_not_matter,
    leaves_as_many_as_it_says,
    leaves_the_values_alone,
)
