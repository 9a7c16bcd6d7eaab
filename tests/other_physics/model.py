"""The mechanics of the rig, integrated in the time domain.

    crank      dphi/dt = 2 pi f [1 + a1 cos(phi + b1) + a2 cos(2 phi + b2)]
    guide bar  theta_d = atan2(l sin phi, 1 + l cos phi),  l = (e/L) [1 + m cos(n phi)]
    play       t = theta_d - theta_h,  elastic twist q = sign(t) max(|t| - play/2, 0)
    gauge      T_g = k_g q, and a damper c_g dq/dt while the flanks touch
    hub        J_h d2theta_h/dt2 = T_g - T_c
    coupling   T_c = k_c (theta_h - theta_s) + c_c (omega_h - omega_s)
    spindle    J_s d2theta_s/dt2 = T_c - T_support - T_bearing
    support    LuGre: dz/dt = w - s0 |w| z / g(w),  T = s0 z + s1 dz/dt + s2 w,
               g(w) = Tc + (Ts - Tc) exp(-(w/ws)^2)
    bearing    LuGre with s1 = s2 = 0, or Iwan: Jenkins elements (spring and slider) in parallel;
               it acts between spindle and outer ring
    housing    c_o dtheta_o/dt = T_bearing - k_o theta_o

Sources: Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419 (LuGre); Iwan, J. Appl.
Mech. 33 (1966) 893 (elements in parallel). The gauge reads the elastic torque k_g q alone, since a
strain gauge sees strain. All in SI units.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numba import njit

JENKINS = 12
STEP_S = 1e-5
"""The stiffest mode, the hub between its springs, is below 8 kHz."""
_TWIST, _HOUSING, _SUPPORT, _LUGRE = 4, 5, 6, 7
_SIZE = 8


class Rig(NamedTuple):
    """The mechanics of one rig in one run."""

    eccentric_ratio: float = 2.0 / 45.0
    ripple_1: float = 0.0
    ripple_1_phase: float = 0.0
    ripple_2: float = 0.0
    ripple_2_phase: float = 0.0
    stroke_modulation: float = 0.0
    stroke_order: float = 0.25
    """How often in a turn of the crank the stroke is modulated."""
    play_rad: float = 0.0
    gauge_stiffness: float = 60e3
    gauge_damping: float = 0.4
    hub_inertia: float = 1.0e-4
    coupling_stiffness: float = 19.5e3
    coupling_damping: float = 0.55
    spindle_inertia: float = 2.25e-3
    support_coulomb_nm: float = 0.72
    support_static_nm: float = 0.78
    support_stribeck_rad_s: float = 0.3
    support_bristle: float = 260.0
    """Stiffness s0, N.m/rad."""
    support_bristle_damping: float = 0.05
    support_viscous: float = 0.30
    bearing_kinetic_nm: float = 0.64
    """At the load of the run; 0 without load."""
    bearing_static_nm: float = 0.78
    bearing_stribeck_rad_s: float = 0.5
    bearing_bristle: float = 450.0
    is_iwan: bool = False
    iwan_spread: float = 4.0
    """Greatest slip of a Jenkins element over the least one."""
    housing_stiffness: float = 30e3
    housing_damping: float = 1.0


class Motion(NamedTuple):
    """What the mechanics did, one value each `every` steps of STEP_S; arrays of shape (n,)."""

    time_s: np.ndarray
    drive_rad: np.ndarray
    spindle_rad: np.ndarray
    gauge_nm: np.ndarray
    bearing_nm: np.ndarray


def integrate(rig: Rig, frequency_hz: float, duration_s: float, settle_turns: int = 4) -> Motion:
    """Return the motion after so many turns, at 1 / STEP_S samples a second."""
    settle = round(settle_turns / frequency_hz / STEP_S)
    count = round(duration_s / STEP_S)
    stiffness, limit = _jenkins(rig)
    drive, spindle, gauge, bearing = _run(rig, frequency_hz, settle, count, stiffness, limit)
    return Motion(np.arange(count) * STEP_S, drive, spindle, gauge, bearing)


def natural_hz(rig: Rig) -> float:
    """Return the lower torsional resonance: hub and spindle on two springs in series."""
    k = np.array(
        [
            [rig.gauge_stiffness + rig.coupling_stiffness, -rig.coupling_stiffness],
            [-rig.coupling_stiffness, rig.coupling_stiffness],
        ]
    )
    masses = np.diag([rig.hub_inertia, rig.spindle_inertia])
    return float(np.sqrt(np.linalg.eigvals(np.linalg.solve(masses, k)).real.min()) / (2 * np.pi))


def starting_torque_nm(motion: Motion, within_rad: float = math.radians(1.0)) -> float:
    """Return the true starting torque: the greatest of the bearing up to 1 deg after a reversal.

    In the sense of the new motion: at the reversal itself the bearing still pulls the old way. The
    mean over all reversals of the spindle, of both directions alike.
    """
    angle, torque = motion.spindle_rad, motion.bearing_nm
    speed = np.diff(angle)
    turns = np.flatnonzero(np.diff(np.sign(speed)) != 0) + 1
    peaks: dict[int, list[float]] = {-1: [], 1: []}
    swing = np.ptp(angle)
    for start, end in pairwise(turns):
        if abs(angle[end] - angle[start]) < swing / 2:  # it rings about the reversal
            continue
        far = np.flatnonzero(np.abs(angle[start:end] - angle[start]) > within_rad)
        stop = start + int(far[0]) if len(far) else end
        sense = 1 if angle[end] > angle[start] else -1
        peaks[sense].append(float((sense * torque[start:stop]).max()))
    return float(np.mean([np.mean(each) for each in peaks.values()]))


def _jenkins(rig: Rig) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffness and limit of each element; together they slide at the kinetic torque.

    Equal limits, and slips spread geometrically about that of the bristles.
    """
    limit = np.full(JENKINS, rig.bearing_kinetic_nm / JENKINS)
    middle = Rig().bearing_static_nm / rig.bearing_bristle
    slip = middle * np.geomspace(rig.iwan_spread**-0.5, rig.iwan_spread**0.5, JENKINS)
    return limit / slip, limit


@njit(cache=True)
def _bar(rig: Rig, phi: float, speed: float) -> tuple[float, float]:
    """Return angle and speed of the guide bar."""
    ratio = rig.eccentric_ratio * (1.0 + rig.stroke_modulation * math.cos(rig.stroke_order * phi))
    sine, cosine = math.sin(phi), math.cos(phi)
    below = 1.0 + ratio * ratio + 2.0 * ratio * cosine
    by_phi = ratio * (ratio + cosine) / below
    by_ratio = sine / below
    change = (
        -rig.eccentric_ratio
        * rig.stroke_modulation
        * rig.stroke_order
        * math.sin(rig.stroke_order * phi)
    )
    return math.atan2(ratio * sine, 1.0 + ratio * cosine), (by_phi + by_ratio * change) * speed


@njit(cache=True)
def _crank_speed(rig: Rig, phi: float, frequency_hz: float) -> float:
    ripple = rig.ripple_1 * math.cos(phi + rig.ripple_1_phase)
    ripple += rig.ripple_2 * math.cos(2.0 * phi + rig.ripple_2_phase)
    return 2.0 * math.pi * frequency_hz * (1.0 + ripple)


@njit(cache=True)
def _bearing(rig: Rig, y: np.ndarray, k: np.ndarray, limit: np.ndarray, at: np.ndarray) -> float:
    """Return the bearing's friction; `at` is where each Jenkins element's spring begins."""
    if not rig.is_iwan:
        return rig.bearing_bristle * y[_LUGRE]
    angle = y[2] - y[_HOUSING]
    total = 0.0
    for i in range(len(k)):
        total += min(max(k[i] * (angle - at[i]), -limit[i]), limit[i])
    return total


@njit(cache=True)
def _gauge(rig: Rig, drive: float, drive_speed: float, y: np.ndarray) -> tuple[float, float]:
    """Return the elastic torque of the gauge, and the torque on the hub."""
    twist = drive - y[0]
    over = abs(twist) - 0.5 * rig.play_rad
    if over <= 0.0:
        return 0.0, 0.0
    elastic = math.copysign(rig.gauge_stiffness * over, twist)
    return elastic, elastic + rig.gauge_damping * (drive_speed - y[1])


@njit(cache=True)
def _rates(  # noqa: PLR0917  (numba knows no keyword-only arguments)
    rig: Rig,
    frequency_hz: float,
    y: np.ndarray,
    k: np.ndarray,
    limit: np.ndarray,
    at: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write the derivative of the state.

    y: hub angle and speed, spindle angle and speed, crank angle, outer ring, bristles of support
    and bearing.
    """
    crank = _crank_speed(rig, y[_TWIST], frequency_hz)
    drive, drive_speed = _bar(rig, y[_TWIST], crank)
    _, on_hub = _gauge(rig, drive, drive_speed, y)
    coupling = rig.coupling_stiffness * (y[0] - y[2]) + rig.coupling_damping * (y[1] - y[3])
    speed = y[3]
    level = rig.support_coulomb_nm + (rig.support_static_nm - rig.support_coulomb_nm) * math.exp(
        -((speed / rig.support_stribeck_rad_s) ** 2)
    )
    bristle = speed
    if level > 0.0:
        bristle -= rig.support_bristle * abs(speed) * y[_SUPPORT] / level
    support = (
        rig.support_bristle * y[_SUPPORT]
        + rig.support_bristle_damping * bristle
        + rig.support_viscous * speed
    )
    bearing = _bearing(rig, y, k, limit, at)
    ring = (bearing - rig.housing_stiffness * y[_HOUSING]) / rig.housing_damping
    slide = speed - ring
    out[0] = y[1]
    out[1] = (on_hub - coupling) / rig.hub_inertia
    out[2] = y[3]
    out[3] = (coupling - support - bearing) / rig.spindle_inertia
    out[_TWIST] = crank
    out[_HOUSING] = ring
    out[_SUPPORT] = bristle
    out[_LUGRE] = 0.0
    if not rig.is_iwan and rig.bearing_kinetic_nm > 0.0:
        most = rig.bearing_kinetic_nm + (rig.bearing_static_nm - rig.bearing_kinetic_nm) * math.exp(
            -abs(slide) / rig.bearing_stribeck_rad_s
        )
        out[_LUGRE] = slide - rig.bearing_bristle * abs(slide) * y[_LUGRE] / most


@njit(cache=True)
def _run(  # noqa: PLR0917  (numba knows no keyword-only arguments)
    rig: Rig, frequency_hz: float, settle: int, count: int, k: np.ndarray, limit: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Integrate by the classical Runge-Kutta method; the sliders move between steps."""
    y = np.zeros(_SIZE)
    at = np.zeros(len(k))
    one, two, three, four = np.empty(_SIZE), np.empty(_SIZE), np.empty(_SIZE), np.empty(_SIZE)
    between = np.empty(_SIZE)
    drive, spindle, gauge, bearing = (
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.empty(count),
    )
    half = 0.5 * STEP_S
    for step in range(settle + count):
        if step >= settle:
            index = step - settle
            crank = _crank_speed(rig, y[_TWIST], frequency_hz)
            angle, speed = _bar(rig, y[_TWIST], crank)
            drive[index], spindle[index] = angle, y[2]
            gauge[index] = _gauge(rig, angle, speed, y)[0]
            bearing[index] = _bearing(rig, y, k, limit, at)
        _rates(rig, frequency_hz, y, k, limit, at, one)
        for i in range(_SIZE):
            between[i] = y[i] + half * one[i]
        _rates(rig, frequency_hz, between, k, limit, at, two)
        for i in range(_SIZE):
            between[i] = y[i] + half * two[i]
        _rates(rig, frequency_hz, between, k, limit, at, three)
        for i in range(_SIZE):
            between[i] = y[i] + STEP_S * three[i]
        _rates(rig, frequency_hz, between, k, limit, at, four)
        for i in range(_SIZE):
            y[i] += STEP_S / 6.0 * (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i])
        if rig.is_iwan:
            angle = y[2] - y[_HOUSING]
            for i in range(len(k)):
                if k[i] > 0.0:
                    reach = limit[i] / k[i]
                    at[i] = min(max(at[i], angle - reach), angle + reach)
    return drive, spindle, gauge, bearing
