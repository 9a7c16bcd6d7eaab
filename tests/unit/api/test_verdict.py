"""The verdict of several limits, and the text of a probability."""

from __future__ import annotations

from math import inf, nan

import pytest

from rigrunner.api.data import Estimate
from rigrunner.api.verdict import (
    CERTAIN,
    Decision,
    LimitDecision,
    Limits,
    Verdict,
    probability_text,
)


def part(of, verdict, probability=0.5, raw=Verdict.PASS, value=0.9):
    return LimitDecision(
        of=of,
        verdict=verdict,
        reason=f"It is {of}.",
        limits=Limits(-inf, 1.0),
        source="a drawing",
        result=Estimate(value, 0.1),
        probability=probability,
        uncompensated=raw,
    )


def decision_of(*parts):
    return Decision(rule="simple: words", parts=parts)


def test_worst_limit_decides():
    decision = decision_of(
        part("mean", Verdict.CONDITIONAL_PASS, raw=Verdict.FAIL),
        part("5 Hz", Verdict.INCONCLUSIVE),
        part("9 Hz", Verdict.PASS),
    )
    assert (decision.verdict, decision.reason) == (Verdict.INCONCLUSIVE, "At 5 Hz: it is 5 Hz.")
    assert decision.deciding.of == "5 Hz"
    assert decision.deciding.uncompensated is Verdict.FAIL, "the worst of all"
    assert not decision.deciding.marginal


@pytest.mark.parametrize(
    ("first", "second", "of"), [(0.3, 0.2, "b"), (0.2, 0.3, "a"), (0.2, nan, "b")]
)
def test_least_probable_of_equal_verdicts_decides(first, second, of):
    decision = decision_of(part("a", Verdict.FAIL, first), part("b", Verdict.FAIL, second))
    assert decision.deciding.of == of


@pytest.mark.parametrize(
    ("verdict", "better", "worst"),
    [
        (Verdict.PASS, (0.1, 0.9999999999999987), (0.5, 1.0)),
        (Verdict.FAIL, (1.5, 0.0), (1.9, 4e-16)),
    ],
)
def test_rounded_probabilities_do_not_decide_the_worst(verdict, better, worst):
    """A thermocouple: 1.01 K was reported as the worst of 1.20 K and 1.01 K, limit 1.5 K."""
    values = [part(str(value), verdict, p, value=value) for value, p in (better, worst)]
    assert decision_of(*values).deciding.result.value == worst[0]


def test_reason_of_a_single_mean_has_no_prefix():
    assert decision_of(part("mean", Verdict.PASS)).reason == "It is mean."
    two = decision_of(part("mean", Verdict.FAIL), part("5 Hz", Verdict.PASS))
    assert two.reason == "The mean: it is mean."


@pytest.mark.parametrize(
    ("probability", "text"),
    [
        (0.99991, "> 99.99 %"),
        (0.9999, "99.99 %"),
        (0.975, "97.50 %"),
        (1 - CERTAIN, "0.01 %"),
        (0.00009, "< 0.01 %"),
    ],
)
def test_probability_text_never_shows_certainty(probability, text):
    assert probability_text(probability) == text
