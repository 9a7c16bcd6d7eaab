"""Accuracy of the torque with five times the usual noise.

The maximum of a noisy curve is too high: without correction template_inverse reads 20 mN·m to
30 mN·m high from 30 Hz to 35 Hz on either rig model.
"""

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import compensate, errors_nm, sweep_of

HERTZ = (1.0, 5.0, 10.0, 20.0, 30.0, 35.0)
NOISE_NM = 0.1


@pytest.mark.thorough
@pytest.mark.parametrize("model", [RigParameters, OdeParameters], ids=["closed form", "ode"])
def test_noise_bias_of_maximum_is_corrected(model):
    parameters = model()
    parameters = replace(parameters, sensors=replace(parameters.sensors, noise_nm=NOISE_NM))
    outcomes = [compensate(sweep_of(parameters, HERTZ, seed)) for seed in range(3)]
    errors = np.array([errors_nm(parameters, outcome) for outcome in outcomes])
    expanded = np.array(
        [[coverage_factor(p.torque.dof) * p.torque.u for p in o.points] for o in outcomes]
    )
    assert abs(errors[:, 4:].mean()) < 0.014
    assert (np.abs(errors) <= expanded).mean() >= 0.95
    assert expanded[:, 5].min() > 2 * expanded[:, 1].max()
