import numpy as np
import pytest

from rigrunner.api.data import Estimate
from rigrunner_bearings.api.compensations import CompensatedPoint
from rigrunner_bearings.compensations.checks import (
    coupling,
    delay,
    drive_line,
    independent_cycles,
    no_growth,
    positive,
    same_inertia,
    symmetry,
)
from rigrunner_bearings.compensations.effects import BySpeed, Mismatch

FREQUENCIES = np.array([1, 5, 10, 15, 20, 25, 30, 35])


def points(torques):
    return [
        CompensatedPoint(f, f, 5.0, 4.0, Estimate(torque, 0.005), ())
        for f, torque in zip(FREQUENCIES, torques, strict=True)
    ]


def mismatches(values, u):
    """Return the part of each torque that follows the acceleration; the rig's is 5 N·m at 35 Hz."""
    inertial = 5.0 * (FREQUENCIES / 35.0) ** 2
    return [
        Mismatch(value, u_point, rig_nm, rig_nm + 1.0)
        for value, u_point, rig_nm in zip(values, u, inertial, strict=True)
    ]


def test_changed_inertia_is_detected_and_moves_fast_points():
    rng = np.random.default_rng(1)
    u = np.full(8, 0.003)
    flat = 0.003 * rng.standard_normal(8)
    assert same_inertia(points([0.7] * 8), mismatches(flat, u)).ok
    check = same_inertia(points([0.7] * 8), mismatches(flat + 0.02, u))
    assert not check.ok
    assert check.text.startswith("+2.")
    fast = check.biases[-1]
    assert fast.value == pytest.approx(0.02 * 5.5, rel=0.15), "of inertia 0.10, of gain 0.12 N·m"
    assert abs(check.biases[0].value) < 0.02


def test_scattered_gains_move_each_point_separately():
    scatter = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.01, -0.01])
    check = same_inertia(points([0.7] * 8), mismatches(scatter, np.full(8, 0.0005)))
    assert not check.ok
    assert check.biases[-1].value == pytest.approx(-0.055, rel=0.05)
    assert check.biases[-2].value == pytest.approx(0.01 * (2 * 3.67 + 1) / 2, rel=0.05)


def test_false_alarm_rate_is_as_stated():
    rng = np.random.default_rng(2)
    u = np.full(8, 0.02)
    alarms = sum(
        not same_inertia(points([0.7] * 8), mismatches(0.02 * rng.standard_normal(8), u)).ok
        for _ in range(400)
    )
    assert alarms <= 16, "2 % of 400, for two tests, and what chance may add"


def test_two_frequencies_are_not_checked():
    check = same_inertia(points([0.7] * 8)[:2], mismatches([0.0] * 8, [0.01] * 8)[:2])
    assert check.ok
    assert check.text == "not checked: too few frequencies to tell"


def under_way(torques):
    return [BySpeed(torque, 1.2) for torque in torques]


def test_growth_check_flags_viscous_support_but_not_falling_friction():
    rng = np.random.default_rng(4)
    noise = 0.005 * rng.standard_normal(8)
    falling = 0.9 - 0.004 * FREQUENCIES + noise
    assert no_growth(points(falling), under_way(falling)).ok
    growing = 0.7 + 0.005 * FREQUENCIES + noise
    check = no_growth(points(growing), under_way(growing))
    assert not check.ok
    assert check.biases[-1].value == pytest.approx(0.005 * 35, rel=0.4)


def test_zero_or_negative_torque_is_flagged():
    check = positive(points([0.7, 0.0, 0.7, 0.7, 0.7, 0.7, 0.7, -0.1]), [0.6] * 8)
    assert not check.ok
    assert check.text == "5 Hz: 0.000 N·m; 35 Hz: -0.100 N·m"
    assert positive(points([0.7] * 8), [0.6] * 8).ok


@pytest.mark.parametrize(("asymmetry", "ok"), [(0.04, True), (-0.06, False)])
def test_asymmetry_of_either_sign_is_flagged(asymmetry, ok):
    assert symmetry(points([0.7] * 8), [asymmetry] + [0.0] * 7).ok is ok


@pytest.mark.parametrize(("misfit", "ok"), [(0.8, True), (1.2, False)])
def test_large_misfit_is_flagged(misfit, ok):
    assert drive_line(misfit, ()).ok is ok


@pytest.mark.parametrize(("natural_hz", "ok"), [(380.0, True), (361.0, True), (359.0, False)])
def test_lowered_resonance_means_loose_coupling(natural_hz, ok):
    check = coupling(natural_hz, 400.0)
    assert check.ok is ok
    assert check.value == pytest.approx(natural_hz / 4)
    assert bool(check.advice) is not ok


def test_coupling_is_not_checked_without_stated_resonance():
    check = coupling(300.0, None)
    assert check.ok
    assert "natural_frequency" in check.text


@pytest.mark.parametrize(("delay_s", "ok"), [(1e-4, True), (-1.6e-4, False), (2e-4, False)])
def test_large_delay_is_flagged(delay_s, ok):
    assert delay(delay_s).ok is ok


def walk(seed, step_nm):
    """Return 30 cycles of a random walk, whose mean is not meaningful."""
    return step_nm * np.cumsum(np.random.default_rng(seed).standard_normal(30))


@pytest.mark.parametrize(("step_nm", "ok"), [(0.01, False), (1e-4, True)])
def test_wandering_cycles_are_flagged_if_significant(step_nm, ok):
    """u is 5 mN·m: a random walk of 0.1 mN·m per cycle is negligible."""
    noise = 0.01 * np.random.default_rng(3).standard_normal((8, 30))
    scattered = [[row, row[::-1]] for row in noise]
    assert independent_cycles(points([0.7] * 8), scattered).ok
    scattered[2] = [noise[2], walk(5, step_nm)]
    check = independent_cycles(points([0.7] * 8), scattered)
    assert check.ok == ok
    if not ok:
        assert check.biases[2].u == pytest.approx(np.std(walk(5, step_nm), ddof=1))
        assert check.biases[1].u == 0
        assert check.text.startswith("10 Hz: ")
        assert check.text.endswith(" of 30 cycles")
        assert check.value < 5
