"""Learns the drive line and the support's friction from the no-load sweep alone.

Every harmonic k of the torque at every frequency f obeys

    X_k(f) = LP D H(k f) (J alpha_k f^2 + A_k + B_k f + share W_k(f))

where LP is known, D a delay, alpha the kinematics', A + B f the support's friction of any shape,
and W what it changes because the coupling twists (`support_friction`). For given fn, z, J, share
and delay the A_k and B_k follow by linear least squares, each harmonic on its own, so that only
five unknowns are searched (variable projection: Golub and Pereyra, SIAM J. Numer. Anal. 10(2),
1973). W needs a result and is renewed until it stays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import least_squares

from rigrunner.api import DataError
from rigrunner_bearings.compensations.drive_line import DriveLine
from rigrunner_bearings.compensations.harmonics import (
    SENSOR,
    mean_torque,
    observe,
    spectrum_of,
    waveform_of,
)
from rigrunner_bearings.compensations.requirements import LEAST_FREQUENCIES
from rigrunner_bearings.compensations.response import Waveform, torsional_resonance
from rigrunner_bearings.compensations.support_friction import SupportFriction, make_friction
from rigrunner_bearings.compensations.swing import interpolated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.filters import Filter
    from rigrunner_bearings.compensations.harmonics import Complex, Observed
    from rigrunner_bearings.compensations.swing import Swing

ROUNDS = 6
TWISTED_ROUNDS = 2
"""Of a drive line that is known: the friction's twist alone is renewed."""

SHARE_PRIOR = (0.5, 1 / sqrt(12))
"""Nothing known: as likely anywhere from 0 to 1 (mean and standard deviation)."""

UNKNOWNS = ("natural_hz", "damping_ratio", "inertia_kgm2", "share", "delay_s")
# In the order of UNKNOWNS, in their SI units.
BOUNDS = ([1.0, 1e-4, 1e-9, 0.0, -0.01], [1e5, 1.0, inf, 1.0, 0.01])
DELAY_SCALE_S = 1e-5
SIGNIFICANT_DELAY = 3.0
"""In standard uncertainties."""
LEAST_DELAY_S = 1.8e-4
"""Friction that weakens with speed looks like a delay of up to that, with a share of none."""

START_HZ = np.geomspace(60.0, 2500.0, 75)
START_DAMPING = (0.02, 0.06, 0.15)
LEAST_SIGNAL = 3.0
"""Standard uncertainties of its first harmonic: inertia and friction have hundreds of them."""
UNUSED, FLAT = 1e-30, 1e-12
"""A weight that is none; a spread of frequencies, of their squares, that gives no slope."""


@dataclass(frozen=True, eq=False)
class Identified:
    """The rig as the no-load sweep shows it.

    `covariance` is that of (fn, z, J, share, delay), shape (5, 5), with the degrees of freedom of
    the residual; `misfit` is the residual's rms over what the scatter of the cycles lets expect.
    """

    line: DriveLine
    friction: SupportFriction
    covariance: Array
    dof: float
    misfit: float


@lru_cache(maxsize=4)
def identify(points: tuple[SwingPoint, ...], swing: Swing, low_pass: Filter) -> Identified:
    """Return drive line and support friction.

    Raises DataError for too few frequencies, and for a sensor that shows noise alone.

    A delay that is small or not significant is taken as none, for it looks much like where the
    friction acts; that it may still be there stays in the covariance. Cached, as several
    methods need it for one sweep.
    """
    if len(points) < LEAST_FREQUENCIES:
        raise DataError(
            f"the no-load sweep has {len(points)} frequencies, but {LEAST_FREQUENCIES} are needed "
            "to learn the rig's resonance",
            hint="record the no-load sweep over the whole range of frequencies",
        )
    observed, waveforms = observe(points, swing), _waveforms(points, swing)
    if np.median(np.abs(observed.harmonics[:, 0]) * observed.weight[:, 0]) < LEAST_SIGNAL:
        raise DataError(
            "the no-load torque does not swing with the angle: there is nothing in it but noise",
            hint=SENSOR,
        )
    start = _start(observed, low_pass)
    rig = _search(observed, waveforms, swing, start, UNKNOWNS)
    least = max(LEAST_DELAY_S, SIGNIFICANT_DELAY * sqrt(rig.covariance[-1, -1]))
    if abs(rig.line.delay_s) > least:
        return rig
    without_delay = _search(observed, waveforms, swing, start, UNKNOWNS[:-1])
    return replace(without_delay, covariance=rig.covariance)


@lru_cache(maxsize=4)
def identify_again(
    points: tuple[SwingPoint, ...], swing: Swing, low_pass: Filter, rig: Identified
) -> Identified:
    """Return a known rig as learned from some of its points, or with another swing or filter.

    The delay is searched for only if the rig has one, so that the two differ by nothing else.
    """
    observed, waveforms = observe(points, swing), _waveforms(points, swing)
    unknowns = UNKNOWNS if rig.line.delay_s else UNKNOWNS[:-1]
    return _search(observed, waveforms, swing, _start(observed, low_pass), unknowns)


def _search(
    observed: Observed,
    waveforms: Sequence[Waveform],
    swing: Swing,
    line: DriveLine,
    unknowns: Sequence[str],
) -> Identified:
    twist_change = np.zeros_like(observed.harmonics)
    for still in reversed(range(ROUNDS)):
        line, jacobian, residual = _solve(observed, line, twist_change, unknowns)
        twists = _twists(observed, line, waveforms)
        friction = _friction(observed, line, twist_change, swing, twists)
        if still:
            twist_change = _twist_change(observed, friction, twists)
    # Two numbers of each harmonic that is used, less A_k and B_k of each, which are complex too.
    rows = np.count_nonzero(observed.weight, axis=0)
    dof = float(np.sum(2 * np.maximum(rows - 2, 0)) - jacobian.shape[1])
    variance = float(residual @ residual) / dof if dof > 0 else inf
    scale = max(variance, 1.0)
    covariance = np.asarray(np.linalg.inv(jacobian.T @ jacobian) * scale, dtype=float)
    return Identified(line, friction, covariance, dof, sqrt(variance))


def _start(observed: Observed, low_pass: Filter) -> DriveLine:
    """Return the best of a coarse search; J from the highest frequency's first harmonic."""
    top = int(np.argmax(observed.frequency_hz))
    # The swing is odd over the phase, and so is its acceleration: what inertia makes is in the
    # imaginary part, friction, which goes with the velocity, in the real one.
    inertial = observed.acceleration[0] * observed.frequency_hz[top, 0] ** 2
    inertia = max(abs(observed.harmonics[top, 0].imag / inertial.imag), BOUNDS[0][2])
    line = DriveLine(1.0, 0.0, inertia, 0.0, 0.0, low_pass)
    filtered, inertial_nm = line.channel(observed.harmonic_hz), inertial_torque(observed, line)
    damping = np.array(START_DAMPING)[:, None, None]
    misfit = []
    for natural_hz in START_HZ:  # with all dampings at once: calls would take longer than numbers
        resonance = torsional_resonance(observed.harmonic_hz, natural_hz, damping)
        misfit.append(_misfit(observed, filtered * resonance, inertial_nm))
    best, which = np.unravel_index(np.argmin(misfit), (len(START_HZ), len(START_DAMPING)))
    return replace(line, natural_hz=float(START_HZ[best]), damping_ratio=START_DAMPING[which])


def _misfit(observed: Observed, sensor: Complex, known_load: Complex) -> Array:
    """Return the sum of squares that is left with each of L responses (L, F, K), shape (L,).

    That of `_residual` without its prior, by the equations of a weighted straight line, for A_k +
    B_k f is one: good enough to choose a start, and a tenth of the work of an orthogonal basis.
    """
    response, target = weighted(observed, sensor, known_load)
    weight, product = np.abs(response) ** 2, response.conj() * target
    total = np.maximum(weight.sum(axis=1, keepdims=True), UNUSED)
    frequency = observed.frequency_hz
    distance = frequency - (weight * frequency).sum(axis=1, keepdims=True) / total
    spread = (weight * distance**2).sum(axis=1, keepdims=True)
    spread = np.maximum(spread, FLAT * total * frequency.max() ** 2)
    level = np.abs(product.sum(axis=1, keepdims=True)) ** 2 / total
    slope = np.abs((product * distance).sum(axis=1, keepdims=True)) ** 2 / spread
    explained = (level + slope).sum(axis=(1, 2))
    return np.asarray((np.abs(target) ** 2).sum(axis=(1, 2)) - explained)


def inertial_torque(observed: Observed, line: DriveLine) -> Complex:
    """Return the harmonics of the inertia's torque, shape (F, K)."""
    return line.inertia_kgm2 * observed.acceleration * observed.frequency_hz**2


def weighted(observed: Observed, sensor: Complex, known_load: Complex) -> tuple[Complex, Complex]:
    """Return the weighted response (..., F, K), and its target besides a known load."""
    response = sensor * observed.weight
    return response, observed.weight * observed.harmonics - response * known_load


def _linear(observed: Observed, line: DriveLine, change: Complex) -> tuple[Complex, Complex]:
    """Return the weighted basis of A_k and B_k, shape (K, F, 2), and its target, (K, F)."""
    known_load = inertial_torque(observed, line) + line.share * change
    response, target = weighted(observed, line.sensor(observed.harmonic_hz), known_load)
    basis = np.stack([response, response * observed.frequency_hz], axis=-1)
    return basis.transpose(1, 0, 2), target.T


def _residual(observed: Observed, line: DriveLine, change: Complex) -> Array:
    basis, target = _linear(observed, line, change)
    q, _ = np.linalg.qr(basis)
    explained = q @ (q.conj().transpose(0, 2, 1) @ target[..., None])
    residual = target - explained[..., 0]
    prior = (line.share - SHARE_PRIOR[0]) / SHARE_PRIOR[1]
    return np.concatenate([residual.real.ravel(), residual.imag.ravel(), [prior]])


def vector(line: DriveLine, unknowns: Sequence[str] = UNKNOWNS) -> Array:
    """Return (fn, z, J, share, delay), in the order of `Identified.covariance`."""
    return np.array([getattr(line, name) for name in unknowns])


def with_vector(line: DriveLine, values: Array, unknowns: Sequence[str] = UNKNOWNS) -> DriveLine:
    """Return the drive line with other values of (fn, z, J, share, delay)."""
    changes: dict[str, Any] = dict(zip(unknowns, map(float, values), strict=True))
    return replace(line, **changes)


def _solve(
    observed: Observed, line: DriveLine, change: Complex, unknowns: Sequence[str]
) -> tuple[DriveLine, Array, Array]:
    """Return the drive line of least squares, with Jacobian and residual there."""

    def residual(values: Array) -> Array:
        return _residual(observed, with_vector(line, values, unknowns), change)

    scale = [line.natural_hz, line.damping_ratio, line.inertia_kgm2, 1.0, DELAY_SCALE_S]
    count = len(unknowns)
    solution = least_squares(
        residual,
        vector(line, unknowns),
        x_scale=scale[:count],
        bounds=(BOUNDS[0][:count], BOUNDS[1][:count]),
    )
    return with_vector(line, solution.x, unknowns), np.asarray(solution.jac), solution.fun


def _friction(
    observed: Observed, line: DriveLine, change: Complex, swing: Swing, twists: Sequence[Array]
) -> SupportFriction:
    basis, target = _linear(observed, line, change)
    coefficients = (np.linalg.pinv(basis) @ target[..., None])[..., 0]
    dry, growth = (waveform_of(coefficients[:, i], swing.size) for i in (0, 1))
    slowest = twists[int(np.argmin(observed.frequency_hz))]
    return make_friction(swing, slowest, dry, growth, _best_known_hz(basis))


def _best_known_hz(basis: Complex) -> float:
    """Return the f at which A + B f is known best, from the basis of all harmonics (K, F, 2)."""
    used = np.abs(basis).sum(axis=(1, 2)) > 0
    covariance = np.linalg.pinv(basis[used].conj().transpose(0, 2, 1) @ basis[used]).real
    return float(-covariance[:, 0, 1].sum() / covariance[:, 1, 1].sum())


def frictions_without_each(
    points: tuple[SwingPoint, ...], rig: Identified
) -> tuple[SupportFriction, ...]:
    """Return the support's friction as learned without each point, for a jackknife over them.

    The drive line is kept: its own uncertainty is in `Identified.covariance`.
    """
    swing = rig.friction.swing
    observed = observe(points, swing)
    twists = _twists(observed, rig.line, _waveforms(points, swing))
    change = _twist_change(observed, rig.friction, twists)
    return tuple(
        _friction(
            observed.without(left_out), rig.line, np.delete(change, left_out, 0), swing, twists
        )
        for left_out in range(len(points))
    )


def observe_with_twist(points: tuple[SwingPoint, ...], rig: Identified) -> tuple[Observed, Complex]:
    """Return the harmonics of other points on the rig, and what the twist changes there, (F, K).

    The friction that twists is what these points have by a straight line over the frequency.
    """
    swing = rig.friction.swing
    observed = observe(points, swing)
    twists = _twists(observed, rig.line, _waveforms(points, swing))
    change = np.zeros_like(observed.harmonics)
    for _ in range(TWISTED_ROUNDS):
        friction = _friction(observed, rig.line, change, swing, twists)
        change = _twist_change(observed, friction, twists)
    return observed, change


def _waveforms(points: tuple[SwingPoint, ...], swing: Swing) -> tuple[Waveform, ...]:
    return tuple(Waveform(interpolated(mean_torque(point), swing.size)) for point in points)


def _twists(
    observed: Observed, line: DriveLine, waveforms: Sequence[Waveform]
) -> tuple[Array, ...]:
    frequencies = observed.frequency_hz[:, 0]
    return tuple(line.twist(w, f) for f, w in zip(frequencies, waveforms, strict=True))


def _twist_change(
    observed: Observed, friction: SupportFriction, twists: Sequence[Array]
) -> Complex:
    """Return the harmonics of what the full twist changes in the friction, shape (F, K)."""
    frequencies = observed.frequency_hz[:, 0]
    return np.array(
        [spectrum_of(friction.change(f, t)) for f, t in zip(frequencies, twists, strict=True)]
    )
