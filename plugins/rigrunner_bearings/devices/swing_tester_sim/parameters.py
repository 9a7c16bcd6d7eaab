"""The closed-form rig as numbers, in SI units."""

from __future__ import annotations

from dataclasses import dataclass, field

from rigrunner_bearings.devices.simulated.parameters import DEG_RAD, SensorParameters


@dataclass(frozen=True, kw_only=True)
class RigParameters:
    """The closed-form rig. Bearing torques are those at 1000 N and proportional to the load.

    The defaults reproduce Wang et al., Machines 2025, 13(11), 976: the inertia from the difference
    of sensor and bearing torque over the acceleration at 35 Hz and 1000 N, the support friction
    from a fit to Table 2, the starting torque from the simulation at friction coefficient 0.07.
    """

    eccentric_ratio: float = 2 / 45
    inertia_kgm2: float = 0.002324
    support_friction_nm: float = 0.7597
    support_damping_nms: float = 0.3057
    support_slip_rad: float = 0.17 * DEG_RAD
    natural_hz: float = 400.0
    damping_ratio: float = 0.05
    starting_torque_nm: float = 0.7262
    kinetic_torque_nm: float = 0.64
    bearing_slip_rad: float = 0.10 * DEG_RAD
    weakening_rad: float = 0.40 * DEG_RAD
    stribeck: bool = False
    """Weaken with speed (Stribeck) instead of with slip."""
    stribeck_speed_rad_s: float = 0.5
    loaded_inertia_change: float = 0.0
    """Relative change of inertia as soon as there is load: another mandrel."""
    support_growth_per_kn: float = 0.0
    """Relative growth of the support friction T0 with load."""
    zero_load_torque_nm: float = 0.0
    """Starting torque of the bearing with no load on it."""
    asymmetry_nm: float = 0.0
    """A torque that load puts on the shaft in one sense, at 1000 N: the directions differ."""
    sensors: SensorParameters = field(default_factory=SensorParameters)
