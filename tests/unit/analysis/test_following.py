"""Limits that depend on a coordinate, as IEC 60751:2022, class B: ±(0.30 + 0.005 |t|) °C."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from rigrunner.analysis.verdict import decision as deciding
from rigrunner.analysis.verdict.evidence import Evidence
from rigrunner.analysis.verdict.rule import AppliedRule
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner.api.findings import MeasurementResult, ResultDefinition
from rigrunner.api.verdict import Limits, Verdict
from rigrunner.procedure import Acceptance, Limit
from rigrunner.registry import load_registry

REGISTRY = load_registry()
CLASS_B = {"base": "0.30 K", "rise": "0.005 K", "per": "1 K", "over": "chamber.temperature"}
TABLE = {
    "over": "chamber.temperature",
    "points": [["-20 °C", "92.317 Ω"], ["0 °C", "100.117 Ω"], ["100 °C", "138.808 Ω"]],
}


def limit(**changes):
    settings = {"of": "deviation", "each": "chamber.temperature", "source": "IEC 60751"}
    return Limit.model_validate(settings | changes)


def at(celsius):
    return {"chamber.temperature": CoordinateValue(celsius, "°C")}


@pytest.mark.parametrize(
    ("celsius", "tolerance"), [(-196, 1.28), (-100, 0.80), (0, 0.30), (100, 0.80), (600, 3.30)]
)
def test_class_b_tolerances_of_iec_60751(celsius, tolerance):
    """The tolerances are those of the table in the standard for wire-wound sensors, F 0.3."""
    limits = limit(plus_minus=CLASS_B).limits_at(at(celsius), "mK")
    assert (limits.lower, limits.upper) == pytest.approx((-1000 * tolerance, 1000 * tolerance))


def test_rising_limit_starts_at_its_from_value():
    rising = {"base": "20 °C", "rise": "0.5 K", "per": "10 K", "over": "chamber.temperature"}
    limits = limit(max=rising | {"from": "50 °C"}, min="10 °C").limits_at(at(30), "°C")
    assert (limits.lower, limits.upper) == pytest.approx((10, 21))


@pytest.mark.parametrize(
    ("celsius", "upper"), [(-20, 92.317), (-10, 96.217), (0, 100.117), (50, 119.4625)]
)
def test_table_is_interpolated_linearly(celsius, upper):
    assert limit(max=TABLE).limits_at(at(celsius), "Ω").upper == pytest.approx(upper, rel=1e-12)


@pytest.mark.parametrize(
    ("coordinates", "words"),
    [
        (at(101), "known from -20 °C to 100 °C, not at 101 °C"),
        ({"phase": CoordinateValue("wear")}, "follows 'chamber.temperature', and the result has"),
        ({"chamber.temperature": CoordinateValue(3.0, "V")}, "follows a temperature, and"),
    ],
)
def test_coordinate_outside_the_table_is_refused(coordinates, words):
    with pytest.raises(DataError, match=words):
        limit(max=TABLE).limits_at(coordinates, "Ω")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plus_minus": CLASS_B, "max": "1 K"}, "replaces min and max"),
        ({"plus_minus": "0.3 °C"}, "write a difference in K"),
        ({"plus_minus": "-0.3 K"}, "expected more than 0"),
        ({"plus_minus": "0 K"}, "expected more than 0"),
        ({"plus_minus": CLASS_B | {"rise": "1 V"}}, "base is a temperature, rise a voltage"),
        ({"plus_minus": CLASS_B | {"from": "1 V"}}, "per is a temperature, from a voltage"),
        ({"max": CLASS_B | {"rise": "1 °C"}}, "write a difference in K"),
        ({"max": TABLE, "each": None, "mean": True}, "a mean has no limit"),
        ({"max": TABLE, "min": "1 V"}, "min is a voltage, max a resistance"),
        ({"max": TABLE | {"points": TABLE["points"][::-1]}}, "in ascending order"),
        ({"max": TABLE | {"points": TABLE["points"][:1]}}, "at least 2 items"),
        ({"max": TABLE | {"points": [["0 °C", "1 Ω"], ["1 V", "2 Ω"]]}}, "of several kinds"),
        ({}, "a limit needs max, min, or both, or plus_minus"),
    ],
)
def test_inconsistent_limit_is_refused(changes, words):
    with pytest.raises(ValidationError, match=words):
        limit(**changes)


@pytest.mark.parametrize("end", [{"plus_minus": CLASS_B}, {"max": TABLE}, {"plus_minus": "1 K"}])
def test_limit_round_trips_as_written(end):
    assert Limit.model_validate(limit(**end).as_written()) == limit(**end)


DEVIATION = ResultDefinition(name="deviation", unit="K", per=("chamber.temperature",))


def decide(values, *limits, rule="simple"):
    results = tuple(
        MeasurementResult(of=DEVIATION, estimate=Estimate(value, u, unit="K"), coordinates=at(t))
        for t, (value, u) in values.items()
    )
    written = [limit.as_written() for limit in limits]
    acceptance = Acceptance.model_validate({"limits": written, "rule": rule})
    evidence = Evidence(results=results, problems={})
    return deciding.decide(acceptance, AppliedRule.of(acceptance, REGISTRY), evidence)


def test_limit_of_zero_is_inconclusive():
    """1 % of the set-point: 0 at 0 °C, and 0.5 K at -50 °C."""
    share = limit(plus_minus={**CLASS_B, "base": "0 K", "rise": "1 K", "per": "100 K"})
    assert share.limits_at(at(-50), "K") == Limits.between(-0.5, 0.5, "K")
    decision = decide({-50: (-0.4, 0.01), 0: (0.0, 0.01)}, share)
    reasons = {part.of: (part.verdict, part.reason) for part in decision.parts}
    assert [verdict for verdict, _ in reasons.values()] == ["pass", "inconclusive"]
    assert "The limit at chamber.temperature = 0 °C is 0 K, which is not above 0." in [
        reason for _, reason in reasons.values()
    ]


def test_negative_limit_is_inconclusive():
    """Its two ends would be swapped, and every value would fail."""
    falling = limit(plus_minus={**CLASS_B, "base": "0.2 K", "rise": "-1 K", "per": "20 K"})
    assert falling.limits_at(at(2), "K") == Limits.between(-0.1, 0.1, "K")
    (part,) = decide({10: (0.05, 0.01)}, falling).parts
    assert (part.verdict, part.reason) == (
        "inconclusive", "The limit at chamber.temperature = 10 °C is -0.3 K, which is not above 0."
    )  # fmt: skip


def test_each_point_is_compared_with_its_own_limit():
    """0.5 K is too high at 0 °C (0.30 K), and allowed at 100 °C (0.80 K)."""
    decision = decide({0: (0.5, 0.01), 100: (0.5, 0.01)}, limit(plus_minus=CLASS_B))
    assert [part.verdict for part in decision.parts] == [Verdict.FAIL, Verdict.PASS]
    assert [str(part.limits) for part in decision.parts] == ["-0.3 K to 0.3 K", "-0.8 K to 0.8 K"]
    assert [str(part.coordinates["chamber.temperature"]) for part in decision.parts] == [
        *("0 °C", "100 °C"),
    ]


def test_worst_point_is_chosen_by_the_decision_rule():
    """At 100 °C, 0.5 K has the larger margin, but it is less than U = 0.4 K."""
    over_all = limit(plus_minus=CLASS_B, each=None, worst=True)
    decision = decide({0: (0.2, 0.01), 100: (0.5, 0.2)}, over_all, rule="guard_band_u")
    (part,) = decision.parts
    assert (part.verdict, part.of) == (
        Verdict.FAIL,
        "worst deviation at chamber.temperature = 100 °C",
    )
    assert decision.reason.startswith(
        "Worst deviation at chamber.temperature = 100 °C:"
        " Margin to the limit -0.8 K to 0.8 K: 0.30 K, less than U = 0.39 K;"
    )


def test_worst_is_listed_before_each_point():
    limits = limit(plus_minus=CLASS_B, worst=True)
    decision = decide({0: (0.2, 0.01), 100: (0.9, 0.01)}, limits)
    assert [part.of for part in decision.parts] == [
        "worst deviation at chamber.temperature = 100 °C",
        "deviation at chamber.temperature = 0 °C",
        "deviation at chamber.temperature = 100 °C",
    ]
    assert decision.deciding.of == decision.parts[0].of


def test_point_beyond_the_table_is_inconclusive():
    table = {"over": "chamber.temperature", "points": [["0 °C", "1 K"], ["50 °C", "2 K"]]}
    (part,) = decide({60: (0.1, 0.01)}, limit(max=table)).parts
    assert part.verdict is Verdict.INCONCLUSIVE
    assert part.reason == "The limit is known from 0 °C to 50 °C, not at 60 °C."
