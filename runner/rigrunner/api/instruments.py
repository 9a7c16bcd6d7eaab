"""What the register says of an instrument, and what the station says of the rig (all SI)."""

from __future__ import annotations

from datetime import date
from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api.settings import (
    Frequency,
    Length,
    MomentOfInertia,
    Ratio,
    RotationalDamping,
    Settings,
    Torque,
)


class LowPass(Settings):
    """The filter between transducer and converter."""

    type: Literal["butterworth"] = "butterworth"
    order: Annotated[int, Field(ge=1, le=8)] = 2
    corner: Frequency


class TorqueAccuracy(Settings):
    """Limits of error of a torque transducer, each half the width of a rectangular distribution."""

    gain: Ratio
    offset: Torque
    drift: Torque
    nonlinearity: Annotated[Ratio, Field(description="of full scale")]


class TorqueInstrument(Settings):
    """A torque transducer with its amplifier, as the register has it."""

    channel: Annotated[str, Field(description="role.channel, such as tester.torque")]
    maker: str = ""
    type: str = ""
    serial: str
    certificate: str = ""
    laboratory: str = ""
    calibrated: date | None = None
    due: date | None = None
    full_scale: Torque
    accuracy: TorqueAccuracy
    low_pass: LowPass | None = None


class RigDescription(Settings):
    """The rig's geometry and the design values from which a plan predicts the torque.

    `eccentric` and `centre_distance` set the swing: theta_max = asin(eccentric / centre_distance).
    """

    mandrel: str
    eccentric: Length
    centre_distance: Length
    inertia: Annotated[
        MomentOfInertia, Field(description="design value, for the plan's prediction")
    ]
    support_friction: Annotated[
        Torque, Field(description="design value, for the plan's prediction")
    ]
    support_damping: Annotated[
        RotationalDamping, Field(description="design value, for the plan's prediction")
    ]
    swing_radius: Annotated[
        Length | None,
        Field(description="radius of the bearing's sliding surface, for mu = T/(F r)"),
    ] = None

    @property
    def eccentric_ratio(self) -> float:
        """Lambda = e / L of the oscillating guide bar."""
        return self.eccentric / self.centre_distance
