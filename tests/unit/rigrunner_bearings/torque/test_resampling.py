"""Effects of a Monte Carlo draw on the prepared data, against the limits of the register."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner_bearings.api.compensations import Sweep
from rigrunner_bearings.torque.resampling import another_sensor, other_cycles
from unit.analysis.helpers_analysis import RIG, instrument, swing_point

PEAKS = np.array([2.0, 2.2, 1.8, 2.4, 1.6])


def sweep_of(**accuracy):
    loaded, no_load = swing_point(PEAKS, 10.0), swing_point(PEAKS / 2, 10.0)
    return Sweep((loaded,), (no_load,), RIG, instrument(**accuracy), None)


def peaks(sweep):
    return np.array([sweep.loaded[0].peak_nm, sweep.no_load[0].peak_nm])


def drawn(sweep, count=2000, *, zeroed=True):
    rng = np.random.default_rng(5)
    return [another_sensor(sweep, rng, zeroed=zeroed) for _ in range(count)]


def test_gain_is_common_to_both_runs_and_rectangular():
    sweep = sweep_of(gain="1 %")
    ratios = np.array([peaks(draw) / peaks(sweep) for draw in drawn(sweep)])
    assert np.ptp(ratios, axis=(1, 2)) == pytest.approx(0.0, abs=1e-12)
    assert ratios[:, 0, 0].std() == pytest.approx(0.01 / np.sqrt(3), rel=0.05)
    assert abs(ratios - 1).max() <= 0.01


def test_offset_is_common_to_both_runs_and_removed_by_zero():
    sweep = sweep_of(offset="0.3 N·m")
    shifts = np.array([peaks(draw) - peaks(sweep) for draw in drawn(sweep, zeroed=False)])
    assert np.ptp(shifts, axis=(1, 2)) == pytest.approx(0.0, abs=1e-12)
    assert shifts[:, 0, 0].std() == pytest.approx(0.3 / np.sqrt(3), rel=0.05)
    assert peaks(drawn(sweep, 1)[0]) == pytest.approx(peaks(sweep))


def test_each_run_drifts_independently():
    sweep = sweep_of(drift="0.02 N·m")
    shifts = np.array([peaks(draw) - peaks(sweep) for draw in drawn(sweep)]).mean(axis=2)
    assert shifts.std(axis=0) == pytest.approx([0.02 / np.sqrt(3)] * 2, rel=0.05)
    assert abs(np.corrcoef(shifts.T)[0, 1]) < 0.1


def test_drift_is_linear_over_cycles():
    sweep = sweep_of(drift="0.02 N·m")
    (changed,) = drawn(sweep, 1)
    course = (changed.loaded[0].torque_nm - sweep.loaded[0].torque_nm).ravel()
    assert np.diff(course) == pytest.approx(np.diff(course)[0])
    assert abs(course[-1] - course[0]) > 0


def test_nonlinearity_is_a_parabola_with_stated_maximum():
    sweep = sweep_of(nonlinearity="0.5 %", full_scale="4 N·m")
    errors = np.array([peaks(draw)[0] - PEAKS for draw in drawn(sweep)])
    assert abs(errors[:, 0]).max() == pytest.approx(0.005 * 4, rel=0.01)  # 2 N·m: half of it
    share = PEAKS / 4
    parabola = 4 * share * (1 - share)
    assert errors / errors[:, :1] == pytest.approx(np.tile(parabola, (2000, 1)))


def test_mean_of_redrawn_cycles_has_type_a_scatter():
    rng = np.random.default_rng(5)
    sweep = sweep_of()
    means = [other_cycles(sweep, rng).loaded[0].peak_nm.mean() for _ in range(4000)]
    assert np.std(means) == pytest.approx(PEAKS.std(ddof=1) / np.sqrt(5), rel=0.05)
    assert np.mean(means) == pytest.approx(PEAKS.mean(), abs=0.01)


def test_rejected_cycles_are_never_drawn_and_single_value_stays():
    rng = np.random.default_rng(5)
    kept = np.array([True, True, True, True, False])
    sweep = sweep_of()
    point = replace(sweep.loaded[0], peak_nm=np.array([1.0, 1, 1, 1, 9]), peak_kept=kept)
    redrawn = other_cycles(replace(sweep, loaded=(point,)), rng).loaded[0]
    assert redrawn.peak_nm.tolist() == [1.0] * 4
    single = replace(point, peak_nm=np.array([2.0]), peak_kept=np.ones(1, bool))
    assert other_cycles(replace(sweep, loaded=(single,)), rng).loaded[0].peak_nm == [2.0]
