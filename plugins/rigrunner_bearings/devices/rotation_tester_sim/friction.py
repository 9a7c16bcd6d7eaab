"""Friction of a bearing that is turned from rest.

Breakaway torque grows with the logarithm of the time at rest (Dieterich, Journal of Geophysical
Research 77 (1972) 3690). Over the first travel the friction rises exponentially, as in Dahl's
model of 1968, and then weakens to its kinetic value.
"""

from __future__ import annotations

from math import exp, log10
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.devices.rotation_tester_sim.parameters import BenchParameters

SHORTEST_REST_S = 1.0
"""The law has no value at zero."""

SOLVER_POINTS = 20_000
FARTHEST = 20.0
"""Slip lengths within which the peak lies."""


def breakaway_torque_nm(bench: BenchParameters, rest_s: float, turns: float) -> float:
    """Return the expected breakaway torque after a rest, with so many turns since it was new."""
    fresh = bench.fresh_excess * exp(-turns / bench.running_in_turns)
    aged = bench.ageing_nm * log10(max(rest_s, SHORTEST_REST_S))
    return bench.breakaway_torque_nm * (1 + fresh) + aged


def friction_nm(bench: BenchParameters, travel_rad: Array, breakaway_nm: float) -> Array:
    """Return the friction over the travel since the start, shape (n,); its peak is the breakaway.

    It is a(d) + excess b(d) with b > 0, so it stays below the peak everywhere and touches it where
    the excess is the least of (peak - a)/b.
    """
    d = np.linspace(0, FARTHEST * bench.slip_rad, SOLVER_POINTS + 1)[1:]
    rising, weakening = _shape(bench, d)
    excess = ((breakaway_nm - bench.kinetic_torque_nm * rising) / (rising * weakening)).min()
    rising, weakening = _shape(bench, travel_rad)
    torque: Array = rising * (bench.kinetic_torque_nm + excess * weakening)
    return torque


def _shape(bench: BenchParameters, travel_rad: Array) -> tuple[Array, Array]:
    rising = -np.expm1(-travel_rad / bench.slip_rad)
    return rising, np.exp(-travel_rad / bench.weakening_rad)
