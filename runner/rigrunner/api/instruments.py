"""What the register says of an instrument, and what the station says of the rig (all SI)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api.settings import (
    Frequency,
    IsoDate,
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
    corner: Annotated[Frequency, Field(gt=0)]


class TorqueAccuracy(Settings):
    """Limits of error of a torque transducer, each half the width of a rectangular distribution."""

    gain: Annotated[Ratio, Field(ge=0)]
    offset: Annotated[Torque, Field(ge=0)]
    drift: Annotated[Torque, Field(ge=0)]
    nonlinearity: Annotated[Ratio, Field(ge=0, description="of full scale")]


class TorqueInstrument(Settings):
    """A torque transducer with its amplifier, as the register has it."""

    channel: Annotated[str, Field(description="role.channel, such as tester.torque")]
    maker: str = ""
    type: str = ""
    serial: str
    certificate: str = ""
    laboratory: str = ""
    calibrated: IsoDate | None = None
    due: IsoDate | None = None
    full_scale: Annotated[Torque, Field(gt=0)]
    accuracy: TorqueAccuracy
    low_pass: LowPass | None = None


class RigDescription(Settings):
    """The rig's geometry and the design values from which a plan predicts the torque.

    `eccentric` and `centre_distance` set the swing: theta_max = asin(eccentric / centre_distance).
    """

    mandrel: str
    eccentric: Annotated[Length, Field(gt=0)]
    centre_distance: Annotated[Length, Field(gt=0)]
    inertia: Annotated[
        MomentOfInertia, Field(gt=0, description="design value, for the plan's prediction")
    ]
    support_friction: Annotated[
        Torque, Field(ge=0, description="design value, for the plan's prediction")
    ]
    support_damping: Annotated[
        RotationalDamping, Field(ge=0, description="design value, for the plan's prediction")
    ]
    swing_radius: Annotated[
        Length | None,
        Field(gt=0, description="radius of the bearing's sliding surface, for mu = T/(F r)"),
    ] = None

    @model_validator(mode="after")
    def _the_bar_swings(self) -> Self:
        if self.eccentric >= self.centre_distance:
            raise ValueError("eccentric must be less than centre_distance, or the bar goes round")
        return self

    @property
    def eccentric_ratio(self) -> float:
        """Lambda = e / L of the oscillating guide bar."""
        return self.eccentric / self.centre_distance
