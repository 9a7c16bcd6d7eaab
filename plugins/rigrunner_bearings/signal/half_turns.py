"""The half turns around the middles of forward strokes: how late each is against the kinematics.

A start is refined by one step of Gauss and Newton: of the measured angle m, against an offset o and
a scale s times the guide bar's angle f(phase), with dm/dt = s v / period where v = df/dt at 1 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.signal.kinematics import angle_and_velocity, by_half_angle

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigrunner.api import Array, Mask
    from rigrunner.api.data import Samples

TOGETHER = 1 << 16
"""Samples of half turns that are summed at once, so that they stay in a core's cache."""


def _indices(starts: Array, half: int) -> NDArray[np.intp]:
    return np.rint(starts).astype(np.intp)[:, None] + np.arange(-half, half + 1)


def _phase(index: NDArray[np.intp], starts: Array, period: Array) -> Array:
    return np.asarray(2 * np.pi * (index - starts[:, None]) / period[:, None])


@dataclass(frozen=True, eq=False)
class HalfTurns:
    """The half turns around some starts: angles measured and by the kinematics, (starts, n)."""

    measured: Array
    model: Array
    velocity: Array
    inside: Mask
    """False where the recording has ended, or not begun."""
    period: Array

    @classmethod
    def around(
        cls, angle: Samples, starts: Array, period: Array, half: int, ratio: float
    ) -> HalfTurns:
        """Take `half` samples on either side of each of `starts`, out of an angle (samples,)."""
        index = _indices(starts, half)
        inside = (index >= 0) & (index < len(angle))
        phase = _phase(index, starts, period)
        index = np.clip(index, 0, len(angle) - 1)
        first = int(index[0, 0])
        measured = angle[first : int(index[-1, -1]) + 1][index - first]
        model, velocity = angle_and_velocity(phase, 1.0, ratio)
        return cls(measured, model, velocity, inside, period[:, None])

    def scale(self, offset: float) -> float:
        """Return by how much larger the measured angle is, by least squares."""
        product = ((self.measured - offset) * self.model)[self.inside].sum()
        return float(product) / float((self.model[self.inside] ** 2).sum())

    def late(self, offset: float, scale: float) -> Array:
        """Return the number of samples by which each start must be later."""
        residual = np.where(self.inside, self.measured - offset - scale * self.model, 0.0)
        slope = np.where(self.inside, scale * self.velocity, 0.0) / self.period
        return np.asarray(-(slope * residual).sum(axis=1) / (slope**2).sum(axis=1))


@dataclass(frozen=True, eq=False)
class HalfTurnSums:
    """The scale and lateness of `HalfTurns`, from sums over each half turn, (starts,) each.

    An angle that is too long for memory is then read once per step, although offset and scale are
    known only at its end. m, f and v are the measured angle, the kinematics' and its velocity.
    """

    mf: Array
    f: Array
    ff: Array
    mv: Array
    v: Array
    fv: Array
    vv: Array
    period: Array

    @classmethod
    def around(
        cls, angle: Array, starts: Array, period: Array, half: int, ratio: float
    ) -> HalfTurnSums:
        """Return the sums over the half turns of `HalfTurns.around`."""
        step = max(TOGETHER // (2 * half + 1), 1)
        groups = [slice(k, k + step) for k in range(0, len(starts), step)]
        return cls.joined([cls._of(angle, starts[k], period[k], half, ratio) for k in groups])

    @classmethod
    def _of(
        cls, angle: Array, starts: Array, period: Array, half: int, ratio: float
    ) -> HalfTurnSums:
        index = _indices(starts, half)
        f, v = by_half_angle(_phase(index, starts, period), ratio)
        if index[0, 0] < 0 or index[-1, -1] >= len(angle):
            inside = (index >= 0) & (index < len(angle))
            f, v = np.where(inside, f, 0.0), np.where(inside, v, 0.0)
            index = np.clip(index, 0, len(angle) - 1)
        m = angle[index]
        products = (
            np.einsum("ij,ij->i", a, b) for a, b in ((m, f), (f, f), (m, v), (f, v), (v, v))
        )
        mf, ff, mv, fv, vv = products
        return cls(mf, f.sum(axis=1), ff, mv, v.sum(axis=1), fv, vv, period)

    @classmethod
    def joined(cls, parts: list[HalfTurnSums]) -> HalfTurnSums:
        """Return the sums of several groups of starts as one."""
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        return cls(*map(np.concatenate, columns))

    def scale(self, offset: float) -> float:
        """Return by how much larger the measured angle is, by least squares."""
        return float((self.mf - offset * self.f).sum() / self.ff.sum())

    def late(self, offset: float, scale: float) -> Array:
        """Return the number of samples by which each start must be later."""
        residual = self.mv - offset * self.v - scale * self.fv
        return np.asarray(-self.period / scale * residual / self.vv)
