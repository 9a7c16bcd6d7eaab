"""What is known of a rig that swings or turns bearings: geometry, design values, limits of error.

The compensations declare these keys, and with them a station may have them under `rig`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, ValidationError, model_validator

from rigrunner.api import (
    Angle,
    DataError,
    Force,
    Frequency,
    Length,
    PlainText,
    Ratio,
    Settings,
    Torque,
)
from rigrunner.api.instruments import TORQUE
from rigrunner.api.settings import MomentOfInertia, RotationalDamping, own_keys

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api import Instrument, RunData
    from rigrunner.api.planned import PlannedRun

_STAND_IN = {
    "mandrel": "none",
    "eccentric": "2 mm",
    "centre_distance": "45 mm",
    "inertia": "0.002 kg·m²",
    "support_friction": "0.7 N·m",
    "support_damping": "0.3 N·m·s/rad",
}


def refuse_growth_without_limit(growth: float | None, limit: float | None) -> None:
    """Raise ValueError for a growth of the support's friction of which no error is known."""
    if growth is not None and limit is None:
        raise ValueError(
            "support_load_growth needs support_load_dependence, the limit of its error"
        )


class SupportUnderLoad(Settings):
    """Friction that a load adds to the support, measured with a bearing of known friction.

    `rigrunner support-friction` prints the entry. At other loads it is scaled in proportion.
    """

    source: Annotated[
        PlainText, Field(min_length=1, max_length=80, description="the run, and the certificate")
    ]
    load: Annotated[Force, Field(gt=0, description="load under which it was measured")]
    torque: Annotated[
        Torque, Field(description="torque that the load adds where the starting torque is read")
    ]
    u: Annotated[Torque, Field(ge=0, description="its standard uncertainty")]
    degrees_of_freedom: Annotated[
        float | None, Field(ge=1, description="degrees of freedom of u; if omitted, there are many")
    ] = None


class Scatter(Settings):
    """A standard deviation from a study."""

    u: Annotated[Torque, Field(ge=0, description="the standard deviation of one result")]
    degrees_of_freedom: Annotated[
        float, Field(ge=1, description="its degrees of freedom, from the study")
    ]


class NamedStudy(Settings):
    """A gauge study of this rig; `rigrunner gauge-rr` prints the entry."""

    source: Annotated[
        PlainText, Field(min_length=1, max_length=80, description="the study: its date or report")
    ]
    between_mountings: Annotated[
        Scatter | None,
        Field(description="the study's repeatability, where each trial was mounted again"),
    ] = None
    reproducibility: Annotated[
        Scatter | None, Field(description="scatter between operators, with their interaction")
    ] = None


class RigDescription(Settings):
    """The description of the rig; each key is needed only by the analyses that use it.

    `eccentric` and `centre_distance` set the swing: theta_max = asin(eccentric / centre_distance).
    """

    mandrel: PlainText = ""
    """The mounted mandrel; a no-load run must have the same one."""
    eccentric: Annotated[Length | None, Field(gt=0)] = None
    """The crank's radius e."""
    centre_distance: Annotated[Length | None, Field(gt=0)] = None
    """The distance L between the crank's axis and the bearing's."""
    inertia: Annotated[
        MomentOfInertia | None, Field(gt=0, description="design value, for the plan's prediction")
    ] = None
    support_friction: Annotated[
        Torque | None, Field(ge=0, description="design value, for the plan's prediction")
    ] = None
    support_damping: Annotated[
        RotationalDamping | None, Field(ge=0, description="design value, for the plan's prediction")
    ] = None
    swing_radius: Annotated[
        Length | None,
        Field(gt=0, description="radius of the bearing's sliding surface, for mu = T/(F r)"),
    ] = None
    natural_frequency: Annotated[
        Frequency | None,
        Field(gt=0, description="frequency of the torsional resonance when the rig was healthy"),
    ] = None
    index_phase: Annotated[
        Angle,
        Field(description="crank phase at which the index pulse rises; 0 is the forward middle"),
    ] = 0.0
    phase_tolerance: Annotated[
        Angle,
        Field(ge=0, description="limit of error of the crank phase, if an index or tacho gives it"),
    ] = math.pi / 180

    angle_tolerance: Annotated[
        Ratio, Field(ge=0, description="limit of error of the scale of the angle channel")
    ] = 0.005
    load_tolerance: Annotated[
        Ratio,
        Field(ge=0, description="limit of error of the load; by default class 0.5 of ISO 7500-1"),
    ] = 0.005
    gauge_study: Annotated[
        NamedStudy | None,
        Field(description="gauge study; the scatter of mountings and operators is in every budget"),
    ] = None
    inertia_mismatch: Annotated[
        Ratio | None,
        Field(ge=0, description="limit of the difference of the inertia between the two runs"),
    ] = None
    support_load_dependence: Annotated[
        Ratio | None,
        Field(ge=0, description="limit of the change of the support's friction with the load"),
    ] = None
    support_load_growth: Annotated[
        Ratio | None,
        Field(
            gt=-1,
            description="measured increase of the support's friction with the load; "
            "support_load_dependence is then the limit of its error",
        ),
    ] = None
    support_under_load: Annotated[
        SupportUnderLoad | None,
        Field(description="measured friction that the load adds to the support"),
    ] = None
    support_drift: Annotated[
        Ratio | None,
        Field(
            ge=0,
            description="limit of the change of the support's dry friction between the no-load "
            "run and the loaded one, such as with temperature",
        ),
    ] = None
    support_load: Annotated[
        Force | None,
        Field(
            gt=0,
            description="load for which support_load_growth and support_load_dependence are "
            "stated; at other loads they are scaled in proportion",
        ),
    ] = None
    support_load_source: Annotated[
        PlainText,
        Field(max_length=80, description="source of both: a measurement or data sheet"),
    ] = ""

    @model_validator(mode="after")
    def _states_a_limit(self) -> Self:
        refuse_growth_without_limit(self.support_load_growth, self.support_load_dependence)
        if self.support_under_load is not None and self.support_load_dependence is not None:
            raise ValueError(
                "support_under_load was measured: support_load_dependence does not go with it"
            )
        return self

    @model_validator(mode="after")
    def _the_bar_swings(self) -> Self:
        if self.swings and self.eccentric_ratio >= 1:
            raise ValueError("eccentric must be less than centre_distance, or the bar goes round")
        return self

    @property
    def swings(self) -> bool:
        """Whether the swing is known."""
        return self.eccentric is not None and self.centre_distance is not None

    @property
    def eccentric_ratio(self) -> float:
        """Lambda = e / L of the oscillating guide bar; raise DataError where it is not known."""
        if self.eccentric is None or self.centre_distance is None:
            raise DataError(
                "the geometry of the swing is not in the station",
                hint="enter eccentric and centre_distance under its 'rig'",
            )
        return self.eccentric / self.centre_distance


def rig_of(run: RunData) -> RigDescription:
    """Return what the station of a run says of the rig."""
    return own_keys(RigDescription, run.rig_keys)


def planned_rig(planned: PlannedRun) -> RigDescription:
    """Return what the station says of the rig; a stand-in where that is wrong, as `check` tells."""
    try:
        return own_keys(RigDescription, planned.rig_keys)
    except ValidationError:
        return RigDescription.model_validate(_STAND_IN)


def torque_instruments(register: Iterable[Instrument]) -> dict[str, Instrument]:
    """Return the torque transducers of a register, by channel."""
    transducers = (instrument for instrument in register if instrument.quantity == TORQUE)
    return {transducer.channel: transducer for transducer in transducers}
