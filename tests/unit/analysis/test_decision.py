from __future__ import annotations

from math import inf, isnan, nan

import pytest

from rigrunner.analysis.decision import Limits, decide, probability
from rigrunner.api.data import Estimate
from rigrunner.api.results import Verdict

UPPER = Limits.between(None, 0.95, "a test")
K = 1.959963984540054  # normal, 95 %
RAW = Estimate(3.0, 0.01)


def verdict(value, rule, *, limits=UPPER, u=0.05, dof=inf):
    return decide(limits, rule, Estimate(value, u, dof), RAW).verdict


@pytest.mark.parametrize(
    ("value", "expected"),
    [(0.5, Verdict.PASS), (0.95, Verdict.PASS), (0.9501, Verdict.FAIL), (2.0, Verdict.FAIL)],
)
def test_simple_acceptance(value, expected):
    assert verdict(value, "simple") is expected


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
def test_guard_band(value, expected):
    assert verdict(value, "guard_band_u") is expected


def test_few_degrees_of_freedom_widen_the_guard_band():
    """t for 95 % and 4 degrees of freedom is 2.776."""
    assert verdict(0.95 - 2.7 * 0.05, "guard_band_u", dof=4) is Verdict.CONDITIONAL_PASS
    assert verdict(0.95 - 2.8 * 0.05, "guard_band_u", dof=4) is Verdict.PASS


def test_two_limits():
    limits = Limits.between(0.2, 0.95, "a test")
    assert verdict(0.19, "simple", limits=limits) is Verdict.FAIL
    assert verdict(0.21, "guard_band_u", limits=limits) is Verdict.CONDITIONAL_PASS
    assert verdict(0.5, "guard_band_u", limits=limits) is Verdict.PASS
    assert str(limits) == "0.2 N·m to 0.95 N·m"


def test_limit_texts():
    assert str(UPPER) == "≤ 0.95 N·m"
    assert str(Limits.between(0.2, None, "a test")) == "≥ 0.2 N·m"


@pytest.mark.parametrize(("guard", "expected"), [(0, 0.5), (0.5, 0.1635), (1, 0.0250)])
def test_risk_at_the_acceptance_limit(guard, expected):
    """ILAC-G8:09/2019: specific risk of an item at the acceptance limit, U = 1.96 u."""
    u = 0.05
    at_limit = Estimate(0.95 - guard * 1.96 * u, u)
    assert 1 - probability(UPPER, at_limit) == pytest.approx(expected, abs=5e-5)


def test_probability_follows_students_t():
    """P(t <= 1) with one degree of freedom (Cauchy) is 3/4."""
    assert probability(UPPER, Estimate(0.9, 0.05, 1)) == pytest.approx(0.75)


def test_probability_between_two_limits():
    limits = Limits.between(0.9, 1.0, "a test")
    assert probability(limits, Estimate(0.95, 0.05)) == pytest.approx(0.682689492, abs=1e-9)


def test_no_uncertainty_is_certainty():
    assert probability(UPPER, Estimate(0.9, 0.0)) == 1
    assert probability(UPPER, Estimate(0.96, 0.0)) == 0


@pytest.mark.parametrize("value", [0.0, -0.1, nan])
@pytest.mark.parametrize("rule", ["simple", "guard_band_u"])
def test_a_torque_that_is_not_positive_decides_nothing(value, rule):
    decision = decide(UPPER, rule, Estimate(value, 0.05), RAW)
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert "no friction torque" in decision.reason


def test_no_result_is_inconclusive_and_says_why():
    decision = decide(UPPER, "simple", None, RAW, "the primary failed")
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert "the primary failed" in decision.reason
    assert isnan(decision.probability_of_conformity)


def test_the_raw_torque_is_judged_by_the_same_rule():
    decision = decide(UPPER, "simple", Estimate(0.5, 0.05), RAW)
    assert (decision.verdict, decision.uncompensated) == (Verdict.PASS, Verdict.FAIL)
    assert decide(UPPER, "simple", Estimate(0.5, 0.05), None).uncompensated is Verdict.INCONCLUSIVE


def test_the_reason_is_one_sentence_with_the_numbers():
    reason = decide(UPPER, "guard_band_u", Estimate(0.72, 0.05), RAW).reason
    assert (
        reason
        == "0.7200 N·m is 0.2300 N·m within the limit ≤ 0.95 N·m, by at least U = 0.0980 N·m."
    )
