from dataclasses import replace

import numpy as np
import pytest

from helpers_rigs import INSTRUMENT
from helpers_thorough import first
from rigrunner.api.errors import DataError
from rigrunner_bearings.compensations import identification
from rigrunner_bearings.compensations.bearing import mean_swing
from rigrunner_bearings.compensations.drive_line import DriveLine
from rigrunner_bearings.compensations.harmonics import observe
from rigrunner_bearings.compensations.identification import (
    identify,
    identify_again,
    vector,
    with_vector,
)
from rigrunner_bearings.compensations.model_template import no_load_model
from rigrunner_bearings.compensations.swing import make_swing, measured_ratio
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import prepared


def identified(parameters, seed=0):
    points = prepared(parameters, 0.0, seed=seed)
    return identify(points, make_swing(measured_ratio(points)), INSTRUMENT.low_pass)


@pytest.mark.parametrize("natural_hz", first(1, [200.0, 400.0, 800.0]))
@pytest.mark.parametrize(
    ("model", "share"), [(RigParameters, 0.0), (OdeParameters, 1.0)], ids=["closed form", "ode"]
)
def test_identifies_rig_and_where_friction_acts(model, share, natural_hz):
    """On the closed form friction follows the drive, on the ODE the load: by construction."""
    rig = model(natural_hz=natural_hz)
    learned = identified(rig)
    u = np.sqrt(np.diag(learned.covariance))
    assert learned.line.natural_hz == pytest.approx(natural_hz, rel=0.005)
    assert learned.line.damping_ratio == pytest.approx(rig.damping_ratio, abs=0.015)
    gain = rig.sensors.gain_limit
    assert learned.line.inertia_kgm2 == pytest.approx(rig.inertia_kgm2, rel=gain + 0.001)
    assert learned.line.share == pytest.approx(share, abs=3.5 * u[3])
    assert learned.line.delay_s == pytest.approx(0, abs=2e-5)
    assert learned.misfit < 1.5


def test_identifies_delay():
    sensors = replace(RigParameters().sensors, torque_delay_s=2e-4)
    learned = identified(RigParameters(sensors=sensors))
    assert learned.line.delay_s == pytest.approx(2e-4, abs=1e-5)
    assert learned.line.share == pytest.approx(0, abs=0.15)


def test_friction_level_is_that_of_support():
    slow_nm = identified(RigParameters()).friction.slow_nm
    assert np.median(np.abs(slow_nm)) == pytest.approx(0.7597, rel=0.05)


def test_unexplained_torque_has_zero_mean():
    """The mean is friction, and belongs to the friction of the model."""
    points = prepared(RigParameters(), 0.0)
    rig = identify(points, make_swing(measured_ratio(points)), INSTRUMENT.low_pass)
    unexplained_nm = no_load_model(points, rig).unexplained_nm
    assert unexplained_nm.shape[0] == len(points)
    assert np.abs(unexplained_nm).max() > 0
    np.testing.assert_allclose(unexplained_nm.mean(axis=1), 0.0, atol=1e-12)


def test_line_is_most_certain_at_weighted_mean_frequency():
    """Draper and Smith, Applied Regression Analysis, 3rd ed., 1.4: the variance is least there."""
    hertz, weight = np.array([1.0, 5.0, 10.0, 35.0]), np.array([1.0, 2.0, 2.0, 1.0])
    line = weight[:, None] * np.column_stack([np.ones(4), hertz])
    basis = np.stack([line, 3 * line]).astype(complex)
    expected = np.average(hertz, weights=weight**2)
    assert identification._best_known_hz(basis) == pytest.approx(expected)


def test_fast_misfit_equals_sum_of_squared_residuals():
    points = prepared(RigParameters(), 0.0)
    observed = observe(points, make_swing(measured_ratio(points)))
    weight = observed.weight.copy()
    weight[:, 60:] = 0.0  # harmonics that occur at no, at one and at two frequencies
    weight[:-1, 59] = weight[2:, 58] = 0.0
    observed = replace(observed, weight=weight)
    lines = [
        DriveLine(hertz, damping, 2e-3, 0.0, 0.0, INSTRUMENT.low_pass)
        for hertz in (60.0, 400.0, 2500.0)
        for damping in (0.02, 0.15)
    ]
    hertz, inertial_nm = observed.harmonic_hz, identification.inertial_torque(observed, lines[0])
    misfits = identification._misfit(
        observed, np.array([x.sensor(hertz) for x in lines]), inertial_nm
    )
    nothing = np.zeros_like(observed.harmonics)
    expected = [np.sum(identification._residual(observed, x, nothing)[:-1] ** 2) for x in lines]
    np.testing.assert_allclose(misfits, expected, rtol=1e-9)


@pytest.mark.parametrize("delay_s", [0.0, 3e-4])
def test_repeated_identification_gives_same_rig(delay_s):
    sensors = replace(RigParameters().sensors, torque_delay_s=delay_s)
    points = prepared(RigParameters(sensors=sensors), 0.0)
    swing = make_swing(measured_ratio(points))
    rig = identify(points, swing, INSTRUMENT.low_pass)
    repeated = identify_again(points, swing, INSTRUMENT.low_pass, rig)
    assert bool(rig.line.delay_s) == bool(delay_s)
    assert repeated.line == rig.line
    np.testing.assert_array_equal(repeated.friction.slow_nm, rig.friction.slow_nm)


def test_predicts_torque_at_unrecorded_frequency():
    points = prepared(RigParameters(), 0.0)
    (left_out,) = (point for point in points if point.set_frequency_hz == 15.0)
    others = tuple(point for point in points if point is not left_out)
    rig = identify(others, make_swing(measured_ratio(others)), INSTRUMENT.low_pass)
    template = no_load_model(others, rig).template(15.0)
    recorded = mean_swing(left_out, len(template.torque_nm))
    assert np.abs(recorded.torque_nm).max() > 1.5
    np.testing.assert_allclose(template.torque_nm, recorded.torque_nm, atol=0.04)


def test_refuses_too_few_frequencies():
    points = prepared(RigParameters(), 0.0, (1.0, 10.0, 35.0))
    with pytest.raises(DataError, match="has 3 frequencies, but 4 are needed"):
        identify(points, make_swing(2 / 45), INSTRUMENT.low_pass)


@pytest.mark.parametrize(
    ("noise_nm", "message"),
    [
        (0.0, "at 1 Hz, 10 Hz, 20 Hz, 35 Hz is the same in all cycles"),
        (0.005, "nothing in it but noise"),
    ],
)
def test_refuses_constant_or_pure_noise_signal(noise_nm, message):
    rng = np.random.default_rng(7)
    points = tuple(
        replace(point, torque_nm=rng.normal(0.0003, noise_nm, point.torque_nm.shape))
        for point in prepared(RigParameters(), 0.0, (1.0, 10.0, 20.0, 35.0))
    )
    with pytest.raises(DataError, match=message) as caught:
        identify(points, make_swing(2 / 45), INSTRUMENT.low_pass)
    assert "sensor connected" in caught.value.hint


def test_vector_round_trips():
    line = identified(RigParameters()).line
    changed = with_vector(line, vector(line) * 2)
    np.testing.assert_allclose(vector(changed), 2 * vector(line))
