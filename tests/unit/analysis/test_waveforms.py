from __future__ import annotations

import numpy as np
import pytest

from helpers_analysis import recording, run_of, spec
from helpers_long import short_blocks
from rigrunner.analysis import waveforms
from rigrunner.analysis.checks import run_checks
from rigrunner.analysis.prepare import prepare_point
from rigrunner.api.analysis import Rejection
from rigrunner.signal.swings import kept_cycles


def keep_all(values):  # noqa: ARG001  (a rule takes values)
    return []


def prepared(cycles=40):
    peaks = 0.9 + 0.01 * np.random.default_rng(2).standard_normal(cycles)
    made = recording(peaks)
    return prepare_point(made, run_of(made), spec(), keep_all), made


def test_a_long_recording_gives_what_it_gives_in_memory(monkeypatch):
    whole, made = prepared()
    whole_checks = list(run_checks(run_of(made), (whole,)))
    short_blocks(monkeypatch)
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
