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
    from rigrunner_plugins.compensations.settings import TemplateInverseSettings

NONLINEAR_SLOPE = 4.0
"""Greatest slope of a parabolic error curve, in its greatest value over full scale."""

METHOD_SHARE = 0.1
"""Of what the compensation depends on where the friction acts; see `_method`."""


@dataclass(frozen=True, eq=False)
class Budget:
    """Makes the components of every point of a sweep.

    `refiltered` is the rig as learned with the low-pass corner at its upper limit.
    """

    settings: TemplateInverseSettings
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
            self._method(pair),
        )

    def _sensor(self, torque: float, pair: Pair) -> tuple[Component, ...]:
        """Gain of the difference; of non-linearity what a smooth error curve can differ by.

        A constant offset, and drift between the runs, fall out of the mean of both strokes; what
        drifts within half a swing does not.
        """
        accuracy = self.instrument.accuracy
        cycles = min(len(pair.loaded.replicates_nm), len(pair.no_load.replicates_nm))
        return (
            _rectangular("sensor gain", accuracy.gain * torque),
            _rectangular("sensor non-linearity", NONLINEAR_SLOPE * accuracy.nonlinearity * torque),
            _rectangular("sensor drift", accuracy.drift / (2 * cycles)),
        )

    def _identification(self, pair: Pair) -> Component:
        """fn, z, J and share as learned from the no-load sweep, with their covariance."""
        values, steps = vector(self.rig.line), np.sqrt(np.diag(self.rig.covariance))
        gradient = np.array(
            [
                (self._at(values + step, pair) - self._at(values - step, pair)) / 2 / step.sum()
                for step in np.diag(steps)
            ]
        )
        u = sqrt(gradient @ self.rig.covariance @ gradient)
        return Component("resonance, damping, inertia", u, self.rig.dof, "normal", common=True)

    def _at(self, values: Array, pair: Pair) -> float:
        line = with_vector(self.rig.line, values)
        return starting_torque(line, self.rig.friction, pair, self.settings.window)

    def _refiltered(self, pair: Pair) -> float:
        rig = self.refiltered
        return starting_torque(rig.line, rig.friction, pair, self.settings.window)

    def _inertia(self, pair: Pair) -> float:
        acceleration = self.rig.friction.swing.acceleration_per_hz2 * pair.loaded.frequency_hz**2
        mismatch = self.settings.inertia_mismatch * self.rig.line.inertia_kgm2
        return float(mismatch * np.abs(acceleration).max())

    def _support(self) -> float:
        return self.settings.support_load_dependence * self.rig.friction.level_nm

    def _method(self, pair: Pair) -> Component:
        """Return what remains between rig models."""
        line, window = self.rig.line, self.settings.window
        sprung, rigid = (
            starting_torque(replace(line, share=share), self.rig.friction, pair, window)
            for share in (1.0, 0.0)
        )
        return _rectangular("method", METHOD_SHARE * (sprung - rigid))


def _rectangular(name: str, half_width: float) -> Component:
    return Component(name, abs(half_width) / sqrt(3), inf, "rectangular", common=True)


def _repeatability(name: str, where: Reversals, without_each: Array) -> Component:
    """Jackknife over the cycles of one run: what the greatest torque does without each of them."""
    values = where.torque(without_each)
    return Component(name, jackknife(values), len(values) - 1, "normal", common=False)
