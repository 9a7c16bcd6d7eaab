from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot, inf, isnan, nan
from types import SimpleNamespace

import pytest

from rigrunner.analysis.verdict import decision as deciding
from rigrunner.analysis.verdict.evidence import Evidence
from rigrunner.analysis.verdict.limited_values import mean_of
from rigrunner.analysis.verdict.rule import AppliedRule
from rigrunner.api import AnalysisDetails
from rigrunner.api.analysis import Component
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.data import Estimate
from rigrunner.api.findings import MeasurementResult, MissingResult, ResultDefinition
from rigrunner.api.verdict import Verdict
from rigrunner.procedure import Acceptance
from rigrunner.registry import load_registry
from rigrunner_bearings.api.measurand import Condition, MeasurandKind, Nature
from rigrunner_bearings.api.torque import TorqueDetails

REGISTRY = load_registry()
AT_REVERSAL = {"nature": "load_induced", "condition": "at_reversal"}
RAW = Estimate(3.0, 0.01)
STARTING = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)
TORQUE = ResultDefinition(name="torque", unit="N·m", per=("frequency",), measurand=STARTING)


def limit(maximum="0.95 N·m", **changes):
    mean = {"of": "torque", "mean": True, "max": maximum, "source": "a test"}
    return mean | {"measurand": AT_REVERSAL} | changes


def each_frequency(maximum="0.95 N·m", **changes):
    return limit(maximum, mean=False, each="frequency") | changes


def at(*frequencies):
    return {"frequency": [f"{hz} Hz" for hz in frequencies]}


def accept(*limits, rule="guard_band_u", **changes):
    return Acceptance.model_validate({"limits": list(limits), "rule": rule, **changes})


def decide(acceptance, results):
    return deciding.decide(acceptance, AppliedRule.of(acceptance, REGISTRY), results)


def result_at(value, u, raw, hz=None):
    coordinates = {} if hz is None else {"frequency": CoordinateValue(hz, "Hz")}
    return MeasurementResult(
        of=TORQUE, estimate=Estimate(value, u), coordinates=coordinates, uncorrected=raw
    )


def evidence(mean=0.5, *, u=0.05, problem="", points=None, loads=(1000.0,), kind=STARTING, raw=RAW):
    torque = TorqueDetails(
        compensations={"template_inverse": None},
        primary="template_inverse",
        kind=kind,
        loaded=tuple(SimpleNamespace(load_n=load) for load in loads),
    )
    return Evidence(
        details={"torque": torque},
        means=() if mean is None else (result_at(mean, u, raw),),
        results=tuple(result_at(value, u, raw, hz) for hz, value in (points or {}).items()),
        problems={"torque": problem},
    )


@pytest.mark.parametrize("value", [0.0, -0.1, nan])
@pytest.mark.parametrize("rule", ["simple", "guard_band_u", "non_binary"])
def test_torque_that_is_not_positive_is_inconclusive(value, rule):
    decision = decide(accept(limit(), rule=rule), evidence(value))
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert decision.reason.endswith("N·m is not a friction torque: friction does not drive.")


@pytest.mark.parametrize("u", [0.0, nan, inf])
@pytest.mark.parametrize("rule", ["simple", "guard_band_u"])
def test_missing_uncertainty_is_inconclusive(u, rule):
    decision = decide(accept(limit(), rule=rule), evidence(u=u))
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert decision.reason == "The uncertainty of the result is not known."
    assert isnan(decision.deciding.probability)
    assert isnan(decision.deciding.false_accept_risk)
    assert isnan(decision.deciding.false_reject_risk)
    assert isnan(decision.deciding.guard_band)


def test_problem_of_the_evidence_is_the_reason():
    decision = decide(accept(limit()), evidence(problem="The check 'clipping' failed: 5 Hz."))
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert decision.reason == "The check 'clipping' failed: 5 Hz."
    assert isnan(decision.deciding.probability)
    assert decision.deciding.result == Estimate(0.5, 0.05), "shown nevertheless"


def test_raw_torque_is_judged_by_the_same_rule():
    decision = decide(accept(limit(), rule="simple"), evidence())
    assert (decision.verdict, decision.deciding.uncompensated) == (Verdict.PASS, Verdict.FAIL)
    without_raw = decide(accept(limit()), evidence(raw=None))
    assert without_raw.deciding.uncompensated is Verdict.INCONCLUSIVE


def test_decision_has_the_details_of_a_certificate():
    decision = decide(accept(limit(min="0.2 N·m")), evidence())
    assert decision.rule.startswith("guard_band_u: guard band w = U of 95 %")
    assert str(decision.deciding.limits) == "0.2 N·m to 0.95 N·m"
    assert (decision.deciding.limits.lower, decision.deciding.limits.upper) == (0.2, 0.95)
    assert decision.deciding.guard_band == pytest.approx(1.959963985 * 0.05)
    assert decision.deciding.false_accept_risk == pytest.approx(0.025, abs=1e-4)
    assert decision.deciding.probability == pytest.approx(1.0, abs=1e-6)
    assert decision.deciding.source == "a test"
    assert str(decision.deciding.measurand) == "load-induced torque at the reversals of a swing"
    assert [part.of for part in decision.parts] == ["mean"]


def test_worst_frequency_decides():
    decision = decide(accept(each_frequency()), evidence(points={1: 0.5, 35: 1.2, 20: 0.7}))
    assert [part.verdict for part in decision.parts] == [Verdict.PASS, Verdict.FAIL, Verdict.PASS]
    assert (decision.verdict, decision.deciding.of) == (Verdict.FAIL, "35 Hz")
    assert decision.reason == "At 35 Hz: outside the limit ≤ 0.95 N·m by 0.2500 N·m."
    assert decision.deciding.result == Estimate(1.2, 0.05)


def test_named_frequency_has_its_own_limit():
    limits = each_frequency(**{"except": at(35)}), each_frequency("1.5 N·m", where=at(35))
    decision = decide(accept(*limits), evidence(points={1: 0.5, 35: 1.2}))
    assert decision.verdict is Verdict.PASS
    assert [str(part.limits) for part in decision.parts] == ["≤ 0.95 N·m", "≤ 1.5 N·m"]


def test_mean_and_frequencies_have_separate_limits():
    limits = limit("0.6 N·m"), each_frequency()
    decision = decide(accept(*limits, rule="simple"), evidence(0.65, points={1: 0.5, 35: 0.8}))
    assert [part.of for part in decision.parts] == ["mean", "1 Hz", "35 Hz"]
    assert (decision.verdict, decision.deciding.of) == (Verdict.FAIL, "mean")
    assert decision.reason.startswith("The mean: outside the limit ≤ 0.6 N·m by 0.0500 N·m.")


def test_least_probable_of_equal_verdicts_decides():
    decision = decide(accept(each_frequency()), evidence(points={1: 0.5, 35: 0.8, 20: 0.7}))
    assert (decision.verdict, decision.deciding.of) == (Verdict.PASS, "35 Hz")


def test_fail_outweighs_inconclusive():
    decision = decide(accept(each_frequency()), evidence(points={1: -0.5, 35: 1.8}))
    assert {part.verdict for part in decision.parts} == {Verdict.INCONCLUSIVE, Verdict.FAIL}
    assert decision.verdict is Verdict.FAIL
    decision = decide(accept(each_frequency()), evidence(points={1: -0.5, 35: 0.4}))
    assert decision.verdict is Verdict.INCONCLUSIVE


def test_named_frequency_without_result_is_inconclusive():
    limits = limit(), each_frequency("1.5 N·m", where=at(35))
    decision = decide(accept(*limits), evidence(points={1: 0.5}))
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert decision.reason == "At 35 Hz: there is no result at 35 Hz."


def test_no_result_is_inconclusive_with_its_reason():
    no_results = evidence(None, problem="There is no result to decide on: it failed")
    for value_limit in (limit(), each_frequency(), each_frequency(where=at(35))):
        decision = decide(accept(value_limit), no_results)
        assert decision.verdict is Verdict.INCONCLUSIVE
        assert "it failed" in decision.reason
        assert isnan(decision.deciding.probability)


def no_result_at(hz):
    coordinates = {"frequency": CoordinateValue(hz, "Hz")}
    return MissingResult(of=TORQUE, coordinates=coordinates, why="it clips")


@pytest.mark.parametrize("kind", ["of the analysis", "of some places", "without a value"])
def test_limit_of_the_mean_comes_before_those_of_frequencies(kind):
    own_mean = 0.7 if kind == "of the analysis" else None
    results = evidence(own_mean, points={1: 0.5, 20: 0.7, 35: 0.9})
    mean = limit("0.6 N·m", **({"except": at(35)} if kind == "of some places" else {}))
    if kind == "without a value":
        results = replace(results, missing=(no_result_at(50),))
    decision = decide(accept(each_frequency(where=at(1, 20, 35)), mean), results)
    assert [part.of for part in decision.parts] == ["mean", "1 Hz", "20 Hz", "35 Hz"]
    value = {"of the analysis": 0.7, "of some places": pytest.approx(0.6)}.get(kind)
    result = decision.parts[0].result
    assert (result and result.value) == value


def test_all_places_without_a_value_are_reported():
    results = replace(evidence(points={1: 0.5}), missing=(no_result_at(20), no_result_at(35)))
    decision = decide(accept(each_frequency()), results)
    assert [part.of for part in decision.parts] == [
        "1 Hz", "torque at frequency = 20 Hz", "torque at frequency = 35 Hz",
    ]  # fmt: skip
    assert decision.parts[2].reason == (
        "There is no value of torque at frequency = 35 Hz: it clips."
    )


def test_missing_result_of_another_name_does_not_count():
    wear = MissingResult(
        of=ResultDefinition(name="wear", unit="µm"), coordinates={}, why="it clips"
    )
    results = replace(evidence(points={1: 0.5}), missing=(wear,))
    for value_limit in (limit(), each_frequency()):
        decision = decide(accept(value_limit), results)
        assert (decision.verdict, len(decision.parts)) == (Verdict.PASS, 1)


BREAKAWAY = limit(
    "0.9039 N·m",
    min="0.0282 N·m",
    source="AS14101",
    measurand={"nature": "no_load", "condition": "from_rest"},
)


def test_no_load_breakaway_limit_does_not_apply_to_a_loaded_swing():
    decision = decide(accept(BREAKAWAY), evidence())
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert decision.reason == (
        "The limit is for the no-load torque from rest, and the result is the load-induced torque "
        "at the reversals of a swing under 1000 N: conformity cannot be stated."
    )
    assert isnan(decision.deciding.probability)


def test_result_without_analysis_details_is_compared_with_its_limit():
    depth = MeasurementResult(of=TORQUE, estimate=Estimate(0.5, 0.05))
    results = Evidence(results=(depth,))
    assert decide(accept(limit(mean=False)), results).verdict is Verdict.PASS
    total = {"nature": "total", "condition": "from_rest"}
    for measurand, words in (
        (total, "torque: The limit is for the total torque from rest, and the result is"),
        (None, "torque: 'torque' is the load-induced torque at the reversals of a swing, and the"),
    ):
        decision = decide(accept(limit(mean=False, measurand=measurand)), results)
        assert decision.verdict is Verdict.INCONCLUSIVE
        assert decision.reason.startswith(words)


def test_marginal_verdict_is_marked():
    acceptance = accept(limit(), rule="simple", marginal="0.02 N·m")
    assert decide(acceptance, evidence(0.94)).deciding.marginal
    assert not decide(acceptance, evidence(0.90)).deciding.marginal


@pytest.mark.parametrize(("value", "verdict"), [(0.95, Verdict.PASS), (0.950001, Verdict.FAIL)])
def test_value_at_its_limit_passes(value, verdict):
    """A tolerance interval includes its ends (JCGM 106, 3.3.5)."""
    assert decide(accept(limit(), rule="simple"), evidence(value)).verdict is verdict


def test_inconclusive_decision_is_not_marginal():
    acceptance = accept(limit(), rule="simple", marginal="0.02 N·m")
    assert not decide(acceptance, evidence(0.94, problem="A check failed.")).deciding.marginal


def test_missing_result_without_a_reason_is_inconclusive():
    decision = decide(accept(limit()), evidence(mean=None))
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert decision.reason == "There is no result 'torque'."


@dataclass(frozen=True)
class Depth(AnalysisDetails):
    """The details of a third-party analysis of wear."""

    corrects = True

    def impossible(self, value, unit):
        return f"{value:g} {unit} is no depth." if value < 0 else ""

    def objection(self, limited):
        return "" if limited is None else "Wear has no nature."


def test_third_party_details_can_reject_a_value():
    wear = ResultDefinition(name="wear", unit="mm")
    wear_acceptance = accept({"of": "wear", "max": "1 mm", "source": "a test"}, rule="simple")

    def decision_on(value, raw, details):
        result = MeasurementResult(
            of=wear, estimate=Estimate(value, 0.1, inf, "mm"), uncorrected=raw
        )
        return decide(wear_acceptance, Evidence(results=(result,), details=details))

    raw = Estimate(1.5, 0.1, inf, "mm")
    negative = decision_on(-0.5, raw, {"wear": Depth()})
    assert negative.verdict is Verdict.INCONCLUSIVE
    assert negative.reason == "At wear: -0.5 mm is no depth."
    positive = decision_on(0.5, raw, {"wear": Depth()})
    assert (positive.verdict, positive.deciding.uncompensated) == (Verdict.PASS, Verdict.FAIL)
    assert decision_on(-0.5, raw, {}).verdict is Verdict.PASS


def test_shared_gain_error_cancels_in_a_mean_of_opposite_signs():
    """At -5 V and 5 V the errors of the gain are opposite, those of an offset equal."""
    y = ResultDefinition(name="y", unit="V")

    def result(value, *, shared=True):
        lines = (
            Component("gain", abs(value) * 0.01, inf, "normal", common=True,
                      sensitivity=value, shared=shared),
            Component("offset", 0.001, inf, "normal", common=True, sensitivity=1.0),
        )  # fmt: skip
        return MeasurementResult(of=y, estimate=Estimate(value, nan, unit="V"), components=lines)

    assert mean_of([result(-5.0), result(5.0)]).u == pytest.approx(0.001)
    assert mean_of([result(-3.0), result(5.0)]).u == pytest.approx(hypot(0.01, 0.001))
    independent = mean_of([result(-5.0, shared=False), result(5.0, shared=False)])
    assert independent.u == pytest.approx(hypot(0.05, 0.001))


def test_mean_has_no_uncertainty_if_a_result_has_no_budget():
    """Otherwise U of the mean of two would be half that of the one with a budget."""
    gain = ResultDefinition(name="gain", unit="V")
    line = Component("reading", 0.1, inf, "normal", common=True)
    complete = MeasurementResult(of=gain, estimate=Estimate(1.0, 0.1, unit="V"), components=(line,))
    no_budget = MeasurementResult(of=gain, estimate=Estimate(1.0, 0.4, unit="V"), components=())
    exact = MeasurementResult(of=gain, estimate=Estimate(1.0, 0.0, unit="V"), components=())
    assert isnan(mean_of([complete, no_budget]).u)
    assert mean_of([complete, exact]).u == pytest.approx(0.05)
