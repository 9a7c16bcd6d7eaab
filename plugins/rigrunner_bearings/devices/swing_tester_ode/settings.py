"""Settings of the time-domain rig. The defaults' sources stand with `OdeParameters`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api import Angle, Frequency, Ratio, Settings, Torque
from rigrunner.api.settings import AngularVelocity, MomentOfInertia, RotationalDamping
from rigrunner_bearings.devices.simulated.settings import TesterSettings
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_plugins.devices.fields import quantity


class ShaftSettings(Settings):
    """The swinging mass on its elastic shaft."""

    inertia: MomentOfInertia = quantity("0.00264 kg·m²", "inertia behind the transducer", gt=0)
    natural_frequency: Frequency = quantity(
        "400 Hz", "natural frequency of the mass on the shaft", gt=0
    )
    damping_ratio: Ratio = quantity("5 %", "damping ratio of the mass on the shaft", ge=0.002, lt=1)


class SupportElementSettings(Settings):
    """Friction of spindle and supports: one Dahl element and a viscous damper."""

    friction: Torque = quantity("0.805 N·m", "friction torque of the Dahl element", ge=0)
    slip: Angle = quantity("0.17 deg", "travel in which the friction changes sign", gt=0)
    viscous: RotationalDamping = quantity("0.27 N·m·s/rad", "coefficient of the damper", ge=0)


class BearingElementSettings(Settings):
    """Friction of the bearing under test: two opposed Dahl elements; torques at 1000 N."""

    kinetic_torque: Torque = quantity("0.64 N·m", "difference of the two elements", gt=0)
    overshoot: Torque = quantity("0.1568 N·m", "torque of the opposing, slower element", ge=0)
    stick_slip: Angle = quantity("0.10 deg", "slip length of the faster element", gt=0)
    overshoot_slip: Angle = quantity("0.40 deg", "slip length of the slower element", gt=0)
    weakening: Annotated[
        Literal["slip", "speed"],
        Field(
            description="whether friction falls with slip or speed; with speed there is one element"
        ),
    ] = "slip"
    stribeck_speed: AngularVelocity = quantity(
        "0.5 rad/s", "Stribeck speed, for weakening by speed", gt=0
    )


class SwingTesterOdeSettings(TesterSettings):
    """The time-domain rig; the defaults resemble the rig of the paper with ordinary sensors."""

    shaft: ShaftSettings = Field(default_factory=ShaftSettings)
    support: SupportElementSettings = Field(default_factory=SupportElementSettings)
    bearing: BearingElementSettings = Field(default_factory=BearingElementSettings)

    def parameters(self) -> OdeParameters:
        """Return the rig in SI units."""
        shaft, support, bearing = self.shaft, self.support, self.bearing
        return OdeParameters(
            eccentric_ratio=self.eccentric_ratio,
            inertia_kgm2=shaft.inertia,
            natural_hz=shaft.natural_frequency,
            damping_ratio=shaft.damping_ratio,
            support_friction_nm=support.friction,
            support_slip_rad=support.slip,
            viscous_nms=support.viscous,
            kinetic_torque_nm=bearing.kinetic_torque,
            overshoot_nm=bearing.overshoot,
            stick_slip_rad=bearing.stick_slip,
            overshoot_slip_rad=bearing.overshoot_slip,
            stribeck=bearing.weakening == "speed",
            stribeck_speed_rad_s=bearing.stribeck_speed,
            sensors=self.sensor_parameters(),
        )
