"""The time-domain rig as numbers, in SI units."""

from __future__ import annotations

from dataclasses import dataclass, field

from rigrunner_bearings.devices.simulated.parameters import DEG_RAD, SensorParameters


@dataclass(frozen=True, kw_only=True)
class OdeParameters:
    """The time-domain rig. Bearing torques are those at 1000 N and proportional to the load.

    The bearing slides at the kinetic torque. The overshoot before that is chosen for a peak of
    0.7262 N·m, the starting torque of Wang et al., Machines 2025, 13(11), 976. Inertia, support
    friction and viscous damping are least squares of this model to its Table 2.
    """

    eccentric_ratio: float = 2 / 45
    inertia_kgm2: float = 0.00264
    natural_hz: float = 400.0
    damping_ratio: float = 0.05
    support_friction_nm: float = 0.805
    support_slip_rad: float = 0.17 * DEG_RAD
    viscous_nms: float = 0.27
    kinetic_torque_nm: float = 0.64
    overshoot_nm: float = 0.1568
    stick_slip_rad: float = 0.10 * DEG_RAD
    overshoot_slip_rad: float = 0.40 * DEG_RAD
    stribeck: bool = False
    """Weaken with speed (Stribeck) instead of with slip: the overshoot is that at rest."""
    stribeck_speed_rad_s: float = 0.5
    sensors: SensorParameters = field(default_factory=SensorParameters)
