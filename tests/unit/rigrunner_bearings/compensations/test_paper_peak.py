from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner_bearings.api.compensations import Sweep
from rigrunner_bearings.compensations.paper_peak import MEASURAND, OTHER_RIG, PaperPeak
from rigrunner_bearings.compensations.peak_budget import SAME_PHASE
from rigrunner_bearings.compensations.settings import PaperPeakSettings
from rigrunner_plugins.fits.polynomial import PolynomialFit
from rigrunner_plugins.fits.settings import PolynomialSettings
from unit.analysis.helpers_analysis import RIG, instrument, swing_point

FIT = PolynomialFit(PolynomialSettings())
PLUS_MINUS = np.array([0.01, -0.01] * 5)


def compensated(loaded, no_load=(), sensor=None, coefficients="refit"):
    sweep = Sweep(tuple(loaded), tuple(no_load), RIG, sensor or instrument(), FIT)
    return PaperPeak(PaperPeakSettings(coefficients=coefficients))(sweep)


def parts(point):
    return {component.name: component for component in point.components}


def quadratic_no_load():
    return [swing_point(1 + 0.004 * f**2 + PLUS_MINUS, f) for f in (1.0, 10.0, 20.0, 30.0, 35.0)]


def test_refit_takes_rig_part_from_no_load_peaks():
    outcome = compensated([swing_point(1.7 + 0.9 + PLUS_MINUS, 15.0)], quadratic_no_load())
    (point,) = outcome.points
    assert point.raw_nm == pytest.approx(2.6)
    assert point.rig_nm == pytest.approx(1.9)
    assert point.torque.value == pytest.approx(0.7)
    assert outcome.curve.coefficients == pytest.approx([1, 0, 0.004], abs=1e-12)
    assert outcome.measurand == MEASURAND
    assert SAME_PHASE in outcome.notes
    assert OTHER_RIG not in outcome.notes


def test_published_coefficients_need_no_no_load_run():
    """Eq. (1) at 10 Hz is 0.41 + 0.247 + 0.9173 = 1.5743; Table 1 has 2.16 there."""
    outcome = compensated([swing_point(2.16 + PLUS_MINUS, 10.0)], coefficients="published")
    assert outcome.points[0].torque.value == pytest.approx(2.16 - 1.5743, abs=1e-12)
    assert OTHER_RIG in outcome.notes


def test_published_curve_is_refused_above_35_hz():
    with pytest.raises(DataError, match="holds from 1 to 35, not at 40"):
        compensated([swing_point([5.0, 5.1, 5.0], 40.0)], coefficients="published")


def test_rejected_peaks_do_not_count():
    peaks = np.array([2.0, 2.0, 9.0])
    point = swing_point(peaks, 10.0)
    point.peak_kept[2] = False
    assert compensated([point], coefficients="published").points[0].raw_nm == 2.0


def test_refit_without_no_load_run_suggests_published_coefficients():
    with pytest.raises(DataError, match="needs a no-load run") as caught:
        compensated([swing_point([2.0, 2.1], 10.0)])
    assert "coefficients: published" in caught.value.hint


def test_scatter_is_standard_error_of_mean_peak():
    lines = parts(compensated([swing_point(2 + PLUS_MINUS, 15.0)], quadratic_no_load()).points[0])
    scatter = lines["scatter between cycles"]
    assert scatter.u == pytest.approx(0.01 * np.sqrt(10 / 9) / np.sqrt(10))
    assert scatter.dof == 9
    assert not scatter.common


def test_sensor_errors_act_on_difference_if_both_runs_are_measured():
    sensor = instrument(gain="1 %", drift="0.03 N·m")
    loaded = [swing_point(2.6 + PLUS_MINUS, 15.0)]
    refit = parts(compensated(loaded, quadratic_no_load(), sensor).points[0])
    published = parts(compensated(loaded, (), sensor, "published").points[0])
    assert refit["sensor gain"].u == pytest.approx(0.01 * 0.7 / np.sqrt(3), rel=1e-4)
    assert published["sensor gain"].u == pytest.approx(0.01 * 2.6 / np.sqrt(3))
    assert refit["zero drift"].u == pytest.approx(0.03 * np.sqrt(2 / 3))
    assert published["zero drift"].u == pytest.approx(0.03 / np.sqrt(3))
    assert refit["sensor gain"].common
    assert refit["zero drift"].common


def test_frequency_uncertainty_scales_with_slope_of_curve():
    """The slope of eq. (1) at 20 Hz is 0.0247 + 2 * 0.0041 * 20 = 0.1887 N·m/Hz."""
    point = replace(swing_point(4.3 + PLUS_MINUS, 20.0), frequency_hz=Estimate(20.0, 0.05, inf))
    lines = parts(compensated([point], coefficients="published").points[0])
    assert lines["frequency"].u == pytest.approx(0.1887 * 0.05)
    assert not lines["frequency"].common


def test_slope_at_end_of_curve_is_taken_inside_its_range():
    point = replace(swing_point(7.6 + PLUS_MINUS, 35.0), frequency_hz=Estimate(35.0, 0.05, inf))
    lines = parts(compensated([point], coefficients="published").points[0])
    assert lines["frequency"].u == pytest.approx((0.0247 + 2 * 0.0041 * 35) * 0.05, rel=1e-3)
