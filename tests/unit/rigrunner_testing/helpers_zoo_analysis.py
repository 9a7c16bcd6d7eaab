"""For each check of the kit, a fit or a rule that fails it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isinf

import numpy as np

from rigrunner.api.analysis import Rejection
from rigrunner.api.errors import DataError
from rigrunner.api.hooks import (
    DecisionRuleRecord,
    FitExample,
    FitRecord,
    NoSettings,
    OutlierExample,
    OutlierRuleRecord,
)
from rigrunner.api.verdict import Verdict, Zone
from rigrunner.registry import load_registry
from rigrunner.signal.coverage import expanded
from unit.rigrunner_testing.helpers_zoo import registry_of

SHIPPED = load_registry()


@dataclass
class Tampered:
    """A curve with some attributes replaced."""

    curve: object
    replaced: dict

    def __getattr__(self, name):
        return self.replaced[name] if name in self.replaced else getattr(self.curve, name)


def line(points, **settings):
    """Return the curve of the shipped polynomial, which passes all checks."""
    return SHIPPED.make("fit", "polynomial", settings)(points)


def with_curve(make):
    """Return a fit whose curve has attributes replaced by `make(curve, points)`."""
    return lambda points: Tampered(line(points), make(line(points), points))


def forgets_units(points):
    return line(replace(points, x_unit="Hz", y_unit="N·m"))


def shrinks_values(points):
    return line(replace(points, y=0.99 * points.y))


def depends_on_order(points):
    return line(replace(points, y=points.y + 1e-3 * np.arange(len(points.y))))


def depends_on_scale(points):
    return line(replace(points, y=points.y + 0.01))


def extrapolates(points):
    return with_curve(lambda curve, _: {"predict": lambda x: curve.predict(np.clip(x, 1, 35))})(
        points
    )


def takes_anything(points):
    return line(replace(points, y=np.nan_to_num(points.y), x=np.nan_to_num(points.x, posinf=5)))


def takes_few(points):
    if len(points.x) < 3:
        raise DataError("too few points")
    return line(points)


def reverses_in_place(points):
    points.x[:], points.y[:] = points.x[::-1].copy(), points.y[::-1].copy()
    return line(points)


FITS = {
    "can_be_made": None,
    "recovers_its_own_curve": shrinks_values,
    "published_examples_hold": line,
    "curve_is_whole": with_curve(lambda curve, _: {"units": [*curve.units, "N·m"]}),
    "units_are_kept": forgets_units,
    "uncertainty_is_the_scatter": with_curve(
        lambda curve, _: {"predict": lambda x: (curve.predict(x)[0], 2 * curve.predict(x)[1])}
    ),
    "order_does_not_matter": depends_on_order,
    "scale_does_not_matter": depends_on_scale,
    "never_extrapolates": extrapolates,
    "too_few_points_refused": takes_few,
    "not_a_number_refused": takes_anything,
    "leaves_the_points_alone": reverses_in_place,
}
"""By check, the fit that fails it."""
WRONG_FIT = FitExample(
    source="a wrong book", x=(1, 2, 3, 4), y=(1, 4, 9, 16), coefficients=(0, 0, 2)
)


def fit_registry(fit, examples=(WRONG_FIT,)):
    record = FitRecord(
        name="fit", help="A fit.", settings=NoSettings, factory=lambda _: fit, examples=examples
    )
    return registry_of("fit", record)


def grubbs(values):
    """Return the rejections of the shipped rule, which passes all checks."""
    rejections = SHIPPED.make("outlier_rule", "grubbs", {})(values)
    return [replace(rejection, rule="rule") for rejection in rejections]


def rejects_the_last(values):
    return [Rejection(len(values) - 1, values[-1], "rule", 9.0, 1.0), *grubbs(values[:-1])]


def rejects_the_high(values):
    return [Rejection(i, v, "rule", v, 2.5) for i, v in enumerate(values) if v > 2.5]


def rejects_nearly_all(values):
    return [
        Rejection(i, v, "rule", 9.0, 1.0) for i, v in enumerate(values) if v != np.median(values)
    ]


RULES = {
    "can_be_made": None,
    "gives_rejections": lambda values: [len(values) - 1],
    "nothing_of_constant_values": rejects_the_last,
    "finds_a_gross_error": lambda _: [],
    "published_rejections_hold": grubbs,
    "order_of_values_does_not_matter": rejects_the_last,
    "shift_and_scale_do_not_matter": rejects_the_high,
    "leaves_as_many_as_it_says": rejects_nearly_all,
    "leaves_the_values_alone": lambda values: values.sort() or [],
}
"""By check, the rule that fails it."""
WRONG_RULE = OutlierExample(source="a wrong book", values=(1, 2, 3, 4, 5, 90), rejected=(0,))


def rule_registry(rule, examples=(WRONG_RULE,)):
    record = OutlierRuleRecord(
        name="rule", help="A rule.", factory=lambda _: rule, examples=examples
    )
    return registry_of("outlier_rule", record)


class DecisionRule:
    """A decision rule with the zones of a function."""

    def __init__(self, zones, words=None):
        self.words = words or {"en": "as agreed"}
        self.zones = zones

    def __call__(self, limits, estimate):
        return self.zones(limits, estimate)


def proven(_, estimate):
    """Return the zones of a rule that passes all checks."""
    guard = expanded(estimate)
    return [Zone(Verdict.PASS, guard, "U"), Zone(Verdict.INCONCLUSIVE, -guard, "U")]


def guarded(guard_band):
    """Return a rule that passes values within a guard band, `guard_band(limits, estimate)`."""
    return DecisionRule(lambda *arguments: [Zone(Verdict.PASS, guard_band(*arguments), "w")])


DECISION_RULES = {
    "can_be_made": None,
    "gives_zones": DecisionRule(lambda *arguments: proven(*arguments)[::-1]),
    "says_what_it_does": DecisionRule(proven, {"de": "wie vereinbart"}),
    "passes_the_good_and_fails_the_bad": DecisionRule(lambda *_: [Zone(Verdict.INCONCLUSIVE, 0.0)]),
    "farther_within_is_no_worse": guarded(lambda _, estimate: 0.0 if estimate.value > 0.9 else 0.3),
    "lower_and_upper_limit_are_alike": guarded(
        lambda limits, estimate: 0.0 if isinf(limits.lower) else expanded(estimate)
    ),
    "the_unit_does_not_matter": guarded(lambda *_: 0.01),
    "passes_nothing_outside_the_limits": guarded(lambda _, estimate: -expanded(estimate)),
    "less_certain_is_no_better": guarded(lambda _, estimate: 0.005 / estimate.u),
    "stated_risks_are_those_of_its_verdicts": guarded(
        lambda _, estimate: expanded(estimate) if estimate.value else 0.0
    ),
}
"""By check, the decision rule that fails it."""


def decision_rule_registry(rule):
    record = DecisionRuleRecord(name="rule", help="A rule.", factory=lambda _: rule)
    return registry_of("decision_rule", record)
