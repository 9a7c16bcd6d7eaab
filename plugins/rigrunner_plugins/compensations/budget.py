"""The uncertainty budget of one starting torque (GUM 4 and 5), each component in N·m.

What is not measured enters as the half-width of a rectangular distribution, over sqrt 3
(GUM 4.3.7).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import Component
from rigrunner.signal.averaging import jackknife
from rigrunner.signal.sensor import undivided
from rigrunner_plugins.compensations.bearing import (
    Reversals,
    bearing_torque,
    replicates,
    reversals,
    starting_torque,
)
from rigrunner_plugins.compensations.identification import Identified, vector, with_vector

if TYPE_CHECKING:
    from rigrunner.api.data import Array
    from rigrunner.api.instruments import TorqueInstrument
    from rigrunner_plugins.compensations.bearing import Pair
    from rigrunner_plugins.compensations.drive_line import DriveLine
    from rigrunner_plugins.compensations.settings import InverseSettings

NONLINEAR_SLOPE = 4.0
"""Greatest slope of a parabolic error curve, in its greatest value over full scale."""

PLACE = 0.1
"""Of what the friction's place makes out: more than either rig model errs by, without noise."""

COARSER = 0.75
"""Of the harmonics: what changes with a quarter fewer of them is not resolved."""


@dataclass(frozen=True, eq=False)
class Budget:
    """Makes the components of every point of a sweep.

    `refiltered` is the rig as learned with the low-pass corner at its upper limit.
    """

    settings: InverseSettings
    instrument: TorqueInstrument
    rig: Identified
    refiltered: Identified

    def components(self, pair: Pair) -> tuple[Component, ...]:
        """Return the components of one point."""
        line, friction = self.rig.line, self.rig.friction
        bearing = bearing_torque(line, friction, pair)
        where = reversals(line, friction, pair.loaded, self.settings.window)
        torque = float(where.torque(bearing))
        return (
            _repeatability(
                "repeatability, loaded", where, replicates(line, bearing, pair.loaded, +1)
            ),
            _repeatability(
                "repeatability, no load", where, replicates(line, bearing, pair.no_load, -1)
            ),
            *self._sensor(torque, pair),
            self._identification(pair),
            _rectangular("low-pass filter", self._refiltered(pair) - torque),
            _rectangular("inertia between the runs", self._inertia(pair)),
            _rectangular("support friction under load", self._support()),
            _rectangular("place of the friction", self._place(pair)),
            _rectangular("finite band", self._band(pair, torque)),
        )

    def _sensor(self, torque: float, pair: Pair) -> tuple[Component, ...]:
        """Return gain of the difference, and of non-linearity what a smooth error curve can differ.

        A constant offset, and drift between the runs, fall out of the mean of both strokes; what
        drifts within half a swing does not.
        """
        accuracy = self.instrument.accuracy
        cycles = min(len(pair.loaded.replicates_nm), len(pair.no_load.replicates_nm))
        return (
            _rectangular("sensor gain", accuracy.gain * torque),
            _rectangular("sensor non-linearity", NONLINEAR_SLOPE * accuracy.nonlinearity * torque),
            _rectangular("sensor drift", accuracy.drift / (2 * cycles)),
            *undivided(self.instrument),
        )

    def _identification(self, pair: Pair) -> Component:
        """Return the part of fn, z, J and share, with their covariance from the no-load sweep."""
        line, u_values = self.rig.line, np.sqrt(np.diag(self.rig.covariance))
        above, below = (
            np.array([self._of(with_vector(line, vector(line) + s), pair) for s in np.diag(step)])
            for step in (u_values, -u_values)
        )
        gradient = (above - below) / (2 * u_values)
        u = sqrt(gradient @ self.rig.covariance @ gradient)
        return Component("resonance, damping, inertia", u, self.rig.dof, "normal", common=True)

    def _refiltered(self, pair: Pair) -> float:
        rig = self.refiltered
        return starting_torque(rig.line, rig.friction, pair, self.settings.window)

    def _inertia(self, pair: Pair) -> float:
        acceleration = self.rig.friction.swing.acceleration_per_hz2 * pair.loaded.frequency_hz**2
        mismatch = self.settings.inertia_mismatch * self.rig.line.inertia_kgm2
        return float(mismatch * np.abs(acceleration).max())

    def _support(self) -> float:
        return self.settings.support_load_dependence * self.rig.friction.level_nm

    def _place(self, pair: Pair) -> float:
        """Return what it may matter that friction follows the load or the drive.

        `share` is learned from the support's friction alone, as one number: a part of the whole
        difference stays open.
        """
        load, drive = (self._of(replace(self.rig.line, share=share), pair) for share in (1.0, 0.0))
        return PLACE * (load - drive)

    def _band(self, pair: Pair, torque: float) -> float:
        line = self.rig.line
        return self._of(replace(line, harmonics=round(COARSER * line.harmonics)), pair) - torque

    def _of(self, line: DriveLine, pair: Pair) -> float:
        return starting_torque(line, self.rig.friction, pair, self.settings.window)


def _rectangular(name: str, half_width: float) -> Component:
    return Component(name, abs(half_width) / sqrt(3), inf, "rectangular", common=True)


def _repeatability(name: str, where: Reversals, without_each: Array) -> Component:
    """Return the jackknife over the cycles of one run: what the torque is without each of them."""
    values = where.torque(without_each)
    return Component(name, jackknife(values), len(values) - 1, "normal", common=False)
