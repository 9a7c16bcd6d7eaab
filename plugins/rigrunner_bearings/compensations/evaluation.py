"""The starting torque of a pair of runs at the best estimates of all else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_bearings.compensations.bearing import (
    Reversals,
    bearing_torque,
    replicates,
    reversals,
)
from rigrunner_bearings.compensations.noise_bias import noise_bias

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.compensations.bearing import Pair
    from rigrunner_bearings.compensations.identification import Identified


@dataclass(frozen=True, eq=False)
class Evaluated:
    """The torque of a pair, and what led to it."""

    pair: Pair
    bearing_nm: Array
    """Over the swing, shape (n,)."""
    where: Reversals
    without_each_nm: tuple[Array, Array]
    """The same without each cycle of the loaded and of the no-load run, shapes (cycles, n)."""
    maximum_nm: float
    """As it is read from the curve."""
    bias_nm: float
    """By how much noise raises it."""

    @property
    def torque_nm(self) -> float:
        """The result: the maximum less its bias."""
        return self.maximum_nm - self.bias_nm


def evaluate(rig: Identified, pair: Pair, window_rad: float) -> Evaluated:
    """Return the torque of a pair on the rig as it was learned."""
    line, friction = rig.line, rig.friction
    bearing = bearing_torque(line, friction, pair)
    where = reversals(line, friction, pair.loaded, window_rad)
    without = (
        replicates(line, bearing, pair.loaded, +1),
        replicates(line, bearing, pair.no_load, -1),
    )
    noisy = [
        each
        for each, run in zip(without, (pair.loaded, pair.no_load), strict=True)
        if run.of_cycles
    ]
    return Evaluated(
        pair=pair,
        bearing_nm=bearing,
        where=where,
        without_each_nm=without,
        maximum_nm=float(where.torque(bearing)),
        bias_nm=noise_bias(bearing, noisy, where),
    )
