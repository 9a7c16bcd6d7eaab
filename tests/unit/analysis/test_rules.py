from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, isnan, nextafter
from typing import TYPE_CHECKING

import pytest

from rigrunner.analysis.verdict.rule import AppliedRule
from rigrunner.api.data import Estimate
from rigrunner.api.verdict import Limits, Verdict, Zone, risk_text
from rigrunner.procedure import Acceptance
from rigrunner.registry import load_registry
from rigrunner.signal.coverage import expanded

if TYPE_CHECKING:
    from collections.abc import Mapping

REGISTRY = load_registry()
UPPER = Limits.between(None, 0.95)
BAND = Limits.between(0.2, 0.95)
K = 1.959963984540054  # normal, 95 %
LIMIT = {
    "of": "torque",
    "mean": True,
    "max": "0.95 N·m",
    "source": "a test",
    "measurand": {"nature": "load_induced", "condition": "at_reversal"},
}
NAMES = ("simple", "guard_band_u", "guard_band_fraction", "non_binary")


def rule(name, **changes):
    if name == "guard_band_fraction":
        changes.setdefault("fraction", 0.5)
    acceptance = Acceptance.model_validate({"limits": [LIMIT], "rule": name, **changes})
    return AppliedRule.of(acceptance, REGISTRY)


def verdict(value, name, *, limits=UPPER, u=0.05, dof=inf):
    return rule(name).verdict(limits, Estimate(value, u, dof))[0]


@pytest.mark.parametrize(
    ("value", "expected"),
    [(0.5, Verdict.PASS), (0.95, Verdict.PASS), (0.9501, Verdict.FAIL), (2.0, Verdict.FAIL)],
)
def test_simple_acceptance(value, expected):
    assert verdict(value, "simple") is expected


@pytest.mark.parametrize(("name", "share"), [("guard_band_u", 1.0), ("guard_band_fraction", 0.5)])
def test_binary_guard_band_rule_passes_or_fails(name, share):
    edge = 0.95 - share * K * 0.05
    assert verdict(edge - 1e-6, name) is Verdict.PASS
    assert verdict(edge + 1e-6, name) is Verdict.FAIL
    assert verdict(0.97, name) is Verdict.FAIL


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0.95 - K * 0.05 - 1e-6, Verdict.PASS),
        (0.95 - K * 0.05 + 1e-6, Verdict.CONDITIONAL_PASS),
        (0.95, Verdict.CONDITIONAL_PASS),
        (0.95 + 1e-6, Verdict.CONDITIONAL_FAIL),
        (0.95 + K * 0.05 - 1e-6, Verdict.CONDITIONAL_FAIL),
        (0.95 + K * 0.05 + 1e-6, Verdict.FAIL),
    ],
)
def test_non_binary_rule_has_conditional_verdicts(value, expected):
    assert verdict(value, "non_binary") is expected


FROM_ZERO = Limits.between(0.0, None)
"""The margin of a value is the value itself, so that it can be exactly on an edge."""


@pytest.mark.parametrize(
    ("name", "edge", "at_it", "beyond"),
    [
        ("simple", 0.0, Verdict.PASS, Verdict.FAIL),
        ("guard_band_u", 1.0, Verdict.PASS, Verdict.FAIL),
        ("guard_band_fraction", 0.5, Verdict.PASS, Verdict.FAIL),
        ("non_binary", 1.0, Verdict.PASS, Verdict.CONDITIONAL_PASS),
        ("non_binary", 0.0, Verdict.CONDITIONAL_PASS, Verdict.CONDITIONAL_FAIL),
        ("non_binary", -1.0, Verdict.CONDITIONAL_FAIL, Verdict.FAIL),
    ],
)
def test_value_exactly_at_an_edge_gets_the_better_verdict(name, edge, at_it, beyond):
    """Tolerance and acceptance limits belong to their intervals (JCGM 106, 3.3.5 and 3.3.9, notes).

    The guard band outside the tolerance limit includes its end too (ILAC-G8:09/2019, 4.2.3: TL to
    TL + w).
    """
    value = edge * expanded(Estimate(0.0, 0.05))
    assert verdict(value, name, limits=FROM_ZERO) is at_it
    below = nextafter(value, -inf) if edge else -1e-8 * 0.05
    assert verdict(below, name, limits=FROM_ZERO) is beyond


def test_rounding_error_of_units_does_not_fail_a_value_on_its_limit():
    """25.05 °C is computed in K, and converted back to 25.05000000000001 °C."""
    celsius = 25.05 + 273.15 - 273.15
    assert celsius > 25.05
    limits = Limits.between(None, 25.05, "°C")
    result, reason = rule("simple").verdict(limits, Estimate(celsius, 0.02, unit="°C"))
    assert (result, reason) == (Verdict.PASS, "Margin to the limit ≤ 25.05 °C: 0.000 °C.")
    assert verdict(25.05 + 1e-6, "simple", limits=limits) is Verdict.FAIL


@pytest.mark.parametrize("name", ["guard_band_u", "guard_band_fraction", "non_binary"])
def test_limits_two_guard_bands_apart_allow_one_passing_value(name):
    guarded = rule(name)
    guard = guarded.guard(UPPER, Estimate(1.0, 0.05))
    middle, limits = Estimate(guard, 0.05), Limits.between(0.0, 2 * guard)
    assert guarded.verdict(limits, middle)[0] is Verdict.PASS
    assert not isnan(guarded.false_accept_risk(limits, middle))
    narrower = Limits.between(0.0, nextafter(2 * guard, 0.0))
    worse = Verdict.CONDITIONAL_PASS if name == "non_binary" else Verdict.INCONCLUSIVE
    assert guarded.verdict(narrower, middle)[0] is worse
    assert isnan(guarded.false_accept_risk(narrower, middle))


def test_few_degrees_of_freedom_widen_the_guard_band():
    """t for 95 % and 4 degrees of freedom is 2.776."""
    assert verdict(0.95 - 2.7 * 0.05, "guard_band_u", dof=4) is Verdict.FAIL
    assert verdict(0.95 - 2.8 * 0.05, "guard_band_u", dof=4) is Verdict.PASS


def test_rules_with_two_limits():
    assert verdict(0.19, "simple", limits=BAND) is Verdict.FAIL
    assert verdict(0.21, "non_binary", limits=BAND) is Verdict.CONDITIONAL_PASS
    assert verdict(0.21, "guard_band_u", limits=BAND) is Verdict.FAIL
    assert verdict(0.5, "guard_band_u", limits=BAND) is Verdict.PASS


def test_lower_limit_has_its_guard_band_above():
    lower = Limits.between(0.3, None)
    assert verdict(0.41, "guard_band_u", limits=lower) is Verdict.PASS
    assert verdict(0.39, "guard_band_u", limits=lower) is Verdict.FAIL


def test_binary_rule_is_inconclusive_if_no_value_can_pass():
    narrow, wide = Limits.between(0.4, 0.6), Estimate(0.5, 0.06)
    result, reason = rule("guard_band_u").verdict(narrow, wide)
    assert result is Verdict.INCONCLUSIVE
    assert reason.endswith("; the limits are too close for U = 0.1176 N·m, so no result can pass.")
    assert rule("guard_band_u").verdict(narrow, Estimate(0.61, 0.06))[0] is Verdict.FAIL
    assert rule("non_binary").verdict(narrow, wide)[0] is Verdict.CONDITIONAL_PASS
    assert isnan(rule("guard_band_u").false_accept_risk(narrow, wide))
    at_a_limit, too_near = Estimate(0.0, 0.05), Limits.between(0.0, 0.1)
    assert rule("guard_band_u").verdict(too_near, at_a_limit)[0] is Verdict.INCONCLUSIVE
    # at a limit, as all values outside fail: P(0 < Z < 0.2/0.06)
    risk = rule("guard_band_u").false_reject_risk(narrow, wide)
    assert risk == pytest.approx(0.499571, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "accept", "reject"),
    [
        ("simple", 0.5, 0.5),
        ("guard_band_fraction", 0.1635, 0.8365),
        ("guard_band_u", 0.0250, 0.9750),
        ("non_binary", 0.0250, 0.0250),
    ],
)
def test_stated_risk_is_that_at_the_acceptance_limit(name, accept, reject):
    """ILAC-G8:09/2019, table 1 and JCGM 106, 8.3.2: P(Z > 1.96 w/U) for w = 0, U/2, U."""
    applied, estimate = rule(name), Estimate(0.7, 0.05)
    assert applied.false_accept_risk(UPPER, estimate) == pytest.approx(accept, abs=5e-5)
    assert applied.false_reject_risk(UPPER, estimate) == pytest.approx(reject, abs=5e-5)


def test_stated_risk_is_independent_of_the_value():
    applied = rule("guard_band_fraction", fraction=0.83)
    risks = [applied.false_accept_risk(UPPER, Estimate(value, 0.05)) for value in (0.1, 0.9, 3.0)]
    assert risks == [risks[0]] * 3


def test_simple_acceptance_risk_exceeds_half_for_close_limits():
    """At one limit P(outside) = 1/2 + P(Z < -2) for limits 2 u apart."""
    risk = rule("simple").false_accept_risk(Limits.between(0.4, 0.5), Estimate(0.45, 0.05))
    assert risk == pytest.approx(0.5 + 0.022750131948179, abs=1e-9)


@pytest.mark.parametrize(
    ("value", "name", "words"),
    [
        (0.72, "simple", "Margin to the limit ≤ 0.95 N·m: 0.2300 N·m."),
        (0.72, "guard_band_u", "Margin to the limit ≤ 0.95 N·m: 0.2300 N·m (U = 0.0980 N·m)."),
        (0.72, "guard_band_fraction", ": 0.2300 N·m (w = 0.5 U = 0.0490 N·m)."),
        (
            0.9,
            "guard_band_u",
            "0.0500 N·m, less than U = 0.0980 N·m; conformity is not demonstrated.",
        ),
        (0.96, "guard_band_u", "Outside the limit ≤ 0.95 N·m by 0.0100 N·m."),
        (0.9, "non_binary", "≤ 0.95 N·m: 0.0500 N·m, less than U = 0.0980 N·m."),
        (
            0.96,
            "non_binary",
            "≤ 0.95 N·m by 0.0100 N·m, no more than U = 0.0980 N·m.",
        ),
        (1.2, "non_binary", "≤ 0.95 N·m by 0.2500 N·m, more than U = 0.0980 N·m."),
    ],
)
def test_reason_is_one_sentence_with_the_numbers(value, name, words):
    _, reason = rule(name).verdict(UPPER, Estimate(value, 0.05))
    assert reason.endswith(words)
    assert reason.count(". ") == 0


@pytest.mark.parametrize(
    ("value", "u", "words"),
    [
        (0.57840353, 0.004311, "Margin to the limit ≤ 0.65 A/W: 0.0716 A/W (U = 0.0084 A/W)."),
        (0.57840353, 4.311e-6, ": 0.0715965 A/W (U = 0.0000084 A/W)."),
        (-120.0, 40.0, ": 121 A/W (U = 78 A/W)."),
        (-1200.0, 400.0, ": 1200 A/W (U = 780 A/W)."),
    ],
)
def test_reason_shows_two_digits_of_the_uncertainty(value, u, words):
    limits = Limits.between(None, 0.65, "A/W")
    _, reason = rule("guard_band_u").verdict(limits, Estimate(value, u, unit="A/W"))
    assert reason.endswith(words)


@pytest.mark.parametrize(
    ("value", "u", "words"),
    [
        (0.9, 0.01, "Margin to the limit ≤ 0.95 N·m: 0.0500 N·m (U = 0.0196 N·m)."),
        (0.9499, 1e-5, "Margin to the limit ≤ 0.95 N·m: 0.00010 N·m (U = 0.00002 N·m)."),
        (0.949999, 2e-7, "Margin to the limit ≤ 0.95 N·m: 0.0000010 N·m (U = 0.0000004 N·m)."),
    ],
)
def test_small_margin_is_not_shown_as_zero(value, u, words):
    _, reason = rule("guard_band_u").verdict(UPPER, Estimate(value, u))
    assert reason == words


@pytest.mark.parametrize(
    ("margin", "unit", "words"),
    [
        # U = 1.96 * 0.05 = 0.0979982
        (0.0978, "V", "0.0978 V, less than U = 0.0980 V; conformity is not demonstrated."),
        (0.097998, "V", "0.0979980 V, less than U = 0.0979982 V; conformity is not demonstrated."),
        (0.097998, "N·m", "0.0979980 N·m, less than U = 0.0979982 N·m; conformity is not demon"),
        (0.0980001, "V", "0.098000 V (U = 0.097998 V)."),
    ],
)
def test_reason_distinguishes_margin_and_guard_band(margin, unit, words):
    limits = Limits.between(0.0, None, unit)
    _, reason = rule("guard_band_u").verdict(limits, Estimate(margin, 0.05, unit=unit))
    assert words in reason


@pytest.mark.parametrize(
    ("risk", "text"),
    [(0.0, "0.01 %"), (4e-5, "0.01 %"), (0.025, "2.50 %"), (0.5, "50.00 %"), (0.99996, "100.00 %")],
)
def test_maximum_risk_is_rounded_to_an_upper_bound(risk, text):
    """For limits much closer than u, the text would be "at most > 99.99 %"."""
    assert risk_text(risk) == text


def test_small_excess_is_not_shown_as_zero():
    limits = Limits.between(None, 1.0, "V")
    _, reason = rule("simple").verdict(limits, Estimate(1.0000004, 0.05, unit="V"))
    assert reason == "Outside the limit ≤ 1 V by 0.0000004 V."


def test_dimensionless_margin_is_shown_without_unit():
    limits = Limits.between(None, 0.5, "1")
    _, reason = rule("guard_band_u").verdict(limits, Estimate(0.45, 0.01, unit="1"))
    assert reason == "Margin to the limit ≤ 0.5: 0.050 (U = 0.020)."


@pytest.mark.parametrize(
    ("value", "name", "marginal"),
    [
        (0.9399, "simple", False),
        (0.9401, "simple", True),
        (0.9599, "simple", True),
        (0.9401, "guard_band_u", False),
        (0.95 - K * 0.05, "guard_band_u", True),
        (0.9401, "non_binary", True),
        (0.95 + K * 0.05, "non_binary", True),
        (0.90, "non_binary", False),
    ],
)
def test_marginal_band_surrounds_the_edges_of_a_rule(value, name, marginal):
    assert rule(name, marginal="0.01 N·m").is_marginal(UPPER, Estimate(value, 0.05)) is marginal


def test_marginal_band_of_a_level_is_in_decibels():
    limits = Limits(-inf, 10.0, "dBm")
    for value, marginal in ((9.95, True), (9.5, False)):
        estimate = Estimate(value, 0.05, unit="dBm")
        assert rule("simple", marginal="0.1 dB").is_marginal(limits, estimate) is marginal


def test_nothing_is_marginal_without_a_marginal_band():
    assert not rule("simple").is_marginal(UPPER, Estimate(0.95, 0.05))


@pytest.mark.parametrize("name", NAMES)
def test_rule_text_has_its_name_and_guard_band(name):
    text = str(rule(name))
    assert text.startswith(f"{name}: ")
    assert "w = " in text


@dataclass(frozen=True)
class Agreed:
    """A decision rule of a lab."""

    zones: tuple[Zone, ...]
    words: Mapping[str, str] = field(default_factory=lambda: {"en": "as agreed", "de": "so"})

    def __call__(self, *_):
        return self.zones


RELAXED = Agreed((Zone(Verdict.PASS, -0.02, "w"), Zone(Verdict.CONDITIONAL_FAIL, -0.05, "v")))
PROVEN = Agreed((Zone(Verdict.PASS, 0.1, "w"), Zone(Verdict.CONDITIONAL_PASS, 0.04, "v")))
NEVER = Agreed((Zone(Verdict.INCONCLUSIVE, 0.0),))


@pytest.mark.parametrize(
    ("zones", "value", "expected", "why"),
    [
        (RELAXED, 0.9, Verdict.PASS, "Margin to the limit ≤ 0.95 N·m: 0.0500 N·m."),
        (RELAXED, 0.96, Verdict.PASS, "by 0.0100 N·m, no more than w = 0.0200 N·m."),
        (RELAXED, 0.98, Verdict.CONDITIONAL_FAIL, "by 0.0300 N·m, no more than v = 0.0500 N·m."),
        (RELAXED, 1.01, Verdict.FAIL, "by 0.0600 N·m, more than v = 0.0500 N·m."),
        (PROVEN, 0.84, Verdict.PASS, "0.1100 N·m (w = 0.1000 N·m)."),
        (PROVEN, 0.9, Verdict.CONDITIONAL_PASS, "0.0500 N·m, less than w = 0.1000 N·m."),
        (PROVEN, 0.92, Verdict.FAIL, "less than v = 0.0400 N·m; conformity is not demonstrated."),
        (PROVEN, 0.96, Verdict.FAIL, "Outside the limit ≤ 0.95 N·m by 0.0100 N·m."),
    ],
)  # fmt: skip
def test_custom_rule_needs_only_zones(zones, value, expected, why):
    result, reason = AppliedRule("own", zones).verdict(UPPER, Estimate(value, 0.05))
    assert (result, reason.endswith(why)) == (expected, True), reason


def test_risks_of_a_custom_rule_are_those_at_its_zone_edges():
    """By the normal distribution: P(Z > -0.4) at -0.02/0.05, P(Z < -1) at -0.05/0.05, etc."""
    estimate = Estimate(0.5, 0.05)
    relaxed, proven = AppliedRule("own", RELAXED), AppliedRule("own", PROVEN)
    assert relaxed.false_accept_risk(UPPER, estimate) == pytest.approx(0.655422, abs=1e-6)
    assert relaxed.false_reject_risk(UPPER, estimate) == pytest.approx(0.158655, abs=1e-6)
    assert proven.false_accept_risk(UPPER, estimate) == pytest.approx(0.022750, abs=1e-6)
    assert proven.false_reject_risk(UPPER, estimate) == pytest.approx(0.788145, abs=1e-6)
    assert str(relaxed) == "own: as agreed"
    assert not relaxed.is_marginal(UPPER, Estimate(0.97, 0.05)), "no marginal band is set"
    assert relaxed.in_other_languages == {"de": "so"}


def test_rule_that_never_passes_has_no_guard_band_and_no_risk():
    never, estimate = AppliedRule("own", NEVER), Estimate(0.5, 0.05)
    assert isnan(never.guard(UPPER, estimate))
    assert isnan(never.false_accept_risk(UPPER, estimate))
    assert never.verdict(UPPER, estimate)[0] is Verdict.INCONCLUSIVE


def test_texts_of_the_shipped_rules_are_unchanged():
    """As in results and certificates of version 0.1.0."""
    assert str(rule("simple")) == "simple: simple acceptance, the value alone decides (w = 0)"
    assert str(rule("guard_band_u")) == (
        "guard_band_u: guard band w = U of 95 %; what is not within the limit by w fails"
    )
    assert str(rule("guard_band_fraction", fraction=1)) == (
        "guard_band_fraction: guard band w = 1 U of 95 %; what is not within the limit by w fails"
    )
    assert str(rule("non_binary")) == (
        "non_binary: guard band w = U of 95 %; what is nearer to the limit than w is conditional"
    )
