"""The effect of misaligned clocks on the starting torque, on both rig models.

Each recording's torque is shifted in time against its angle by an independent error. Within the
tolerance the stated interval covers the simulator's truth; beyond it the result would be wrong by
more than its U and is refused. The table of docs/evidence/clocks.md has more draws.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from helpers_rigs import true_starting_torque_nm
from helpers_thorough import first
from rigrunner_bearings.compensations.inverse import TemplateInverse
from rigrunner_bearings.compensations.settings import TemplateInverseSettings
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from rigrunner_bearings.torque.phase import ALIGNMENT, compensated
from unit.rigrunner_bearings.compensations.helpers_sweeps import sweep_of

FREQUENCIES = (5.0, 15.0, 25.0, 35.0)
METHOD = TemplateInverse(TemplateInverseSettings())
RIGS = pytest.mark.parametrize(
    "rig", first(1, [RigParameters(), OdeParameters()]), ids=["closed", "ode"]
)


def misaligned(points, u_s, rng):
    """Shift each point's torque in time by a normal error: a phase shift of each harmonic."""
    shifted = []
    for point in points:
        turn = 2 * np.pi * point.frequency_hz.value * u_s * rng.standard_normal()
        spectrum = np.fft.rfft(point.torque_nm, axis=-1)
        spectrum = spectrum * np.exp(-1j * turn * np.arange(spectrum.shape[-1]))
        torque = np.fft.irfft(spectrum, point.torque_nm.shape[-1], axis=-1)
        shifted.append(replace(point, torque_nm=torque, alignment_u_s=u_s))
    return tuple(shifted)


def misaligned_sweep(rig, u_s):
    rng = np.random.default_rng(4)
    sweep = sweep_of(rig, FREQUENCIES, 1)
    loaded, no_load = (misaligned(run, u_s, rng) for run in (sweep.loaded, sweep.no_load))
    return replace(sweep, loaded=loaded, no_load=no_load)


def errors_nm(rig, points):
    truths = [true_starting_torque_nm(rig, 1000.0, point.set_frequency_hz) for point in points]
    return np.array([point.torque.value for point in points]) - truths


@RIGS
def test_interval_covers_truth_within_tolerance(rig):
    compensation = compensated(METHOD, misaligned_sweep(rig, 15e-6))
    assert compensation.not_applicable == ""
    u_nm = np.array([point.torque.u for point in compensation.points])
    assert np.all(np.abs(errors_nm(rig, compensation.points)) <= 2 * u_nm)
    assert all(any(c.name == ALIGNMENT for c in p.components) for p in compensation.points)


@RIGS
def test_wrong_result_beyond_tolerance_is_refused(rig):
    bad = misaligned_sweep(rig, 500e-6)
    compensation = compensated(METHOD, bad)
    assert "two clocks, aligned to 0.5 ms" in compensation.not_applicable
    assert compensation.points == ()
    unaware = METHOD(bad)
    u_nm = np.array([point.torque.u for point in unaware.points])
    assert np.any(np.abs(errors_nm(rig, unaware.points)) > 2 * u_nm)
