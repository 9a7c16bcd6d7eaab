"""The support's friction, as the no-load sweep shows it, moved to where the load really is.

No friction law: a dry part that depends on the way since the reversal, as presliding friction does
(Dahl, 1968, and all its kin), and a part that grows with speed. What they look like is measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_plugins.compensations.swing import at_same_distance

if TYPE_CHECKING:
    from rigrunner.api.data import Array
    from rigrunner_plugins.compensations.swing import Swing


@dataclass(frozen=True, eq=False)
class SupportFriction:
    """Friction torque over the drive's swing, arrays of shape (n,): dry + |velocity| viscous."""

    swing: Swing
    dry_nm: Array
    viscous_nms: Array

    @property
    def level_nm(self) -> float:
        """The dry friction of a stroke under way, in N·m: the median of its magnitude."""
        return float(np.median(np.abs(self.dry_nm)))

    def torque(self, frequency_hz: float, twist_rad: Array) -> Array:
        """Return the friction torque if the load lags the drive by the twist, shape (n,)."""
        drive = self.swing.angle_rad
        load = drive - twist_rad
        speed = np.abs(self.swing.velocity_per_hz * frequency_hz - _rate(twist_rad, frequency_hz))
        dry = at_same_distance(self.dry_nm, drive, load)
        return dry + speed * at_same_distance(self.viscous_nms, drive, load)

    def change(self, frequency_hz: float, twist_rad: Array) -> Array:
        """Return how much the twist changes the friction torque, shape (n,)."""
        rigid = np.zeros_like(twist_rad)
        return self.torque(frequency_hz, twist_rad) - self.torque(frequency_hz, rigid)


def make_friction(swing: Swing, dry_nm: Array, growth_nm_per_hz: Array) -> SupportFriction:
    """Return the friction whose torque is dry + f growth if nothing twists, arrays (n,).

    The growth is put down to speed, with the two shapes that it can have: that of the dry part
    (friction that builds up over the same way) and that of the direction (a viscous torque, there
    at once). Least squares over the swing gives the coefficient of each.
    """
    speed = np.abs(swing.velocity_per_hz)
    direction = np.sign(swing.velocity_per_hz)
    basis = np.stack([speed * dry_nm, speed * direction], axis=1)
    (like_dry, plain), *_ = np.linalg.lstsq(basis, growth_nm_per_hz, rcond=None)
    return SupportFriction(swing, dry_nm, like_dry * dry_nm + plain * direction)


def _rate(values: Array, frequency_hz: float) -> Array:
    """Return the time derivative of a periodic waveform, shape (n,)."""
    n = len(values)
    angular = 2j * np.pi * frequency_hz * np.arange(n // 2 + 1)
    return np.fft.irfft(np.fft.rfft(values) * angular, n)
