"""The support's friction, as the no-load sweep shows it, moved to where the load really is.

No friction law: a dry part that depends on the way since the reversal, as presliding friction does
(Dahl, 1968, and all its kin), and what grows with speed. What they look like is measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.compensations.swing import at_same_distance, strokes

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.compensations.swing import Stroke, Swing


ROUNDS = 3
"""The growth is a part of the dry friction, which is what is left without it."""

SMALL = 0.02
"""A growth, to see what it does."""


@dataclass(frozen=True, eq=False)
class SupportFriction:
    """Friction torque over the swing: dry (1 + growth |v|) + viscous v, at the load's velocity v.

    `slow_nm` is the dry part over the drive's phase, shape (n,), while the coupling twists by
    `reference_twist_rad` (n,), that of a slow swing. `growth_s` is in s/rad, `viscous_nms` in
    N·m·s/rad. `dry_nm` and `growth_nm_per_hz`, shape (n,), are the line over frequency that was
    measured over the drive's phase.
    """

    swing: Swing
    reference_twist_rad: Array
    dry_nm: Array
    growth_nm_per_hz: Array
    slow_nm: Array
    growth_s: float
    viscous_nms: float

    def torque(self, frequency_hz: float, twist_rad: Array, share: float) -> Array:
        """Return the friction torque if the load lags the drive by the twist, shape (n,).

        `share` is how much of a twist the friction takes part in.
        """
        load = self.swing.angle_rad - share * twist_rad
        dry = at_same_distance(self.slow_nm, _slow_strokes(self, share), load)
        velocity = self.swing.velocity_per_hz * frequency_hz
        n = len(twist_rad)
        derivative = 2j * np.pi * frequency_hz * np.arange(n // 2 + 1)
        twist_rate = np.fft.irfft(np.fft.rfft(twist_rad) * derivative, n)
        return self._at_speed(dry, velocity - share * twist_rate)

    def _at_speed(self, dry_nm: Array, velocity: Array) -> Array:
        return dry_nm * (1 + self.growth_s * np.abs(velocity)) + self.viscous_nms * velocity

    @cached_property
    def _untwisted_nm(self) -> Array:
        """The dry part where no twist takes part: needed for each change, and always the same."""
        drive = self.swing.angle_rad
        return at_same_distance(self.slow_nm, strokes(drive), drive)

    @cached_property
    def grown(self) -> tuple[Array, Array]:
        """What the dry part grows by as it becomes greater, over that, shapes (n,).

        With the way over which it builds up, as bristles of the same stiffness do, and without.
        """
        longer = np.empty_like(self.dry_nm)
        for stroke in strokes(self.swing.angle_rad):
            torque = self.dry_nm[stroke.index]
            before = stroke.distance_rad / (1 + SMALL)
            later = (1 + SMALL) * np.interp(before, stroke.distance_rad, torque)
            longer[stroke.index] = (later - torque) / SMALL
        return longer, self.dry_nm

    def measured_torque(self, frequency_hz: float, twist_rad: Array, share: float) -> Array:
        """Return the friction torque of the sweep itself at a frequency, shape (n,).

        Its shape is the measured one; only the twist's part is modelled.
        """
        measured = self.dry_nm + frequency_hz * self.growth_nm_per_hz
        return np.asarray(measured + share * self.change(frequency_hz, twist_rad))

    def change(self, frequency_hz: float, twist_rad: Array) -> Array:
        """Return how much the friction torque differs if all of it takes part, shape (n,)."""
        untwisted = self._at_speed(self._untwisted_nm, self.swing.velocity_per_hz * frequency_hz)
        return self.torque(frequency_hz, twist_rad, 1.0) - untwisted


def make_friction(
    swing: Swing, reference_twist_rad: Array, dry_nm: Array, growth_nm_per_hz: Array, best_hz: float
) -> SupportFriction:
    """Return the friction whose torque is dry + f growth at the reference twist, arrays (n,).

    The growth is put down to speed in the two ways that it can have: friction that builds up over
    the same way as the dry part, and a viscous torque, there at once. Least squares over the swing
    gives the coefficient of each. The sum is known best at one frequency; the dry part as it is
    there, less that growth, carries less noise than the line prolonged to rest.
    """
    velocity = swing.velocity_per_hz
    measured, dry = dry_nm + best_hz * growth_nm_per_hz, dry_nm
    growth = viscous = 0.0
    for _ in range(ROUNDS):
        basis = np.stack([np.abs(velocity) * dry, velocity], axis=1)
        (growth, viscous), *_ = np.linalg.lstsq(basis, growth_nm_per_hz, rcond=None)
        dry = (measured - viscous * velocity * best_hz) / (1 + growth * np.abs(velocity) * best_hz)
    return SupportFriction(
        swing,
        reference_twist_rad,
        dry_nm,
        growth_nm_per_hz,
        slow_nm=dry,
        growth_s=float(growth),
        viscous_nms=float(viscous),
    )


@lru_cache(maxsize=16)
def _slow_strokes(friction: SupportFriction, share: float) -> tuple[Stroke, Stroke]:
    """Return the strokes of a slow swing: a sweep needs the same few at each frequency."""
    return strokes(friction.swing.angle_rad - share * friction.reference_twist_rad)
