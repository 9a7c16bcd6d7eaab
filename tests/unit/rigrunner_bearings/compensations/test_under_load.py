"""Random rigs whose measuring chain or drive line differs in the loaded run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from helpers_rigs import INSTRUMENT
from helpers_rigs import RIG as DESCRIBED
from helpers_thorough import first
from rigrunner.signal.coverage import expanded
from rigrunner_bearings.api.compensations import Sweep
from rigrunner_bearings.compensations.identification import identify
from rigrunner_bearings.compensations.swing import make_swing, measured_ratio, spring_torque
from rigrunner_bearings.compensations.under_load import line_under_load
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import (
    compensate,
    errors_nm,
    no_fit,
    prepared,
    sweep_of,
)

FREQUENCIES = (1.0, 5.0, 10.0, 15.0, 20.0, 28.0, 35.0)


def rigs(*, stribeck=False):
    """Return two random rigs of each model, from a wide population."""
    rng = np.random.default_rng(5)
    drawn = []
    for model in (RigParameters, OdeParameters) * 2:
        torque, speed = rng.uniform(0.4, 1.0), rng.uniform(0.3, 0.8)
        law = {"stribeck": stribeck, "stribeck_speed_rad_s": speed}
        torques = (
            {"starting_torque_nm": torque / 0.9, "kinetic_torque_nm": torque}
            if model is RigParameters
            else {"kinetic_torque_nm": torque, "overshoot_nm": 0.25 * torque}
        )
        drawn.append(
            model(
                inertia_kgm2=rng.uniform(0.0015, 0.0025),
                natural_hz=rng.uniform(300, 400),
                damping_ratio=rng.uniform(0.03, 0.08),
                support_friction_nm=rng.uniform(0.5, 1.0),
                **torques,
                **law,
            )
        )
    return drawn


def changed_under_load(rig, **sensors):
    """Return both runs of a rig whose measuring chain differs in the loaded run."""
    changed = replace(rig, sensors=replace(rig.sensors, **sensors))
    loaded = prepared(changed, 1000.0, FREQUENCIES, seed=1)
    no_load = prepared(rig, 0.0, FREQUENCIES, seed=1)
    return Sweep(loaded, no_load, DESCRIBED, INSTRUMENT, no_fit)


def check_of(compensation, name="drive line under load"):
    return next(check for check in compensation.checks if check.name == name)


def identify_both(sweep):
    swing = make_swing(measured_ratio(sweep.no_load))
    rig = identify(sweep.no_load, swing, INSTRUMENT.low_pass)
    return rig, line_under_load(sweep.loaded, rig)


@pytest.mark.parametrize("rig", first(1, rigs()))
def test_delay_of_loaded_run_is_found(rig):
    _, line = identify_both(changed_under_load(rig, torque_delay_s=2e-4))
    assert line.line.delay_s == pytest.approx(2e-4, abs=4e-5)
    assert line.line.natural_hz == pytest.approx(rig.natural_hz, rel=0.03)


@pytest.mark.parametrize("rig", first(1, rigs()))
def test_delay_of_loaded_run_is_flagged_or_within_uncertainty(rig):
    """It looks like gain scatter and widens the uncertainty as that does."""
    compensation = compensate(changed_under_load(rig, torque_delay_s=2e-4))
    errors = errors_nm(rig, compensation)
    beyond = max(
        abs(e) / expanded(p.torque) for e, p in zip(errors, compensation.points, strict=True)
    )
    assert beyond < 1 or not check_of(compensation).ok


@pytest.mark.parametrize("rig", first(1, rigs()[:2]))
def test_changed_filter_of_loaded_run_is_flagged(rig):
    assert not check_of(compensate(changed_under_load(rig, low_pass_hz=400.0))).ok


@pytest.mark.parametrize("rig", first(1, [rigs()[0], *rigs(stribeck=True), rigs()[1]]))
def test_healthy_rig_passes_with_any_friction_law(rig):
    compensation = compensate(sweep_of(rig, FREQUENCIES))
    assert check_of(compensation).ok
    assert check_of(compensation).value < 0.7
    assert check_of(compensation, "torque that follows the angle").value < 4


@pytest.mark.thorough
def test_stated_effect_is_the_error_of_the_torque():
    rig = rigs()[0]
    sweep = changed_under_load(rig, low_pass_hz=400.0)
    compensation = compensate(sweep)
    errors = errors_nm(rig, compensation)
    effect_texts = [part.split(" N·m")[0] for part in check_of(compensation).text.split("; ")]
    effects = {
        float(hz.split(" Hz")[0]): float(nm)
        for hz, nm in (text.split(": ") for text in effect_texts)
    }
    for point, error in zip(compensation.points, errors, strict=True):
        if (effect := effects.get(round(point.frequency_hz))) is not None:
            assert error == pytest.approx(-effect, abs=max(0.4 * abs(effect), 0.012))
    assert effects


def test_too_few_frequencies_are_not_checked():
    compensation = compensate(sweep_of(RigParameters(), (5.0, 10.0, 20.0, 35.0)))
    assert check_of(compensation).text.startswith("not checked: too few frequencies to tell")


def test_slow_swings_do_not_show_drive_line():
    sweep = sweep_of(RigParameters(), (1.0, 2.0, 3.0, 4.0, 10.0, 20.0, 35.0))
    assert identify_both(sweep)[1] is None


@pytest.mark.parametrize("uncertainty", [{"phase_u_rad": 0.01}, {"alignment_u_s": 3e-5}])
def test_uncertain_phase_does_not_show_delay(uncertainty):
    """The position of an index pulse is uncertain by half a sample: that is in U."""
    sweep = sweep_of(RigParameters(), FREQUENCIES)
    uncertain = replace(sweep, loaded=tuple(replace(p, **uncertainty) for p in sweep.loaded))
    assert identify_both(sweep)[1] is not None
    assert identify_both(uncertain)[1] is None


def test_constant_torque_does_not_show_drive_line():
    sweep = sweep_of(RigParameters(), FREQUENCIES)
    dead = tuple(replace(p, torque_nm=np.full_like(p.torque_nm, 3.0)) for p in sweep.loaded)
    assert identify_both(replace(sweep, loaded=dead))[1] is None


@pytest.mark.parametrize("rig", first(1, rigs()[:2]))
@pytest.mark.parametrize("spring_nm", [-0.1, 0.1])
def test_spring_under_load_is_flagged(rig, spring_nm):
    sweep = sweep_of(rig, FREQUENCIES)
    pulled = tuple(
        replace(p, torque_nm=p.torque_nm + spring_nm * p.angle_rad / p.angle_rad.max())
        for p in sweep.loaded
    )
    compensation = compensate(replace(sweep, loaded=pulled))
    check = check_of(compensation, "torque that follows the angle")
    assert not check.ok
    assert float(check.text.split(" N·m")[0]) == pytest.approx(spring_nm, abs=0.03)
    assert np.mean(errors_nm(rig, compensation)) == pytest.approx(-spring_nm, rel=0.3)


def test_spring_is_distinguished_from_friction_and_offset():
    swing = make_swing(2 / 45)
    friction = np.sign(swing.velocity_per_hz)
    spring = swing.angle_rad / np.abs(swing.angle_rad).max()
    assert spring_torque(swing, 0.7 * friction + 0.2 - 0.05 * spring) == pytest.approx(-0.05)
