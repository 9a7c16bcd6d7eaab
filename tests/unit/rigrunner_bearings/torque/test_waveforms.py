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
    made = recording(peaks)
    return prepare_point(made, run_of(made), spec(), keep_all), made


def test_a_long_recording_gives_what_it_gives_in_memory(monkeypatch):
    whole, made = prepared()
    whole_checks = list(run_checks(run_of(made), (whole,)))
    short_cycles(monkeypatch)
    found, _ = prepared()
    np.testing.assert_array_equal(found.peak_nm, whole.peak_nm)
    np.testing.assert_allclose(found.torque_nm, whole.torque_nm, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.angle_rad, whole.angle_rad, rtol=0, atol=1e-12)
    assert found.frequency_hz.value == pytest.approx(whole.frequency_hz.value, rel=1e-12)
    assert list(run_checks(run_of(made), (found,))) == whole_checks


def test_neighbours_of_very_many_cycles_share_a_row(monkeypatch):
    whole, _ = prepared()
    monkeypatch.setattr(waveforms, "MOST_ROWS", 8)
    found, _ = prepared()
    cycles = whole.cycles
    row = np.arange(cycles) * 8 // cycles
    wanted = [whole.torque_nm[row == k].mean(axis=0) for k in range(8)]
    np.testing.assert_allclose(found.torque_nm, wanted, rtol=0, atol=1e-12)
    assert (len(found.kept), found.cycles, kept_cycles(found).sum()) == (8, cycles, cycles)
    np.testing.assert_allclose(found.angle_rad, whole.angle_rad, rtol=0, atol=1e-12)


def test_a_row_that_is_rejected_leaves_out_its_cycles_and_is_named_by_the_first(monkeypatch):
    def rejects_the_third(values):
        return [Rejection(2, float(values[2]), "test", 2.0, 1.0)] if len(values) == 8 else []

    monkeypatch.setattr(waveforms, "MOST_ROWS", 8)
    peaks = 0.9 + 0.01 * np.random.default_rng(2).standard_normal(40)
    made = recording(peaks)
    found = prepare_point(made, run_of(made), spec(), rejects_the_third)
    left_out = np.flatnonzero(~kept_cycles(found)).tolist()
    third = np.flatnonzero(np.arange(found.cycles) * 8 // found.cycles == 2)
    assert [each.index for each in found.waveform_rejections] == left_out[:1]
    assert left_out == third.tolist()


@pytest.mark.parametrize("cycles", [1024, 1025, 1500, 2049, 3100])
def test_rows_of_several_cycles_say_the_same_of_the_mean_as_its_cycles(cycles):
    period = 64
    turn = 2 * np.pi * np.arange(cycles * period + 1) / period
    noise = np.random.default_rng(cycles).standard_normal(len(turn))
    torque = np.sin(turn) + 0.1 * noise
    starts = period * np.arange(cycles + 1.0)
    every = resample(torque, starts, waveforms.PHASES)
    rows = waveforms.waveforms(torque, starts)
    assert len(rows) <= waveforms.MOST_ROWS
    found, wanted = (robust_mean(each, np.ones(len(each), bool)) for each in (rows, every))
    ratio = np.sqrt(np.mean(found[1] ** 2) / np.mean(wanted[1] ** 2))
    assert ratio == pytest.approx(1, abs=0.02)
    # The means differ by what a few samples at the border of the trusted ones do.
    np.testing.assert_allclose(found[0], wanted[0], rtol=0, atol=0.2 * wanted[1].mean())
    first_bins = np.bincount(waveforms.row_of(cycles))
    assert first_bins.max() - first_bins.min() <= 1


@pytest.mark.parametrize("cycles", [1, 5, 1024, 1025, 2048, 2049, 36_000, 10**6 + 1])
def test_a_row_of_fewer_cycles_is_rare(cycles):
    count = np.bincount(waveforms.row_of(cycles))
    assert len(count) == waveforms.rows_of(cycles) <= waveforms.MOST_ROWS
    assert (count < count.max()).sum() < count.max()


@pytest.mark.parametrize(("phi", "most"), [(0.0, 1.05), (0.6, 1.15), (0.9, 1.3)])
def test_rows_never_say_that_correlated_cycles_tell_more_than_they_do(phi, most):
    cycles, runs = 3000, 8
    noise = np.random.default_rng(4).standard_normal((runs, cycles + 500))
    drifting = lfilter([1.0], [1.0, -phi], noise, axis=1)[:, 500:]
    row = waveforms.row_of(cycles)
    means = np.array([np.bincount(row, each) / np.bincount(row) for each in drifting])
    found = np.mean([standard_error(each)[0] for each in means])
    # Var of the mean of a stationary AR(1) process: 1/(1 - phi)^2 / n for large n (Zhang 2006).
    true = 1 / (1 - phi) / np.sqrt(cycles)
    assert 0.95 < found / true < most
