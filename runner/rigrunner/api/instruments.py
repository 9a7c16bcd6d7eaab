"""What the register says of an instrument, and what the station says of the rig (all SI)."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api.settings import (
    Angle,
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
    """The filter's characteristic."""
    order: Annotated[int, Field(ge=1, le=8)] = 2
    """Its order."""
    corner: Annotated[Frequency, Field(gt=0)]
    """Where its gain is down by 3 dB."""


class TorqueAccuracy(Settings):
    """Limits of error of a torque transducer, each half the width of a rectangular distribution."""

    gain: Annotated[Ratio, Field(ge=0)]
    """Of the reading."""
    offset: Annotated[Torque, Field(ge=0)]
    """Of the zero, before it is taken out by a zero step."""
    drift: Annotated[Torque, Field(ge=0)]
    """Of the zero, in the course of a run."""
    nonlinearity: Annotated[Ratio, Field(ge=0, description="of full scale")]


class TorqueInstrument(Settings):
    """A torque transducer with its amplifier, as the register has it."""

    channel: Annotated[str, Field(description="role.channel, such as tester.torque")]
    maker: str = ""
    """Who made it."""
    type: str = ""
    """The maker's designation."""
    serial: str
    """Its serial number."""
    certificate: str = ""
    """The number of its calibration certificate."""
    laboratory: str = ""
    """Who calibrated it."""
    calibrated: IsoDate | None = None
    """When it was calibrated."""
    due: IsoDate | None = None
    """When it is to be calibrated again."""
    full_scale: Annotated[Torque, Field(gt=0)]
    """Its nominal torque."""
    accuracy: TorqueAccuracy
    low_pass: LowPass | None = None
    """Methods that undo the filter need it."""


class RigDescription(Settings):
    """The rig's geometry and the design values from which a plan predicts the torque.

    `eccentric` and `centre_distance` set the swing: theta_max = asin(eccentric / centre_distance).
    """

    mandrel: str
    """Which mandrel is mounted; a no-load run must have had the same."""
    eccentric: Annotated[Length, Field(gt=0)]
    """The crank's radius e."""
    centre_distance: Annotated[Length, Field(gt=0)]
    """The distance L between the crank's axis and the bearing's."""
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
    natural_frequency: Annotated[
        Frequency | None,
        Field(gt=0, description="of the torsional resonance when the rig was in order"),
    ] = None
    index_phase: Annotated[
        Angle,
        Field(description="crank phase at which the index pulse rises; 0 is the forward middle"),
    ] = 0.0
    phase_tolerance: Annotated[
        Angle, Field(ge=0, description="of the crank phase, where index or tacho stand for it")
    ] = math.pi / 180

    @model_validator(mode="after")
    def _the_bar_swings(self) -> Self:
        if self.eccentric >= self.centre_distance:
            raise ValueError("eccentric must be less than centre_distance, or the bar goes round")
        return self

    @property
    def eccentric_ratio(self) -> float:
        """Lambda = e / L of the oscillating guide bar."""
        return self.eccentric / self.centre_distance
