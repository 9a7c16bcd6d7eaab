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
    rejections = _rule(subject)(np.append(_normal(1), GROSS))
    is_list = isinstance(rejections, (list, tuple))
    demand(is_list, f"it gave {rejections!r}, expected a list of Rejection")
    invalid = [entry for entry in rejections if not isinstance(entry, Rejection)]
    demand(not invalid, f"it gave {invalid[:1]!r}, expected a list of Rejection")


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
    rejections = _rule(subject)(values)
    demand(not rejections, f"of {what} it rejects {_indices(rejections)}")


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
    rejections = _rule(subject)(values)
    indices = _indices(rejections)
    demand(PLANTED in indices, f"it rejects {indices}, and {PLANTED} is the one")
    for rejection in rejections:
        value, index, rule = rejection.value, rejection.index, rejection.rule
        demand(value == values[index], f"value {value} is not that of {index}")
        demand(rule == subject.name, f"the rule is called '{rule}' in what it rejects")
        is_beyond = rejection.statistic > rejection.critical
        demand(is_beyond, f"statistic {rejection.statistic} is not beyond {rejection.critical}")


@check(fix="correct the rule, or the example that the record states", needs=("gives_rejections",))
def published_rejections_hold(subject: Subject) -> None:
    """The published examples in the record, such as a standard's, are reproduced."""
    examples = subject.record_as(OutlierRuleRecord).examples
    applies(examples, "its record states no examples")
    for example in examples:
        rule: OutlierRule = subject.registry.make(subject.kind, subject.name, example.settings)
        rejected = _indices(rule(np.array(example.values)))
        demand(
            rejected == sorted(example.rejected),
            f"{example.source}: it rejects {rejected}, stated is {sorted(example.rejected)}",
        )


@check(fix="let nothing depend on the order of the values", needs=("gives_rejections",))
def order_of_values_does_not_matter(subject: Subject) -> None:
    """In another order the same values are rejected, with the same statistics."""
    rule = _rule(subject)
    for seed in range(20):
        values = np.random.default_rng(seed).standard_t(2, CYCLES)
        order = np.random.default_rng(seed + 100).permutation(CYCLES)
        statistics, shuffled = _statistics(rule(values)), _statistics(rule(values[order]))
        restored = {int(order[index]): statistic for index, statistic in shuffled.items()}
        _check_same(statistics, restored, "in another order")


@check(fix="use no absolute tolerances", needs=("gives_rejections",))
def shift_and_scale_do_not_matter(subject: Subject) -> None:
    """Shifted, scaled or mirrored, the same values are rejected, with the same statistics."""
    rule = _rule(subject)
    for seed in range(20):
        values = np.random.default_rng(seed).standard_t(2, CYCLES)
        statistics = _statistics(rule(values))
        for shift, scale in ((50.0, 1.0), (0.0, 1e-3), (-3.0, -40.0)):
            transformed = _statistics(rule(shift + scale * values))
            _check_same(statistics, transformed, f"times {scale:g} plus {shift:g}")


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
            rejected = _indices(rule(rng.standard_cauchy(n)))
        except DataError:  # it says that there are too few
            continue
        is_unique = len(set(rejected)) == len(rejected)
        demand(is_unique, f"of {n} values it rejects one twice: {rejected}")
        left = n - len(rejected)
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


def _indices(rejections: Sequence[Rejection]) -> list[int]:
    return sorted(rejection.index for rejection in rejections)


def _statistics(rejections: Sequence[Rejection]) -> dict[int, float]:
    return {rejection.index: rejection.statistic for rejection in rejections}


def _check_same(expected: dict[int, float], actual: dict[int, float], change: str) -> None:
    """Require the same rejections with the same statistics, in any order."""
    is_same = set(expected) == set(actual) and all(
        np.isclose(actual[index], statistic, rtol=1e-6) for index, statistic in expected.items()
    )
    demand(is_same, f"by their statistics it rejects {expected}, and {change} {actual}")


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
