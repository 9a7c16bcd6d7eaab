from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.analysis.document import document
from rigrunner.api.analysis import Consequence
from rigrunner.api.errors import DataError, PluginError
from rigrunner.api.verdict import Verdict
from rigrunner_bearings.api.torque import TorqueDetails
from unit.analysis.helpers_analysis import (
    acceptance,
    analysed,
    instrument,
    no_load_spec,
    recording,
    run_of,
    spec,
)

FREQUENCIES = (2.0, 4.0, 6.0, 8.0, 10.0)
SCATTER = np.array([0.01, -0.01, 0.0, 0.02, -0.02, 0.0, 0.01, -0.01, 0.005, -0.005])


def rig_torque(frequency_hz):
    return 0.9 + 0.02 * frequency_hz + 0.004 * frequency_hz**2


def sweep(extra_nm=0.0, load_n=0.0, frequencies=FREQUENCIES, **changes):
    """Return a run whose peaks are a quadratic of the frequency plus a constant."""
    recordings = (
        recording(rig_torque(f) + extra_nm + SCATTER, f, load_n=load_n) for f in frequencies
    )
    return run_of(*recordings, **changes)


@pytest.fixture(scope="module")
def loaded():
    return sweep(0.7, 1000.0)


@pytest.fixture(scope="module")
def no_load():
    return sweep(run_id="run-0", procedure_id="SSPB-NLI")


def test_headline_is_the_mean_of_the_primary_method(loaded, no_load):
    result = analysed(loaded, no_load)
    assert TorqueDetails.of(result).primary == "paper_peak"
    assert result.headline.value == pytest.approx(0.7, abs=2e-3)
    expected = np.mean([rig_torque(f) + 0.7 for f in FREQUENCIES])
    assert TorqueDetails.of(result).raw_headline.value == pytest.approx(expected, rel=1e-3)
    assert [point.set_frequency_hz for point in TorqueDetails.of(result).loaded] == list(
        FREQUENCIES
    )


def test_no_load_peaks_are_fitted(loaded, no_load):
    fits = {fit.name: fit for fit in TorqueDetails.of(analysed(loaded, no_load)).fits}
    assert list(fits) == ["polynomial", "inertia_physical"]
    assert fits["polynomial"].curve.coefficients == pytest.approx([0.9, 0.02, 0.004], rel=5e-3)


def test_missing_no_load_run_gives_no_curves(loaded):
    assert [fit.curve for fit in TorqueDetails.of(analysed(loaded, None, spec())).fits] == [
        None,
        None,
    ]


def test_offset_is_in_the_uncertainty_of_a_run_without_zero(no_load):
    sensors = {"tester.torque": instrument(offset="0.3 N·m")}
    zeroed, not_zeroed = (
        TorqueDetails.of(
            analysed(sweep(0.7, 1000.0, instruments=sensors, **changes), no_load)
        ).raw_headline.u
        for changes in ({}, {"zeros": {}})
    )
    assert zeroed < 0.01
    assert not_zeroed == pytest.approx(0.3 / 3**0.5, rel=1e-3)


def test_no_load_run_is_fitted_without_a_decision(no_load):
    result = analysed(no_load)
    assert TorqueDetails.of(result).fits[0].curve.coefficients == pytest.approx(
        [0.9, 0.02, 0.004], rel=5e-3
    )
    assert (result.headline, result.decision, TorqueDetails.of(result).primary) == (None, None, "")
    assert TorqueDetails.of(result).raw_headline is not None


def test_repeated_frequency_of_a_sweep_keeps_both_points(no_load):
    recordings = [
        replace(recording(rig_torque(f) + extra + SCATTER, f, load_n=1000.0), name=f"{k:03}")
        for k, (f, extra) in enumerate([(2.0, -0.7), *((f, 0.7) for f in FREQUENCIES)])
    ]
    result = analysed(run_of(*recordings), no_load)
    positive, friction = (
        next(check for check in result.checks if check.name == name)
        for name in ("positive torque", "friction coefficient")
    )
    assert positive.consequence is Consequence.INCONCLUSIVE
    assert friction.consequence is Consequence.NOTE
    assert positive.value == pytest.approx(-0.7, abs=5e-3)
    raw = [point.peak_nm.mean() for point in TorqueDetails.of(result).loaded]
    assert list(result.details[0].plot().columns["raw"].values) == raw
    assert raw[1] - raw[0] == pytest.approx(1.4, abs=5e-3)


def test_limits_decide_on_the_compensated_torque(loaded, no_load):
    decision = analysed(loaded, no_load, accept=acceptance("0.95 N·m")).decision
    assert decision.verdict is Verdict.PASS
    assert decision.deciding.uncompensated is Verdict.FAIL
    assert (decision.deciding.limits.lower, decision.deciding.limits.upper) == (-np.inf, 0.95)
    assert analysed(loaded, no_load, accept=acceptance("0.5 N·m")).decision.verdict is Verdict.FAIL


def test_not_applicable_primary_method_is_inconclusive_with_its_reason(loaded):
    result = analysed(loaded, None, spec(), acceptance())
    paper = TorqueDetails.of(result).compensations["paper_peak"]
    assert paper.points == ()
    assert "needs a no-load run" in paper.not_applicable
    assert result.headline is None
    assert result.decision.verdict is Verdict.INCONCLUSIVE
    assert "needs a no-load run" in result.decision.reason
    assert result.notes == (f"paper_peak is not applicable: {paper.not_applicable}",)


def test_method_is_not_applicable_outside_the_fitted_range(no_load):
    result = analysed(sweep(0.7, 1000.0, (2.0, 12.0)), no_load)
    assert "not at 12" in TorqueDetails.of(result).compensations["paper_peak"].not_applicable


def test_method_is_not_applicable_without_a_registered_sensor(no_load):
    unregistered = sweep(0.7, 1000.0, instruments={})
    result = analysed(unregistered, no_load)
    assert "no tester.torque" in TorqueDetails.of(result).compensations["paper_peak"].not_applicable
    assert TorqueDetails.of(result).raw_headline is None


def test_refit_without_a_named_fit_is_not_applicable(loaded, no_load):
    result = analysed(loaded, no_load, spec(fits=[]))
    assert "names no fit" in TorqueDetails.of(result).compensations["paper_peak"].not_applicable


def test_failed_fit_has_its_reason(loaded, no_load):
    result = analysed(loaded, no_load, spec(fits=[{"polynomial": {"degree": 4}}]))
    assert TorqueDetails.of(result).fits[0].curve is None
    assert "needs 6 different values of f, got 5" in TorqueDetails.of(result).fits[0].problem


def test_negative_torque_fails_its_check_and_is_inconclusive(no_load):
    result = analysed(sweep(-0.1, 1000.0), no_load, accept=acceptance())
    assert result.decision.verdict is Verdict.INCONCLUSIVE
    flagged = {check.name: check.consequence for check in result.checks if check.consequence}
    assert flagged["positive torque"] is Consequence.INCONCLUSIVE
    assert flagged["friction coefficient"] is Consequence.NOTE
    (text,) = (check.text for check in result.checks if check.name == "positive torque")
    assert [part.split(" Hz")[0] for part in text.split("; ")] == ["2", "4", "6", "8", "10"]


def test_checks_cover_the_loaded_and_the_no_load_run(loaded, no_load):
    checks = analysed(loaded, no_load).checks
    names = [check.name for check in checks]
    assert all(check.ok for check in checks)
    flagged = {check.name for check in checks if check.consequence is Consequence.NOTE}
    assert flagged == {"samples per cycle", "no-load run: samples per cycle"}, "200 at 10 Hz"
    assert len(names) == len(set(names))
    assert {"stroke", "no-load run: stroke", "zero drift", "friction coefficient"} <= set(names)


def test_settings_include_the_defaults(loaded, no_load):
    settings = analysed(loaded, no_load, spec(outliers="grubbs")).settings
    assert settings["outliers"] == {"name": "grubbs", "settings": {"alpha": 0.05, "side": "both"}}
    assert settings["despike"] == {"hampel": {"window": 11, "threshold": 6.0}}
    assert settings["fits"][1]["settings"] == {
        "eccentric": 0.002,
        "centre_distance": 0.045,
        "weighted": False,
    }


def test_all_cycles_are_kept_without_an_outlier_rule():
    peaks = rig_torque(2.0) + SCATTER
    peaks[3] += 1.0
    run = run_of(recording(peaks, 2.0))
    assert not TorqueDetails.of(analysed(run, None, no_load_spec())).loaded[0].peak_kept.all()
    assert (
        TorqueDetails.of(analysed(run, None, no_load_spec(outliers=None))).loaded[0].peak_kept.all()
    )


def test_empty_run_without_fits_gives_empty_results():
    result = analysed(run_of(), None, no_load_spec(fits=[]))
    torque = TorqueDetails.of(result)
    assert (torque.loaded, torque.fits, result.checks) == ((), (), ())
    assert torque.raw_headline is None


def test_run_without_recordings_is_refused():
    with pytest.raises(DataError, match="run run-1 has no recordings"):
        analysed(run_of())


def test_unknown_plugin_is_refused(loaded):
    with pytest.raises(PluginError, match="no fit 'polynomal'"):
        analysed(loaded, None, no_load_spec(fits=["polynomal"]))


def test_analysis_is_deterministic(loaded, no_load):
    first, second = (document(analysed(loaded, no_load, accept=acceptance())) for _ in "ab")
    assert first == second


def test_sensor_errors_are_in_the_budget_of_a_point(no_load):
    """Gain of the difference; two independent drifts; linearity by full scale (GUM 4.3.7)."""
    sensor = instrument(gain="1 %", drift="0.02 N·m", nonlinearity="0.1 %")
    run = sweep(0.7, 1000.0, instruments={"tester.torque": sensor})
    point = TorqueDetails.of(analysed(run, no_load)).compensations["paper_peak"].points[2]
    parts = {component.name: component.u for component in point.components}
    assert parts["sensor gain"] == pytest.approx(0.01 * point.torque.value / 3**0.5, rel=1e-4)
    assert parts["zero drift"] == pytest.approx(0.02 * (2 / 3) ** 0.5)
    assert parts["sensor non-linearity"] == pytest.approx(0.01 / 3**0.5)
