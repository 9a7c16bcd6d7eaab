"""The simulated bench as numbers, in SI units."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

from rigrunner_bearings.devices.simulated.parameters import DEG_RAD, SensorParameters


@dataclass(frozen=True, kw_only=True)
class BenchParameters:
    """A bearing on a slow drive, torques without load. All values are chosen, none is published.

    They lie where a bearing of the paper's size may lie by AS14101 (0.0282 N·m to 0.9039 N·m).
    """

    breakaway_torque_nm: float = 0.30
    """Of a bearing that is run in, after one second of rest."""
    ageing_nm: float = 0.015
    """What each tenfold longer rest adds."""
    kinetic_torque_nm: float = 0.22
    slip_rad: float = 0.05 * DEG_RAD
    """In which the friction rises."""
    weakening_rad: float = 0.5 * DEG_RAD
    """In which it falls from its peak."""
    scatter: float = 0.03
    """Standard deviation between starts, relative."""
    fresh_excess: float = 0.30
    """By which a new bearing's breakaway torque is higher."""
    running_in_turns: float = 0.5
    """In which 63 % of that goes."""
    friction_arm_m: float = 0.0005
    """Kinetic torque that a load adds, over the load."""
    fixture_friction_nm: float = 0.004
    inertia_kgm2: float = 0.0005
    acceleration_rad_s2: float = 0.5
    sensors: SensorParameters = field(default_factory=SensorParameters)

    def under_load(self, load_n: float) -> Self:
        """Return the bench with a load: all friction of the bearing grows by the same factor."""
        factor = 1 + self.friction_arm_m * load_n / self.kinetic_torque_nm
        return replace(
            self,
            breakaway_torque_nm=factor * self.breakaway_torque_nm,
            ageing_nm=factor * self.ageing_nm,
            kinetic_torque_nm=factor * self.kinetic_torque_nm,
        )
