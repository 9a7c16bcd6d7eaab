"""Whether the set-points of one run agree with each other, before their mean is taken.

Friction changes smoothly with the speed of a swing, so that torques may have a trend over the
frequency. Their scatter about it has to agree with their own uncertainties (chi-squared).
If it is more, all of these are too small by the Birge ratio, the root of chi-squared over its
degrees of freedom: as the Particle Data Group and CODATA do, they are widened by it (Birge, Phys.
Rev. 40, 1932, 207; Workman et al., Prog. Theor. Exp. Phys. 2022, 083C01, 5.2.2). What makes them
disagree, such as a coupling that is softer under load, has moved most of them the same way: it is
taken for one error, which the mean does not average out.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
import scipy

from rigrunner.api import Check
from rigrunner.api.analysis import Bias
from rigrunner.api.checks import skipped
from rigrunner.signal.uncertainty import combine

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner_bearings.api.compensations import CompensatedPoint

NAME = "agreement of the set-points"
TREND = 0.005
"""Of the torque: the friction laws of all simulators leave less about such a trend, 0.4 %."""

CHANCE = 0.01
"""Probability that set-points which agree fail the check."""

LEAST = 5
"""Set-points: a trend of three coefficients is to leave two degrees of freedom."""


def agreement(points: Sequence[CompensatedPoint]) -> Check:
    """Check the torques against a trend a + b f + c sqrt(f), by their own uncertainties."""
    hertz = np.array([point.frequency_hz for point in points])
    if len(set(hertz)) < LEAST:
        return skipped(NAME, f"fewer than {LEAST} frequencies")
    torques = np.array([point.torque.value for point in points])
    own_u = np.array([combine(part for part in p.components if not part.common)[0] for p in points])
    sigma = np.hypot(own_u, TREND * abs(torques.mean()))
    basis = np.stack([np.ones_like(hertz), hertz, np.sqrt(hertz)], axis=1) / sigma[:, None]
    trend, *_ = np.linalg.lstsq(basis, torques / sigma, rcond=None)
    residual = torques / sigma - basis @ trend
    dof = len(points) - basis.shape[1]
    ratio = sqrt(float(residual @ residual) / dof)
    most = sqrt(float(scipy.special.chdtri(dof, CHANCE)) / dof)
    ok = ratio <= most
    lacking = 0.0 if ok else sqrt(ratio**2 - 1)
    where = int(np.abs(residual).argmax())
    off = f"{hertz[where]:.4g} Hz is off their trend by {residual[where] * sigma[where]:+.4f} N·m"
    return Check(
        NAME,
        ok=ok,
        text="the set-points agree within their uncertainties" if ok else f"{off}, the most of all",
        advice="" if ok else "repeat the set-points that are off; is the gain steady, the load?",
        value=ratio,
        threshold=most,
        unit="1",
        biases=tuple(
            Bias(f"{f:.4g} Hz", 0.0, lacking * float(u)) for f, u in zip(hertz, sigma, strict=True)
        ),
    )
