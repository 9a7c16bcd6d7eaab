from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from helpers_long import short_cycles
from rigrunner.api.analysis import Rejection
from rigrunner.signal.averaging import robust_mean
from rigrunner.signal.repeatability import standard_error
from rigrunner_bearings.signal.cycles import resample
from rigrunner_bearings.signal.swings import kept_cycles
from rigrunner_bearings.torque import waveforms
from rigrunner_bearings.torque.checks import run_checks
from rigrunner_bearings.torque.prepare import prepare_point
from unit.analysis.helpers_analysis import recording, run_of, spec


def keep_all(values):  # noqa: ARG001  (a rule takes values)
    return []


def prepared(cycles=40):
    peaks = 0.9 + 0.01 * np.random.default_rng(2).standard_normal(cycles)
    source = recording(peaks)
    return prepare_point(source, run_of(source), spec(), keep_all), source


def test_recording_in_blocks_equals_one_in_memory(monkeypatch):
    in_memory, source = prepared()
    expected_checks = list(run_checks(run_of(source), (in_memory,)))
    short_cycles(monkeypatch)
    in_blocks, _ = prepared()
    np.testing.assert_array_equal(in_blocks.peak_nm, in_memory.peak_nm)
    np.testing.assert_allclose(in_blocks.torque_nm, in_memory.torque_nm, rtol=0, atol=1e-9)
    np.testing.assert_allclose(in_blocks.angle_rad, in_memory.angle_rad, rtol=0, atol=1e-12)
    assert in_blocks.frequency_hz.value == pytest.approx(in_memory.frequency_hz.value, rel=1e-12)
    assert list(run_checks(run_of(source), (in_blocks,))) == expected_checks


def test_neighbouring_cycles_share_a_row(monkeypatch):
    by_cycle, _ = prepared()
    monkeypatch.setattr(waveforms, "MOST_ROWS", 8)
    by_row, _ = prepared()
    cycles = by_cycle.cycles
    row = np.arange(cycles) * 8 // cycles
    expected = [by_cycle.torque_nm[row == k].mean(axis=0) for k in range(8)]
    np.testing.assert_allclose(by_row.torque_nm, expected, rtol=0, atol=1e-12)
    assert (len(by_row.kept), by_row.cycles, kept_cycles(by_row).sum()) == (8, cycles, cycles)
    np.testing.assert_allclose(by_row.angle_rad, by_cycle.angle_rad, rtol=0, atol=1e-12)


def test_rejected_row_removes_its_cycles_and_is_named_by_first(monkeypatch):
    def rejects_the_third(values):
        return [Rejection(2, float(values[2]), "test", 2.0, 1.0)] if len(values) == 8 else []

    monkeypatch.setattr(waveforms, "MOST_ROWS", 8)
    peaks = 0.9 + 0.01 * np.random.default_rng(2).standard_normal(40)
    source = recording(peaks)
    point = prepare_point(source, run_of(source), spec(), rejects_the_third)
    left_out = np.flatnonzero(~kept_cycles(point)).tolist()
    third = np.flatnonzero(np.arange(point.cycles) * 8 // point.cycles == 2)
    assert [rejection.index for rejection in point.waveform_rejections] == left_out[:1]
    assert left_out == third.tolist()


@pytest.mark.parametrize("cycles", [1024, 1025, 1500, 2049, 3100])
def test_rows_of_cycles_give_same_mean_as_single_cycles(cycles):
    period = 64
    turn = 2 * np.pi * np.arange(cycles * period + 1) / period
    noise = np.random.default_rng(cycles).standard_normal(len(turn))
    torque = np.sin(turn) + 0.1 * noise
    starts = period * np.arange(cycles + 1.0)
    cycle_means = resample(torque, starts, waveforms.PHASES)
    rows = waveforms.waveforms(torque, starts)
    assert len(rows) <= waveforms.MOST_ROWS
    of_rows, of_cycles = (
        robust_mean(means, np.ones(len(means), bool)) for means in (rows, cycle_means)
    )
    ratio = np.sqrt(np.mean(of_rows[1] ** 2) / np.mean(of_cycles[1] ** 2))
    assert ratio == pytest.approx(1, abs=0.02)
    # The means differ by the effect of a few samples at the border of the trusted range.
    np.testing.assert_allclose(of_rows[0], of_cycles[0], rtol=0, atol=0.2 * of_cycles[1].mean())
    first_bins = np.bincount(waveforms.row_of(cycles))
    assert first_bins.max() - first_bins.min() <= 1


@pytest.mark.parametrize("cycles", [1, 5, 1024, 1025, 2048, 2049, 36_000, 10**6 + 1])
def test_rows_with_fewer_cycles_are_rare(cycles):
    count = np.bincount(waveforms.row_of(cycles))
    assert len(count) == waveforms.rows_of(cycles) <= waveforms.MOST_ROWS
    assert (count < count.max()).sum() < count.max()


@pytest.mark.parametrize(("phi", "most"), [(0.0, 1.05), (0.6, 1.15), (0.9, 1.3)])
def test_rows_do_not_underestimate_error_of_correlated_cycles(phi, most):
    cycles, runs = 3000, 8
    noise = np.random.default_rng(4).standard_normal((runs, cycles + 500))
    drifting = lfilter([1.0], [1.0, -phi], noise, axis=1)[:, 500:]
    row = waveforms.row_of(cycles)
    means = np.array([np.bincount(row, run) / np.bincount(row) for run in drifting])
    estimated = np.mean([standard_error(mean)[0] for mean in means])
    # Var of the mean of a stationary AR(1) process: 1/(1 - phi)^2 / n for large n (Zhang 2006).
    true = 1 / (1 - phi) / np.sqrt(cycles)
    assert 0.95 < estimated / true < most
