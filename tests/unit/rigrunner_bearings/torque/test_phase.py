"""Uncertain phase, on a method with a known response to a shift."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation, Sweep
from rigrunner_bearings.signal.swings import with_swings
from rigrunner_bearings.torque.phase import COMMON, NOTE, OWN, compensated
from unit.analysis.helpers_analysis import RIG, instrument, swing_point

BASE = Component("scatter", 0.01, 9.0, "normal", common=False)


def first_sine_nm(point):
    """Return the first harmonic's sine part: linear in a small shift of a cosine."""
    mean = point.torque_nm.mean(axis=0)
    return -2 * np.fft.rfft(mean)[1].imag / len(mean)


def difference(sweep):
    """A method: the difference of the sine parts of both runs."""
    swings = with_swings(sweep)
    pairs = zip(swings.loaded, swings.no_load, strict=True)
    values = [first_sine_nm(loaded) - first_sine_nm(no_load) for loaded, no_load in pairs]
    return Compensation("sine", tuple(point_of(value) for value in values))


def peaks(sweep):
    values = [point.peak_nm.mean() for point in sweep.loaded]
    return Compensation("peak", tuple(point_of(value) for value in values))


def point_of(value):
    return CompensatedPoint(10.0, 10.0, value, 0.0, Estimate(value, BASE.u, BASE.dof), (BASE,))


def sweep_of(common=0.0, own=0.0):
    """Return a sweep of cos(phi), amplitude 3 loaded and 1 without load."""
    uncertainty = {"phase_common_u_rad": common, "phase_u_rad": own}
    loaded = replace(swing_point(np.full(6, 3.0), 10.0), **uncertainty)
    no_load = replace(swing_point(np.full(6, 1.0), 10.0, load_n=0.0), **uncertainty)
    return Sweep((loaded,), (no_load,), RIG, instrument(), lambda _: None)


def component(compensation, name):
    return next((c.u for c in compensation.points[0].components if c.name == name), None)


def test_angle_channel_adds_no_phase_uncertainty():
    compensation = compensated(difference, sweep_of())
    assert compensation.points[0].components == (BASE,)
    assert compensation.notes == ()


def test_common_error_moves_both_runs():
    compensation = compensated(difference, sweep_of(common=0.02))
    assert component(compensation, COMMON) == pytest.approx((3 - 1) * np.sin(0.02))
    assert component(compensation, OWN) is None
    assert NOTE in compensation.notes


@pytest.mark.parametrize("sign", [1, -1])
def test_larger_effect_of_early_and_late_counts(sign):
    def one_sided(varied_sweep):
        (point,) = difference(varied_sweep).points
        return Compensation("one-sided", (point_of(max(sign * point.torque.value, 0.0)),))

    compensation = compensated(one_sided, sweep_of(common=0.02))
    assert component(compensation, COMMON) == pytest.approx((3 - 1) * np.sin(0.02))


def test_independent_errors_of_both_runs_add_in_quadrature():
    compensation = compensated(difference, sweep_of(own=0.02))
    assert component(compensation, OWN) == pytest.approx(np.hypot(3, 1) * np.sin(0.02))
    assert component(compensation, COMMON) is None


def test_each_point_is_moved_by_its_own_error():
    single = sweep_of(own=0.02)
    several = replace(single, loaded=3 * single.loaded, no_load=3 * single.no_load)
    compensation = compensated(difference, several)
    u_own = [c.u for point in compensation.points for c in point.components if c.name == OWN]
    assert u_own == pytest.approx([np.hypot(3, 1) * np.sin(0.02)] * 3)


def test_combined_uncertainty_includes_phase():
    point = compensated(difference, sweep_of(common=0.02, own=0.01)).points[0]
    parts = [BASE.u, 2 * np.sin(0.02), np.sqrt(10) * np.sin(0.01)]
    assert point.torque.u == pytest.approx(np.sqrt(np.sum(np.square(parts))))
    assert point.torque.dof > BASE.dof
    assert [part.common for part in point.components] == [False, True, False]


def test_peak_methods_are_unaffected():
    compensation = compensated(peaks, sweep_of(common=0.02, own=0.01))
    assert compensation.points[0].components == (BASE,)
    assert compensation.notes == ()
