from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.analysis.verdict.evidence import as_judged
from rigrunner.api.analysis import Check, Consequence
from rigrunner.api.checks import forbidden
from rigrunner.api.verdict import Verdict
from rigrunner.procedure import Acceptance
from rigrunner_bearings.api.compensations import Compensation
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.compensations.checks import positive
from rigrunner_bearings.torque.binding import bind
from rigrunner_bearings.torque.headline import without_scatter
from unit.analysis.helpers_analysis import (
    AT_REVERSAL,
    acceptance,
    analysed,
    recording,
    registry,
    run_of,
    spec,
    swing_point,
)

SCATTER = np.array([0.01, -0.01, 0.0, 0.02, -0.02, 0.0, 0.01, -0.01, 0.005, -0.005])
SINGLE = "A single value shows no scatter (at 5 Hz): the uncertainty lacks its type A part"


def sweep(extra_nm, load_n):
    peaks = {f: 0.9 + 0.004 * f**2 + extra_nm + SCATTER for f in (2.0, 4.0, 6.0, 8.0, 10.0)}
    return run_of(*(recording(values, f, load_n=load_n) for f, values in peaks.items()))


@pytest.fixture(scope="module")
def no_load():
    return sweep(0.0, 0.0)


def test_only_an_inconclusive_check_prevents_a_decision():
    checks = [
        Check("spikes", ok=False, text="many", consequence=Consequence.BUDGET),
        Check("clipping", ok=True, text="none", decisive=True),
    ]
    assert forbidden(checks) == ""
    failed = Check("torque", ok=False, text="-1", consequence=Consequence.INCONCLUSIVE)
    sentence = forbidden([*checks, failed])
    expected = "The check 'torque' failed: -1; its effect cannot be estimated; no verdict."
    assert sentence == expected


def test_single_loaded_value_has_no_scatter():
    loaded = (swing_point([1.0, 1.1], 4.0), swing_point([1.0], 5.0))
    fitted = Compensation("torque", (), curve=object())
    assert without_scatter(loaded, (), fitted).startswith(SINGLE)
    assert without_scatter(loaded[:1], (), fitted) == ""


def test_single_no_load_value_has_scatter_only_about_a_fitted_curve():
    loaded, no_load = (swing_point([1.0, 1.1], 5.0),), (swing_point([0.5], 5.0),)
    assert without_scatter(loaded, no_load, Compensation("t", (), curve=object())) == ""
    assert without_scatter(loaded, no_load, Compensation("t", ())).startswith(SINGLE)


def test_swapped_runs_are_inconclusive_and_name_the_failed_check(no_load):
    decision = analysed(sweep(-0.1, 1000.0), no_load, accept=acceptance()).decision
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert decision.reason.startswith("The check 'positive torque' failed: 2 Hz -0.1")
    assert decision.reason.endswith("the no-load run or the method does not fit this run).")


def test_clipped_swing_is_inconclusive(no_load):
    run = sweep(0.7, 1000.0)
    torque = run.recordings[0].channels["tester.torque"]
    channels = run.recordings[0].channels | {"tester.torque": np.minimum(torque, 1.55)}
    clipped = (replace(run.recordings[0], channels=channels), *run.recordings[1:])
    decision = analysed(replace(run, recordings=clipped), no_load, accept=acceptance()).decision
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert decision.reason.startswith("The check 'clipping' failed: 2Hz has ")


def test_raw_peak_is_judged_at_each_frequency(no_load):
    limit = {"of": "torque", "each": "frequency", "max": "1.7 N·m", "source": "a test"}
    accept = Acceptance.model_validate({"limits": [limit | {"measurand": AT_REVERSAL}]})
    parts = analysed(sweep(0.7, 1000.0), no_load, accept=accept).decision.parts
    assert [part.of for part in parts] == ["2 Hz", "4 Hz", "6 Hz", "8 Hz", "10 Hz"]
    assert {part.verdict for part in parts} == {Verdict.PASS}
    raw_peaks = [0.9 + 0.004 * f**2 + 0.7 for f in (2, 4, 6, 8, 10)]
    expected = [Verdict.PASS if peak <= 1.7 else Verdict.FAIL for peak in raw_peaks]
    assert [part.uncompensated for part in parts] == expected


@pytest.mark.parametrize(
    ("method", "words"),
    [
        ("paper_peak", "load-induced torque at the reversals of a swing"),
        ("peak_same_frequency", "load-induced torque at the reversals of a swing"),
        ("template_inverse", "load-induced torque at the reversals of a swing"),
        ("model_inverse", "load-induced torque at the reversals of a swing"),
        ("energy", "load-induced torque under way"),
        ("breakaway_peak", "total torque from rest"),
    ],
)
def test_compensation_declares_its_kind_of_torque(method, words):
    assert str(registry().record("compensation", method).yields) == words


def test_limit_of_the_starting_torque_does_not_apply_to_the_running_torque(no_load):
    energy = spec(compensations=["energy"], primary="energy")
    decision = analysed(sweep(0.7, 1000.0), no_load, energy, acceptance()).decision
    assert decision.verdict is Verdict.INCONCLUSIVE
    assert "the result is the load-induced torque under way under 1002 N" in decision.reason


def test_negative_running_torque_is_decisive(no_load):
    """If the runs are swapped, the peaks may be above zero, but the bearing returns energy."""
    points = (
        TorqueDetails.of(analysed(sweep(0.7, 1000.0), no_load)).compensations["paper_peak"].points
    )
    check = positive(points, [-0.1] * len(points))
    _, judged = bind(Compensation("t", points), [check])
    assert forbidden(judged).startswith("The check 'torque above zero' failed: 2 Hz: -0.1")


@pytest.mark.parametrize(
    ("is_decisive", "consequence", "expected", "ok"),
    [
        (True, None, Consequence.INCONCLUSIVE, False),
        (True, Consequence.NOTE, Consequence.INCONCLUSIVE, False),
        (False, None, Consequence.NOTE, True),
        (False, Consequence.BUDGET, Consequence.BUDGET, False),
    ],
)
def test_only_a_failed_decisive_check_prevents_a_decision(is_decisive, consequence, expected, ok):
    check = Check("spikes", ok=False, text="", decisive=is_decisive, consequence=consequence)
    judged = as_judged(check)
    assert judged.consequence is expected
    assert judged.ok is ok
    assert bool(forbidden([judged])) == is_decisive
