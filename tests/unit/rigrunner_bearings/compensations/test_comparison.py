"""Differences between two runs other than the bearing: gains, inertia, hum, support friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.signal.coverage import expanded
from rigrunner_bearings.compensations import hum
from rigrunner_bearings.compensations.comparison import LINE, comparable_runs
from rigrunner_bearings.compensations.inverse import TemplateInverse
from rigrunner_bearings.compensations.settings import TemplateInverseSettings
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import (
    compensate,
    errors_nm,
    prepared,
    sweep_of,
)

HERTZ = (3.0, 5.0, 8.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0)
RIG = RigParameters()
GAINS = 0.003 * np.array([1, -1, 0.5, 1, -0.3, -1, 1, -0.6, 1])
HUM_NM = 0.01


@pytest.fixture(scope="module")
def healthy():
    return sweep_of(RIG, HERTZ)


def scaled(sweep, gains):
    """Return a sweep whose loaded recordings have those relative errors of the gain."""
    loaded = (
        replace(point, torque_nm=(1 + gain) * point.torque_nm)
        for point, gain in zip(sweep.loaded, gains, strict=True)
    )
    return replace(sweep, loaded=tuple(loaded))


def comparison(sweep, **settings):
    chosen = TemplateInverseSettings.model_validate(settings)
    method = TemplateInverse(chosen)
    rig = method._identified_rig(sweep)
    return comparable_runs(rig, sweep, method.templates(sweep, rig), chosen)


def line_of(point, name):
    return next((part.u for part in point.components if part.name == name), 0.0)


def test_gain_scatter_is_found_at_high_frequencies(healthy):
    """0.3 % is 15 mN·m at 35 Hz; without scatter the method may be wrong by some 0.01 %."""
    gains = comparison(scaled(healthy, GAINS)).gains
    baseline = comparison(healthy).gains
    change = (gains.loaded - gains.no_load + gains.inertia) - (
        baseline.loaded - baseline.no_load + baseline.inertia
    )
    assert change[-4:] == pytest.approx(GAINS[-4:], abs=5e-4)
    assert baseline.scatter < gains.scatter


def test_gain_scatter_is_removed_and_residual_is_in_budget(healthy):
    outcome, plain = compensate(scaled(healthy, GAINS)), compensate(healthy)
    errors = errors_nm(RIG, outcome)
    inertial = 0.002324 * 1.7563 * np.array(HERTZ) ** 2
    assert np.abs(GAINS * inertial)[-1] > 0.014
    assert np.abs(errors)[-4:].max() < 0.009
    assert all(abs(e) < expanded(p.torque) for e, p in zip(errors, outcome.points, strict=True))
    assert line_of(outcome.points[-1], LINE) > line_of(plain.points[-1], LINE)


def test_inertia_change_is_distinguished_from_gain_scatter(healthy):
    changed = sweep_of(RigParameters(loaded_inertia_change=-0.02), HERTZ)
    assert comparison(changed).gains.inertia == pytest.approx(-0.02, abs=0.001)
    assert comparison(healthy).gains.inertia == pytest.approx(0, abs=0.001)


def test_single_frequency_can_be_compared(healthy):
    single = replace(healthy, loaded=healthy.loaded[-1:])
    gains = comparison(single).gains
    assert gains.loaded.shape == gains.no_load.shape == (1,)
    assert gains.covariance.shape == (3, 3)
    (point,) = compensate(single).points
    assert abs(errors_nm(RIG, compensate(single))[0]) < expanded(point.torque)


def with_hum(points, begins_turns):
    """Return the points with hum of 50.02 Hz; at 10 Hz it is greatest near the reversal."""
    result = []
    for point in points:
        count, size = point.torque_nm.shape
        turns = np.arange(count * size).reshape(count, size) / size
        phase = 2 * np.pi * (50.02 * turns / point.frequency_hz.value + begins_turns)
        result.append(replace(point, torque_nm=point.torque_nm + HUM_NM * np.sin(phase)))
    return tuple(result)


@pytest.mark.thorough
def test_hum_at_harmonic_of_swing_is_removed(healthy):
    """At 5, 10 and 25 Hz the mains are its tenth, fifth and second harmonic."""
    hums = replace(
        healthy, loaded=with_hum(healthy.loaded, 0.0), no_load=with_hum(healthy.no_load, 0.5)
    )
    plain = compensate(healthy)
    outcome = compensate(hums)
    elsewhere = compensate(hums, mains_frequency="61 Hz")
    corrected, uncorrected = (
        errors_nm(RIG, compensation) - errors_nm(RIG, plain)
        for compensation in (outcome, elsewhere)
    )
    locked = [HERTZ.index(hz) for hz in (5.0, 10.0, 25.0)]
    assert np.abs(uncorrected[locked]).max() > 0.012
    assert np.abs(corrected[locked]).max() < 0.0025
    has_hum = [line_of(point, "hum of the mains") > 0 for point in outcome.points]
    assert [hz for hz, hum in zip(HERTZ, has_hum, strict=True) if hum] == [5.0, 10.0, 25.0]


def test_nothing_is_removed_without_hum(healthy):
    assert not any(comparison(healthy).hum_nm)


@pytest.mark.thorough
def test_stated_growth_of_support_friction_is_removed():
    """3 % of 0.76 N·m under the load of 1000 N, 19 mN·m of it in the torque.

    Half of the possible effect of a growing slip, 6 mN·m, remains and is within U.
    """
    rig = RigParameters(support_growth_per_kn=0.03)
    sweep = replace(sweep_of(RIG, HERTZ), loaded=prepared(rig, 1000.0, HERTZ))
    described = sweep.rig.model_copy(
        update={"support_load_growth": 0.03, "support_load_dependence": 0.003}
    )
    wrong, right = compensate(sweep), compensate(replace(sweep, rig=described))
    assert errors_nm(rig, wrong).mean() > 0.012
    for error, point in zip(errors_nm(rig, right), right.points, strict=True):
        assert abs(error) < expanded(point.torque)
    assert abs(errors_nm(rig, right).mean()) < 0.0065


def test_result_is_stable_for_nearly_equal_set_points(healthy):
    """Four powers of one frequency would leave the running torque undetermined."""
    point = healthy.loaded[-1]

    def u_of(*digits):
        points = (
            replace(point, frequency_hz=replace(point.frequency_hz, value=35.0 + 1e-4 * digit))
            for digit in digits
        )
        covariance = comparison(replace(healthy, loaded=tuple(points))).gains.covariance
        return np.sqrt(np.diag(covariance))

    np.testing.assert_allclose(u_of(0, 1, 2), u_of(0, -2, 3), rtol=0.01)


@pytest.mark.parametrize("size", [1, 99, 100, 101, 1250])
def test_hum_power_equals_fourier_sum_over_all_cycles(size):
    values, hertz = np.random.default_rng(3).normal(size=(4, size)), np.array([49.8, 50.0, 50.1])
    at_s = np.arange(values.size) / 1000.0
    sums = np.exp(-2j * np.pi * hertz[:, None] * at_s) @ values.ravel()
    expected = np.abs(sums / values.size) ** 2
    assert hum._powers(values, 1000.0, hertz) == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_gains_do_not_depend_on_rounding(healthy):
    """Summation in another order changes a sum by 1e-15, and must not change the weights."""
    sweep = scaled(healthy, GAINS)
    rng = np.random.default_rng(20261129)
    rounded = [
        replace(point, torque_nm=point.torque_nm * (1 + 1e-15 * rng.standard_normal(
            point.torque_nm.shape)))
        for point in sweep.loaded
    ]  # fmt: skip
    one, other = (
        comparison(variant).gains for variant in (sweep, replace(sweep, loaded=tuple(rounded)))
    )
    u = np.sqrt(np.diag(one.covariance))
    assert (np.abs(other.loaded - one.loaded) / u[len(HERTZ) : -1]).max() < 1e-7
    assert np.sqrt(np.diag(other.covariance)) == pytest.approx(u, rel=1e-7)
