"""How the time of one sample clock follows from that of another one."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import hypot, inf, sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array

CLOCK_TOLERANCE = 1e-4
"""Standard deviation of the relative difference of two quartz clocks, before it is measured."""


@dataclass(frozen=True)
class Relation:
    """The other clock's time, since its stream began, is tau + delta(tau), all in s.

    delta(tau) = offset_s + rate (tau - center_s), with tau the reference's time since its stream
    began; the uncertainties of offset and rate are standard ones and independent.
    """

    center_s: float
    offset_s: float
    rate: float
    u_offset_s: float
    u_rate: float

    def delta_s(self, tau_s: Array) -> Array:
        """Return by how much the other clock shows more, shape (n,)."""
        return np.asarray(self.offset_s + self.rate * (tau_s - self.center_s))

    def u_s(self, tau_s: Array) -> float:
        """Return the standard uncertainty over a span of times (n,), as a root mean square."""
        away_s = float(np.sqrt(np.mean((tau_s - self.center_s) ** 2)))
        return hypot(self.u_offset_s, self.u_rate * away_s)


@dataclass(frozen=True)
class Sighting:
    """What one look at both clocks showed: the difference at a time of the reference, in s."""

    tau_s: float
    delta_s: float
    u_s: float


def line_through(sightings: Sequence[Sighting]) -> Relation:
    """Return the relation by weighted least squares; the rate is drawn towards 0 at first.

    What the sightings scatter beyond their uncertainties widens the result (Birge's ratio).
    """
    tau = np.array([sighting.tau_s for sighting in sightings])
    delta = np.array([sighting.delta_s for sighting in sightings])
    weight = np.array([sighting.u_s for sighting in sightings]) ** -2.0
    center = float(np.average(tau, weights=weight))
    offset = float(np.average(delta, weights=weight))
    spread = float(weight @ (tau - center) ** 2)
    prior = CLOCK_TOLERANCE**-2
    rate = float(weight @ ((tau - center) * (delta - offset))) / (spread + prior)
    residual = delta - offset - rate * (tau - center)
    dof = len(sightings) - 2
    birge = sqrt(max(float(weight @ residual**2) / dof, 1.0)) if dof > 0 else 1.0
    return Relation(
        center_s=center,
        offset_s=offset,
        rate=rate,
        u_offset_s=birge / sqrt(float(weight.sum())),
        u_rate=min(birge / sqrt(spread + prior), CLOCK_TOLERANCE),
    )


@dataclass(frozen=True)
class _Line:
    """When blocks arrive at the earliest, by the computer's clock: at x seconds of samples."""

    center_s: float
    late_s: float
    slope: float
    u_late_s: float
    u_slope: float


def by_arrivals(
    reference: tuple[Array, Array], other: tuple[Array, Array], latency_s: float
) -> Relation:
    """Return the relation by the lower envelope of arrival times.

    Each stream is given as seconds of samples (n,) at the ends of its blocks, and when these
    arrived, (n,). A block never arrives before its last sample was taken, but may be late: the line
    below all points shows the clock (Moon, Skelly and Towsley, INFOCOM 1999). How late a block is
    at the least stays unknown; for each stream it is between 0 and `latency_s`.
    """
    line, other_line = _envelope(*reference), _envelope(*other)
    latency_u_s = latency_s / sqrt(6)  # the difference of two rectangular distributions
    rate = line.slope - other_line.slope
    center = line.center_s
    # At the reference's time tau the computer shows late_s + tau; the other one's time follows.
    theirs_late_s = other_line.late_s + other_line.slope * (center - other_line.center_s)
    return Relation(
        center_s=center,
        offset_s=line.late_s - theirs_late_s,
        rate=rate,
        u_offset_s=float(np.linalg.norm([line.u_late_s, other_line.u_late_s, latency_u_s])),
        u_rate=hypot(line.u_slope, other_line.u_slope),
    )


def _envelope(ends_s: Array, arrived_s: Array) -> _Line:
    late = arrived_s - ends_s
    middle = float(ends_s.mean())
    slope, slope_u = 0.0, inf
    for left, right in pairwise(_lower_hull(ends_s, late)):
        # Of all lines below the points, that over their middle is the nearest one on average.
        if ends_s[left] <= middle <= ends_s[right]:
            slope = (late[right] - late[left]) / (ends_s[right] - ends_s[left])
            excess = late - late[left] - slope * (ends_s - ends_s[left])
            slope_u = sqrt(2) * float(excess.mean()) / float(np.ptp(ends_s))
    # Weighed against what is known of any quartz, or few blocks would pass for a fast clock.
    trust = CLOCK_TOLERANCE**2 / (CLOCK_TOLERANCE**2 + slope_u**2)
    slope *= trust
    excess = late - slope * (ends_s - middle)
    least = float(excess.min())
    return _Line(
        center_s=middle,
        late_s=least,
        slope=float(slope),
        u_late_s=float(excess.mean() - least) / sqrt(len(late)),
        u_slope=CLOCK_TOLERANCE * sqrt(1 - trust),
    )


def _lower_hull(x: Array, y: Array) -> list[int]:
    """Return the indices of the lower convex hull; x rises."""
    hull: list[int] = []
    for i in range(len(x)):
        while len(hull) > 1:
            a, b = hull[-2], hull[-1]
            if (y[b] - y[a]) * (x[i] - x[a]) < (y[i] - y[a]) * (x[b] - x[a]):
                break
            hull.pop()
        hull.append(i)
    return hull
