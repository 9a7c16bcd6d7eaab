"""Friction as elastic-plastic elements in parallel, and the mass on its shaft.

Each element has a state z in [-1, 1] that follows the travel of the load side (Dahl's model of
1968): dz/dt = (v - |v| z)/slip. Torque = size * z. A bearing that must overshoot after a reversal
has two opposed elements of different slip (Bliman and Sorine, Easy-to-use realistic dry friction
models for automatic control, European Control Conference 1995). One that weakens with speed has a
single element whose end values depend on it, |z| -> g(v) = 1 + (Ts/Tk - 1) exp(-|v|/vs) (Canudas de
Wit et al., IEEE Trans. Autom. Control 40(3), 1995, without their bristles' damping).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters

REFERENCE_LOAD_N = 1000.0
TWO_PI = 6.283185307179586

State = tuple[float, float, float, float, float]
"""Twist of the shaft (rad), its rate (rad/s); z of support, bearing's stick, its overshoot."""


@dataclass(frozen=True)
class Mechanism:
    """The coefficients of the equations of motion for one load."""

    stiffness: float
    damping: float
    inertia: float
    viscous: float
    support: float
    stick: float
    overshoot: float
    support_slip: float
    stick_slip: float
    overshoot_slip: float
    weakening: float = 0.0
    """Ts/Tk - 1 of a bearing that weakens with speed; 0 of one that does so with slip."""
    weakening_speed: float = 1.0

    def shaft_torque(self, twist: Array, rate: Array) -> Array:
        """Return what the transducer feels, in N·m, shape (n,)."""
        return self.stiffness * twist + self.damping * rate

    def bearing_torque(self, stick: Array, overshoot: Array) -> Array:
        """Return the bearing's friction in N·m from its elements' states, shape (n,)."""
        return self.stick * stick - self.overshoot * overshoot

    def derivative(self, state: State, velocity: float, acceleration: float) -> State:
        """Return d(state)/dt while the driven end moves so (rad/s, rad/s2)."""
        twist, rate, support, stick, overshoot = state
        v = velocity - rate
        speed = abs(v)
        ends = speed
        if self.weakening:
            ends /= 1 + self.weakening * exp(-speed / self.weakening_speed)
        friction = (
            self.viscous * v + self.support * support + self.stick * stick
            - self.overshoot * overshoot
        )  # fmt: skip
        return (
            rate,
            acceleration - (self.stiffness * twist + self.damping * rate - friction) / self.inertia,
            (v - speed * support) / self.support_slip,
            (v - ends * stick) / self.stick_slip,
            (v - speed * overshoot) / self.overshoot_slip,
        )


def mechanism(rig: OdeParameters, load_n: float) -> Mechanism:
    """Return the equations' coefficients; spring and damper follow from the resonance."""
    angular = TWO_PI * rig.natural_hz
    share = load_n / REFERENCE_LOAD_N
    opposing = 0.0 if rig.stribeck else rig.overshoot_nm
    return Mechanism(
        stiffness=rig.inertia_kgm2 * angular**2,
        damping=2 * rig.damping_ratio * rig.inertia_kgm2 * angular,
        inertia=rig.inertia_kgm2,
        viscous=rig.viscous_nms,
        support=rig.support_friction_nm,
        stick=(rig.kinetic_torque_nm + opposing) * share,
        overshoot=opposing * share,
        support_slip=rig.support_slip_rad,
        stick_slip=rig.stick_slip_rad,
        overshoot_slip=rig.overshoot_slip_rad,
        weakening=rig.overshoot_nm / rig.kinetic_torque_nm if rig.stribeck else 0.0,
        weakening_speed=rig.stribeck_speed_rad_s,
    )
