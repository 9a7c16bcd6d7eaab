"""Deviation of the inertia from raw no-load peaks, as `inertia_physical` documents it."""

from __future__ import annotations

import numpy as np
import pytest

from helpers_rigs import IDEAL_SENSORS, run_data
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.analysis.helpers_analysis import analysed, no_load_spec


@pytest.mark.parametrize("inertia_kgm2", [0.002, 0.003])
@pytest.mark.parametrize(
    ("natural_hz", "low", "high"), [(300, 0.0, 0.3), (600, -0.08, 0.08), (800, -0.08, 0.08)]
)
def test_apparent_inertia_includes_ringing_of_drive_line(inertia_kgm2, natural_hz, low, high):
    rig = RigParameters(inertia_kgm2=inertia_kgm2, natural_hz=natural_hz, sensors=IDEAL_SENSORS)
    run = run_data(rig, 0, cycles=7)
    fits = {
        fit.name: fit
        for fit in TorqueDetails.of(analysed(run, None, no_load_spec(outliers=None))).fits
    }
    apparent = fits["inertia_physical"].curve.coefficients[2]
    assert low < apparent / inertia_kgm2 - 1 < high


def test_apparent_inertia_of_default_rig_is_an_eighth_too_large():
    """The standard uncertainty from the scatter about the curve does not cover this."""
    curve = TorqueDetails.of(analysed(run_data(RigParameters(), 0, seed=1))).fits[1].curve
    ratio = curve.coefficients[2] / RigParameters().inertia_kgm2
    assert ratio == pytest.approx(1.11, abs=0.03)
    assert np.sqrt(curve.covariance[2, 2]) < 0.03 * curve.coefficients[2]
