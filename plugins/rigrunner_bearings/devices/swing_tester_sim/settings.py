"""Settings of the closed-form rig. The defaults' sources stand with `RigParameters`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api import Angle, Duration, Frequency, Ratio, Settings, Temperature, Torque
from rigrunner.api.settings import AngularVelocity, MomentOfInertia, RotationalDamping
from rigrunner_bearings.devices.simulated.settings import TesterSettings
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from rigrunner_plugins.devices.fields import quantity


class DriveLineSettings(Settings):
    """The swinging mass, and the elastic shaft that drives it."""

    inertia: MomentOfInertia = quantity("0.002324 kg·m²", "inertia behind the transducer", gt=0)
    natural_frequency: Frequency = quantity("400 Hz", "frequency of the torsional resonance", gt=0)
    damping_ratio: Ratio = quantity("5 %", "damping ratio of the torsional resonance", gt=0, lt=1)
    inertia_change_under_load: Ratio = quantity(
        "0 %", "change of the inertia in the loaded run, as with another mandrel", gt=-1
    )


class SupportSettings(Settings):
    """Friction of spindle and supports."""

    friction: Torque = quantity("0.7597 N·m", "friction T0 at rest", ge=0)
    damping: RotationalDamping = quantity(
        "0.3057 N·m·s/rad", "increase b of the friction with speed", ge=0
    )
    slip: Angle = quantity("0.17 deg", "travel d0 in which the friction changes sign", gt=0)
    growth_per_kilonewton: Ratio = quantity("0 %", "increase of T0 under load", ge=0)


class BearingSettings(Settings):
    """Friction of the bearing under test; torques at 1000 N, proportional to the load."""

    starting_torque: Torque = quantity("0.7262 N·m", "greatest torque Ts after a reversal", gt=0)
    kinetic_torque: Torque = quantity("0.64 N·m", "torque Tk while it slides", gt=0)
    slip: Angle = quantity("0.10 deg", "travel db in which the friction changes sign", gt=0)
    weakening: Annotated[
        Literal["slip", "speed"],
        Field(description="whether friction falls from its peak with slip or speed"),
    ] = "slip"
    weakening_slip: Angle = quantity("0.40 deg", "travel ds, for weakening by slip", gt=0)
    stribeck_speed: AngularVelocity = quantity(
        "0.5 rad/s", "Stribeck speed vs, for weakening by speed", gt=0
    )
    zero_load_torque: Torque = quantity("0 N·m", "starting torque without load", ge=0)
    asymmetry: Torque = quantity("0 N·m", "torque that the load adds in one direction, at 1000 N")
    wear: Ratio = quantity("0 %", "increase of both torques in 10 000 cycles under load", gt=-1)
    warming: Temperature = quantity(
        "0 K", "final rise of the temperature, at 1000 N and 10 Hz", ge=0, le=200
    )
    warming_time: Duration = quantity("10 min", "time in which 63 % of the rise occurs", gt=0)


class SwingTesterSimSettings(TesterSettings):
    """The closed-form rig; the defaults are the rig of the paper with ordinary sensors."""

    drive_line: DriveLineSettings = Field(default_factory=DriveLineSettings)
    support: SupportSettings = Field(default_factory=SupportSettings)
    bearing: BearingSettings = Field(default_factory=BearingSettings)

    def parameters(self) -> RigParameters:
        """Return the rig in SI units."""
        drive_line, support, bearing = self.drive_line, self.support, self.bearing
        return RigParameters(
            eccentric_ratio=self.eccentric_ratio,
            inertia_kgm2=drive_line.inertia,
            support_friction_nm=support.friction,
            support_damping_nms=support.damping,
            support_slip_rad=support.slip,
            natural_hz=drive_line.natural_frequency,
            damping_ratio=drive_line.damping_ratio,
            starting_torque_nm=bearing.starting_torque,
            kinetic_torque_nm=bearing.kinetic_torque,
            bearing_slip_rad=bearing.slip,
            weakening_rad=bearing.weakening_slip,
            stribeck=bearing.weakening == "speed",
            stribeck_speed_rad_s=bearing.stribeck_speed,
            loaded_inertia_change=drive_line.inertia_change_under_load,
            support_growth_per_kn=support.growth_per_kilonewton,
            zero_load_torque_nm=bearing.zero_load_torque,
            asymmetry_nm=bearing.asymmetry,
            sensors=self.sensor_parameters(),
        )
