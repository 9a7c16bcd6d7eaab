"""Both Monte Carlo checks, on sweeps whose true spread is known."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import pytest

from rigrunner.analysis.document import document
from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner.cli.summary import summary
from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation, Sweep
from rigrunner_bearings.api.points import PeakPoint
from rigrunner_bearings.torque.draws import draw_pipeline
from rigrunner_bearings.torque.settings import MonteCarloSpec
from rigrunner_bearings.torque.validation import validate
from unit.analysis.helpers_analysis import analysed, instrument, recording, run_of, spec

PEAKS = 2 + 0.1 * np.array([1, -1, 0.5, -0.5, 2, -2, 1.5, -1.5, 0.0, 0.7])
U_PEAKS = PEAKS.std(ddof=1) / sqrt(len(PEAKS))
MONTE_CARLO = MonteCarloSpec(draws=800)


def peak_point(hz):
    kept = np.ones(len(PEAKS), bool)
    return PeakPoint(
        recording=f"{hz:g}Hz",
        set_frequency_hz=hz,
        frequency_hz=Estimate(hz, 0.0, inf, "Hz"),
        load_n=1000.0,
        peak_nm=PEAKS,
        peak_kept=kept,
    )


def mean_of_peaks(u_gain, extra=(), u_peaks=U_PEAKS):
    """Return a method whose result is the mean peak and whose budget has these lines."""

    def method(sweep):
        parts = (
            Component("scatter between cycles", u_peaks, 9.0, "t", common=False),
            Component("sensor gain", u_gain, inf, "rectangular", common=True),
            *extra,
        )
        u = sqrt(sum(part.u**2 for part in parts))
        points = [
            CompensatedPoint(
                set_frequency_hz=point.set_frequency_hz,
                frequency_hz=point.set_frequency_hz,
                raw_nm=2.0,
                rig_nm=0.0,
                torque=Estimate(float(point.peak_nm.mean()), u),
                components=parts,
            )
            for point in sweep.loaded
        ]
        return Compensation("torque", tuple(points))

    return method


def sweep_of(gain="3 %", frequencies=(5.0, 10.0)):
    points = tuple(peak_point(hz) for hz in frequencies)
    return Sweep(points, (), None, instrument(gain=gain), None)


def validation_of(method, sweep, spec=MONTE_CARLO, headline=None):
    points = method(sweep).points
    mean = np.mean([point.torque.value for point in points])
    return validate(
        method,
        sweep,
        points,
        headline or Estimate(float(mean), points[0].torque.u),
        name="mean_of_peaks",
        spec=spec,
        zeroed=True,
        progress=lambda *_: None,
    )


U_GAIN = 0.03 * PEAKS.mean() / sqrt(3)


def test_correct_budget_agrees_with_draws():
    validation = validation_of(mean_of_peaks(U_GAIN), sweep_of(), headline=headline())
    assert validation.pipeline.mean.agrees
    assert all(point.agrees for point in validation.pipeline.points)
    assert validation.pipeline.mean.u == pytest.approx(headline().u, rel=0.1)
    assert validation.pipeline.points[0].u == pytest.approx(sqrt(U_GAIN**2 + U_PEAKS**2), rel=0.1)
    assert (validation.pipeline.draws, validation.pipeline.refused) == (800, 0)


def headline():
    return Estimate(float(PEAKS.mean()), sqrt(U_GAIN**2 + U_PEAKS**2 / 2))


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_wrong_budget_does_not_agree_with_draws(factor):
    """The trials of the equation cannot show it: they draw from the budget."""
    validation = validation_of(mean_of_peaks(factor * U_GAIN, u_peaks=factor * U_PEAKS), sweep_of())
    assert not validation.pipeline.mean.agrees
    assert not validation.agrees
    assert validation.pipeline.mean.gum_is_wider == (factor > 1)
    assert "does not agree with 800 draws" in validation.statements[1]
    assert ("safe" in validation.statements[1]) == (factor > 1)


def test_common_errors_stay_in_mean_and_others_average():
    trials = validation_of(mean_of_peaks(U_GAIN), sweep_of(), headline=headline()).equation
    assert trials.mean.u == pytest.approx(sqrt(U_GAIN**2 + U_PEAKS**2 / 2 * 9 / 7), rel=0.005)
    assert trials.points[0].u == pytest.approx(sqrt(U_GAIN**2 + U_PEAKS**2 * 9 / 7), rel=0.005)
    assert trials.trials >= 1_000_000


def test_rectangular_error_is_narrower_than_gum_interval():
    validation = validation_of(mean_of_peaks(U_GAIN, u_peaks=1e-6), sweep_of())
    edge = 0.95 * 0.03 * PEAKS.mean()
    assert validation.equation.mean.high - PEAKS.mean() == pytest.approx(edge, rel=0.01)
    assert not validation.equation.mean.agrees
    assert validation.equation.mean.gum_is_wider
    assert "Use the Monte Carlo interval" in validation.statements[0]


def test_error_not_in_data_is_added_from_budget():
    extra = (Component("method", 0.2, inf, "normal", common=True),)
    validation = validation_of(mean_of_peaks(U_GAIN, extra), sweep_of(gain="0 %"))
    assert validation.pipeline.as_effects == ("method",)
    assert validation.pipeline.through_the_data == ("scatter between cycles", "sensor gain")
    assert validation.pipeline.mean.u == pytest.approx(sqrt(0.04 + U_PEAKS**2 / 2), rel=0.1)


def test_same_seed_gives_same_numbers():
    method = mean_of_peaks(U_GAIN)
    first, repeated, other = (
        validation_of(method, sweep_of(), MonteCarloSpec(draws=500, seed=seed))
        for seed in (4, 4, 5)
    )
    assert first == repeated
    assert other.pipeline.mean.mean != first.pipeline.mean.mean


def test_refused_draws_are_counted():
    sweep, calls = sweep_of(), []
    points = mean_of_peaks(U_GAIN)(sweep).points

    def unreliable(changed):
        calls.append(1)
        if len(calls) % 2:
            raise DataError("not this one")
        return mean_of_peaks(U_GAIN)(changed)

    def never(_changed):
        raise DataError("never")

    options = {"zeroed": True, "draws": 10, "seed": 1, "progress": lambda *_: None}
    drawn = draw_pipeline(unreliable, sweep, points, **options)
    assert (len(drawn.torque_nm), drawn.refused) == (5, 5)
    with pytest.raises(DataError, match="each of 10 draws"):
        draw_pipeline(never, sweep, points, **options)


@pytest.mark.thorough
def test_validation_is_in_document_and_summary():
    frequencies, scatter = (2.0, 6.0, 10.0, 14.0), np.linspace(-0.02, 0.02, 5)
    sensors = {"tester.torque": instrument(gain="0.3 %", drift="0.01 N·m")}
    rig = {f: 0.9 + 0.02 * f + 0.004 * f**2 for f in frequencies}
    loaded, no_load = (
        run_of(
            *(recording(rig[f] + extra + scatter, f, load_n=load) for f in frequencies),
            instruments=sensors,
        )
        for extra, load in ((0.7, 1000.0), (0.0, 0.0))
    )
    result = analysed(loaded, no_load, spec(validate="monte_carlo"))
    content = document(result)
    validation = content["validation"]
    assert validation["method"] == "paper_peak"
    assert validation["equation"]["trials"] >= 1_000_000
    assert validation["pipeline"]["draws"] == 500
    assert content["analysis"]["validate"]["monte_carlo"]["draws"] == 500
    assert validation["equation"]["mean"]["gum"]["value"] == result.headline.value
    assert f"validation: {validation['statements'][0]}" in summary(content)
    assert document(analysed(loaded, no_load))["validation"] is None
