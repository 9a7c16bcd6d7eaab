"""Relative gains of the recordings and the inertia of both runs, by what the runs have in common.

The inertia's torque J alpha f^2 is in both runs, and known. In the middle of a swing, where
presliding is over, friction is opposite in both strokes and the acceleration is not: what the
difference of the runs has in phase with the acceleration there is a gain that changed, or an
inertia. And the running torque of a run is a smooth function of the frequency, while a gain that
scatters from recording to recording is not. With the gains 1 + n_i without and 1 + l_i under load:

    in phase_i / (J alpha f_i^2)  =  D + C / (J alpha f_i^2) + l_i - n_i + e_i / (J alpha f_i^2)
    running torque_i, of a run    =  (b_0 + b_1 f + b_2 / f + b_3 f^2) (1 + n_i or l_i + r_i)

D is a change of the inertia, C what is elastic. It is a linear mixed model: b, C and D are fixed,
the gains and the errors e and r random. For given standard deviations the gains follow by the
equations of Henderson (Biometrics 31, 1975, 423), which shrink to none what the runs do not show;
and these are averaged over the standard deviations that are possible, by their restricted
likelihood (Patterson and Thompson, Biometrika 58, 1971, 545) and how usual they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import inf, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.compensations.bearing import bearing_torque
from rigrunner_bearings.compensations.swing import inertia_in_phase, running_torque
from rigrunner_bearings.compensations.under_load import SLOWEST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.compensations.bearing import Pair
    from rigrunner_bearings.compensations.identification import Identified

POWERS = (0, 1, -1, 2)
"""Of the frequency, in the running torque of a run; no more of them than there are frequencies."""

ALIKE = 2
"""Digits to which frequencies over the highest one are distinguished."""

USUAL = np.array([1e-3, 1e-3, 1e-3])
"""Usual standard deviations: of a gain and of the running torque, relative, and of what is in phase
with the acceleration, over the loaded run's running torque."""

TIMES = 3.0
"""By which a standard deviation may well be another than the usual one, either way."""

UNLIMITED = 1e3
"""Of the running torque: its terms may be as large as this where too few points show them."""

STEPS = 2.0 ** np.arange(-3, 4)
"""Times the usual: the standard deviations that are tried."""

ELASTIC = 0.05
"""Of the running torque: what may be elastic, or presliding that goes on, as C."""


@dataclass(frozen=True, eq=False)
class RecordingGains:
    """Gains of the recordings of n pairs, by what these have in common.

    `covariance` is that of the errors of (no_load, loaded, inertia), shape (2 n + 1, 2 n + 1).
    """

    no_load: Array
    """Relative error of the gain of each recording without load, shape (n,)."""
    loaded: Array
    inertia: float
    """By how much of itself the inertia under load is greater."""
    covariance: Array
    scatter: float
    """Standard deviation of the gains."""


def recording_gains(rig: Identified, pairs: Sequence[Pair], inertia_limit: float) -> RecordingGains:
    """Return the gains of both recordings of each pair, and the change of the inertia.

    The inertia is taken to have changed by no more than the limit (the half-width of a rectangle),
    unless the runs clearly show that it did.
    """
    observations = _Observations(rig, pairs)
    limit = inertia_limit / sqrt(3)
    free = observations.solved(inf)
    clearly = free.inertia**2 - free.covariance[-1, -1]
    return observations.solved(sqrt(max(limit**2, clearly)))


class _Observations:
    """What the pairs show, as observations y = X b + Z u + e of the mixed model.

    The standard deviations of e are `unit` times that of USUAL which `kind` names.
    """

    def __init__(self, rig: Identified, pairs: Sequence[Pair]) -> None:
        swing, line = rig.friction.swing, rig.line
        count = len(pairs)
        hertz = np.array([pair.loaded.frequency_hz for pair in pairs])
        runs = [
            np.array(
                [
                    running_torque(swing, line.at_load(run.waveform, run.frequency_hz))
                    for run in swings
                ]
            )
            for swings in ([p.no_load for p in pairs], [p.loaded for p in pairs])
        ]
        inertial = line.inertia_kgm2 * swing.acceleration_per_hz2
        in_phase = np.array(
            [inertia_in_phase(swing, bearing_torque(line, rig.friction, pair)) for pair in pairs]
        )
        identity = np.eye(count)
        torque = np.abs(runs[1]).mean()
        elastic = torque / (np.abs(inertial).max() * hertz**2)
        self._observed = in_phase / (line.inertia_kgm2 * hertz**2)
        self._fixed = np.stack([np.ones(count), ELASTIC * elastic], axis=1)
        self._random = np.hstack([-identity, identity])
        self._unit, self._kind = elastic, np.full(count, 2)
        for place, run in enumerate(runs):
            if run.min() > 0:
                self._add_running(place, run, hertz / hertz.max())

    def _add_running(self, place: int, torque: Array, speed: Array) -> None:
        """Add the running torques of one run, each over itself, where friction is smooth."""
        count = len(torque)
        used = speed >= SLOWEST
        powers = POWERS[: len(np.unique(speed[used].round(ALIKE)))]
        fixed = np.stack([speed**power for power in powers], axis=1) / torque[:, None]
        random = np.zeros((count, 2 * count))
        random[:, place * count : (place + 1) * count] = np.eye(count)
        rows, columns = self._fixed.shape
        count_used = np.count_nonzero(used)
        self._fixed = np.block(
            [
                [self._fixed, np.zeros((rows, len(powers)))],
                [np.zeros((count_used, columns)), fixed[used]],
            ]
        )
        self._random = np.vstack([self._random, random[used]])
        self._observed = np.concatenate([self._observed, np.ones(count_used)])
        self._unit = np.concatenate([self._unit, np.ones(count_used)])
        self._kind = np.concatenate([self._kind, np.ones(count_used, int)])

    def solved(self, inertia_u: float) -> RecordingGains:
        """Return the estimates, if that is the standard deviation which the inertia may have."""
        scatters = USUAL * np.array(list(product(STEPS, repeat=len(USUAL))))
        estimates, covariances, deviance = self._estimates(scatters, inertia_u)
        likely = -deviance / 2
        likely -= np.sum((np.log(scatters / USUAL) / np.log(TIMES)) ** 2, axis=1) / 2
        weight = np.exp(likely - likely.max())
        weight /= weight.sum()
        mean = weight @ estimates
        within = np.tensordot(weight, covariances, 1)
        covariance = within + (weight * (estimates - mean).T) @ (estimates - mean)
        gains = len(self._random[0])
        # The gains are the last unknowns; the first one is D.
        order = [*range(-gains, 0), 0]
        no_load, loaded = np.split(mean[-gains:], 2)
        return RecordingGains(
            no_load,
            loaded,
            float(mean[0]),
            covariance[np.ix_(order, order)],
            sqrt(weight @ scatters[:, 0] ** 2),
        )

    def _estimates(self, scatters: Array, inertia_u: float) -> tuple[Array, Array, Array]:
        """Return the estimates of (b, u), their covariance, and the deviance.

        By each of the standard deviations (s, 3): shapes (s, n), (s, n, n) and (s,).

        By QR of observations and priors together: normal equations would square the condition, and
        what is left of observations that are nearly 1 would be a difference of two large sums. Both
        differed from processor to processor, and with them the weights of `solved`.
        """
        error = scatters[:, self._kind] * self._unit
        gains, scatter = len(self._random[0]), scatters[:, :1]
        design = np.hstack([self._fixed, self._random]) / error[..., None]
        prior = np.zeros((len(scatters), design.shape[-1]))
        prior[:, :-gains] = 1 / UNLIMITED
        prior[:, 0], prior[:, 1] = 1 / inertia_u, 1.0
        prior[:, -gains:] = 1 / scatter
        rows = np.concatenate([design, prior[..., None] * np.eye(prior.shape[1])], axis=1)
        observed = np.hstack([self._observed / error, np.zeros_like(prior)])[..., None]
        scale = 1 / np.linalg.norm(rows, axis=1)
        rows *= scale[:, None]
        q, r = np.linalg.qr(rows)
        inverse = np.linalg.inv(r)
        estimates = inverse @ (q.swapaxes(1, 2) @ observed)
        unexplained = observed - rows @ estimates
        deviance = 2 * (
            np.log(error).sum(axis=1)
            + gains * np.log(scatter[:, 0])
            + np.log(np.abs(np.diagonal(r, axis1=1, axis2=2))).sum(axis=1)
            - np.log(scale).sum(axis=1)
        ) + (unexplained**2).sum(axis=(1, 2))
        covariance = scale[:, :, None] * (inverse @ inverse.swapaxes(1, 2)) * scale[:, None]
        return scale * estimates[..., 0], covariance, deviance
