from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner_bearings.api.compensations import Sweep
from rigrunner_bearings.api.points import MotionSource, PeakPoint
from rigrunner_bearings.compensations.peak_budget import ENTERED, SAME_PHASE, SINGLE_VALUES
from rigrunner_bearings.compensations.peak_same_frequency import PeakSameFrequency
from rigrunner_bearings.compensations.settings import PeakSameFrequencySettings
from unit.analysis.helpers_analysis import RIG, instrument, swing_point

WIGGLE = np.array([-0.02, 0.01, 0.0, 0.02, -0.01])
"""Standard deviation 0.0158 N·m."""
LOADED = {10.0: 2.1, 20.0: 3.6, 30.0: 6.0}
NO_LOAD = {10.0: 1.5, 20.0: 2.9, 30.0: 5.1}


def points(peaks, load_n, **changes):
    return tuple(
        replace(swing_point(peak + WIGGLE, hertz, load_n=load_n), **changes)
        for hertz, peak in peaks.items()
    )


def compensate(loaded, no_load, tool=None, **settings):
    method = PeakSameFrequency(PeakSameFrequencySettings.model_validate(settings))
    return method(Sweep(loaded, no_load, RIG, tool or instrument(), lambda _: None))


def part(point, name):
    return next(component for component in point.components if component.name == name)


def test_torque_is_difference_of_mean_peaks():
    compensation = compensate(points(LOADED, 1000.0), points(NO_LOAD, 0.0)[::-1])
    assert [p.torque.value for p in compensation.points] == pytest.approx([0.6, 0.7, 0.9])
    assert [p.raw_nm for p in compensation.points] == pytest.approx([2.1, 3.6, 6.0])
    assert [p.rig_nm for p in compensation.points] == pytest.approx([1.5, 2.9, 5.1])


def test_rejected_peaks_do_not_count():
    loaded = swing_point([2.1, 2.1, 2.1, 9.9], 10.0)
    loaded = replace(loaded, peak_kept=np.array([True, True, True, False]))
    compensation = compensate((loaded,), (swing_point([1.5, 1.5, 1.5], 10.0),))
    assert compensation.points[0].torque.value == pytest.approx(0.6)


def test_scatter_of_both_runs_is_in_budget():
    (point,) = compensate(points({10.0: 2.1}, 1000.0), points({10.0: 1.5}, 0.0)).points
    u_mean = np.std(WIGGLE, ddof=1) / np.sqrt(5)
    assert part(point, "scatter between cycles, loaded").u == pytest.approx(u_mean)
    assert part(point, "scatter between cycles, no load").u == pytest.approx(u_mean)
    load = part(point, "load").u
    assert load == pytest.approx(0.6 * 0.005 / np.sqrt(3), rel=1e-4)
    assert point.torque.u == pytest.approx(np.sqrt(2 * u_mean**2 + load**2))
    assert point.torque.dof == pytest.approx(point.torque.u**4 / (2 * u_mean**4 / 4))


def test_gain_acts_on_difference_and_each_run_drifts():
    tool = instrument(gain="0.3 %", drift="0.02 N·m", nonlinearity="0.05 %")
    (point,) = compensate(points({10.0: 2.1}, 1000.0), points({10.0: 1.5}, 0.0), tool).points
    assert part(point, "sensor gain").u == pytest.approx(0.003 * 0.6 / np.sqrt(3), rel=1e-4)
    assert part(point, "zero drift").u == pytest.approx(0.02 / np.sqrt(3) * np.sqrt(2))
    assert part(point, "sensor non-linearity").u == pytest.approx(0.005 / np.sqrt(3))


def test_frequency_uncertainty_scales_with_no_load_slope():
    motion = {"motion": MotionSource.ENTERED}
    loaded = replace(points(LOADED, 1000.0, **motion)[2], frequency_hz=Estimate(30.0, 0.03, np.inf))
    bare = points(NO_LOAD, 0.0, **motion)
    no_load = (*bare[:2], replace(bare[2], frequency_hz=Estimate(30.0, 0.04, np.inf)))
    (point,) = (compensation := compensate((loaded,), no_load)).points
    # 2.2 N·m per 10 Hz, and both frequencies are uncertain
    assert part(point, "frequency").u == pytest.approx(0.22 * 0.05)
    assert ENTERED in compensation.notes


def test_frequency_mismatch_is_in_budget():
    (point,) = compensate(points({20.1: 3.6}, 1000.0), points(NO_LOAD, 0.0)).points
    assert part(point, "frequency").u == pytest.approx(0.14 * 0.1 / np.sqrt(3))


def test_slope_from_one_no_load_point_is_that_of_inertia():
    (point,) = compensate(points({10.05: 2.1}, 1000.0), points({10.0: 1.5}, 0.0)).points
    assert part(point, "frequency").u == pytest.approx(2 * 1.5 / 10 * 0.05 / np.sqrt(3))


def test_frequency_without_partner_is_refused():
    with pytest.raises(DataError, match=r"no no-load recording within 1\.0% of 30 Hz"):
        compensate(points(LOADED, 1000.0), points({10.0: 1.5, 20.0: 2.9}, 0.0))
    with pytest.raises(DataError, match="no points"):
        compensate(points(LOADED, 1000.0), ())


def test_single_values_have_unknown_uncertainty():
    def single(hertz, value, load_n):
        return PeakPoint(
            recording=f"{hertz} Hz",
            set_frequency_hz=hertz,
            frequency_hz=Estimate(hertz, 0.0, np.inf, "Hz"),
            load_n=load_n,
            peak_nm=np.array([value]),
            peak_kept=np.ones(1, bool),
            motion=MotionSource.ENTERED,
        )

    compensation = compensate((single(10.0, 2.16, 1000.0),), (single(10.0, 1.64, 0.0),))
    assert compensation.points[0].torque.value == pytest.approx(0.52)
    assert SINGLE_VALUES in compensation.notes
    assert SAME_PHASE in compensation.notes
    assert np.isnan(compensation.points[0].torque.u)
    assert np.isnan(part(compensation.points[0], "scatter between cycles, loaded").u)
    assert part(compensation.points[0], "load").u > 0
