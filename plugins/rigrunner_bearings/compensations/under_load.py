"""What the loaded sweep shows of the drive line, which is to be the one that was learned without.

Another filter, a delay, a clamp that is tight only under load: what the measuring chain does then
is another thing than what is undone. The inertia's torque is known and grows with f^2, so that the
loaded sweep shows the drive line too:

    X_k(f) = LP D H(k f) (J alpha_k f^2 + A_k + B_k f + C_k / f + D_k / f^2 + share W_k(f))

as in `identification`, but for the bearing's friction, which need not be a straight line over the
frequency: one that falls with speed does so within a part of the swing that becomes shorter with f.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from rigrunner_bearings.compensations.bearing import unexplained
from rigrunner_bearings.compensations.identification import (
    BOUNDS,
    DELAY_SCALE_S,
    UNKNOWNS,
    inertial_torque,
    observe_with_twist,
    vector,
    weighted,
    with_vector,
)

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.drive_line import DriveLine
    from rigrunner_bearings.compensations.evaluation import Evaluation
    from rigrunner_bearings.compensations.harmonics import Complex, Observed
    from rigrunner_bearings.compensations.identification import Identified

LEARNED = ("natural_hz", "damping_ratio", "inertia_kgm2", "delay_s")
"""The share of the twist is kept: where friction acts is no matter of the load."""

_PLACES = [UNKNOWNS.index(name) for name in LEARNED]
_BOUNDS = ([BOUNDS[0][k] for k in _PLACES], [BOUNDS[1][k] for k in _PLACES])
POWERS = (0, 1, -1, -2)
"""Of the frequency, in what friction may be."""

SLOWEST = 1 / 8
"""Of the highest frequency: slower swings show no drive line, and friction of every power."""


@dataclass(frozen=True, eq=False)
class LineUnderLoad:
    """The drive line by the loaded sweep; `covariance` is that of LEARNED, shape (4, 4)."""

    line: DriveLine
    covariance: Array


@lru_cache(maxsize=4)
def line_under_load(points: tuple[SwingPoint, ...], rig: Identified) -> LineUnderLoad | None:
    """Return the drive line by a loaded sweep on a known rig; None where too little shows it.

    That is where it has too few frequencies, a torque that never changes, or a phase of which each
    recording has a doubt of its own. Cached, as several methods need it for one sweep.
    """
    top_hz = max(point.frequency_hz.value for point in points)
    fast = tuple(point for point in points if point.frequency_hz.value >= SLOWEST * top_hz)
    enough = len({point.set_frequency_hz for point in fast}) > len(POWERS)
    if not enough or not all(map(_shows_phase, fast)):
        return None
    observed, change = observe_with_twist(fast, rig)

    def residual(values: Array) -> Array:
        return _residual(observed, with_vector(rig.line, values, LEARNED), change)

    start = vector(rig.line, LEARNED)
    scale = [*start[:-1], DELAY_SCALE_S]
    solution = least_squares(residual, start, x_scale=scale, bounds=_BOUNDS)
    rows = np.count_nonzero(observed.weight, axis=0)
    dof = 2 * np.maximum(rows - len(POWERS), 0).sum() - len(LEARNED)
    variance = max(float(solution.fun @ solution.fun) / dof, 1.0)
    jacobian = np.asarray(solution.jac)
    covariance = np.linalg.inv(jacobian.T @ jacobian) * variance
    return LineUnderLoad(with_vector(rig.line, solution.x, LEARNED), covariance)


def _shows_phase(point: SwingPoint) -> bool:
    doubt_s = max(point.phase_u_rad / (2 * np.pi * point.frequency_hz.value), point.alignment_u_s)
    return bool(np.ptp(point.torque_nm) > 0 and doubt_s < DELAY_SCALE_S)


def _residual(observed: Observed, line: DriveLine, change: Complex) -> Array:
    known_load = inertial_torque(observed, line) + line.share * change
    response, target = weighted(observed, line.sensor(observed.harmonic_hz), known_load)
    speed = observed.frequency_hz / observed.frequency_hz.max()
    basis = np.stack([response * speed**power for power in POWERS], axis=-1).transpose(1, 0, 2)
    q, _ = np.linalg.qr(basis)
    residual = target.T - (q @ (q.conj().transpose(0, 2, 1) @ target.T[..., None]))[..., 0]
    return np.concatenate([residual.real.ravel(), residual.imag.ravel()])


def effect(evaluation: Evaluation, rig: Identified, loaded: LineUnderLoad) -> tuple[float, float]:
    """Return how that drive line instead of the rig's changes a point's torque, and its u, in N·m.

    The uncertainty is that of both sweeps.
    """
    friction, run = rig.friction, evaluation.pair.loaded
    without = evaluation.bearing_nm - unexplained(rig.line, friction, run)

    def torque_nm(values: Array) -> float:
        line = with_vector(rig.line, values, LEARNED)
        return float(evaluation.reversals.torque(without + unexplained(line, friction, run)))

    learned = vector(loaded.line, LEARNED)
    loaded_nm, u = torque_nm(learned), np.sqrt(np.diag(loaded.covariance))
    slope = np.array([torque_nm(learned + step) - loaded_nm for step in np.diag(u)]) / u
    covariance = loaded.covariance + rig.covariance[np.ix_(_PLACES, _PLACES)]
    return loaded_nm - evaluation.maximum_nm, float(np.sqrt(slope @ covariance @ slope))
