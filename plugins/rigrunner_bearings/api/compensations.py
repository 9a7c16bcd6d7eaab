"""Compensations: what they take and what they give."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api import (
        Array,
        Check,
        Component,
        Curve,
        Estimate,
        Fit,
        Instrument,
        MeasurementModel,
    )
    from rigrunner_bearings.api.points import PeakPoint, SwingPoint
    from rigrunner_bearings.api.rig import RigDescription


@dataclass(frozen=True, eq=False)
class CompensatedPoint:
    """The result of one method at one set-point."""

    set_frequency_hz: float
    frequency_hz: float
    raw_nm: float
    """What the sensor shows by this method's own reading of it."""
    rig_nm: float
    """The part of the rig in it: raw - torque."""
    torque: Estimate
    components: tuple[Component, ...]
    """The budget; of a point with a model, what the model's propagation gives."""
    trace: Trace | None = None
    model: MeasurementModel | None = None
    """The measurement equation with its inputs, from which torque and budget follow."""
    cycles_used: int | None = None
    """How many cycles are in the torque; None: those whose peaks were kept (peak methods)."""


@dataclass(frozen=True, eq=False)
class Trace:
    """Torque over one swing, for display: arrays of shape (N,) over the crank phase."""

    angle_rad: Array
    raw_nm: Array
    no_load_nm: Array
    compensated_nm: Array


@dataclass(frozen=True, eq=False)
class Sweep:
    """What a compensation takes: the prepared points of both runs and what is known of the rig."""

    loaded: tuple[PeakPoint, ...]
    """Of a waveform method they must be SwingPoints."""
    no_load: tuple[PeakPoint, ...]
    rig: RigDescription
    instrument: Instrument
    fit: Fit
    """The fit named by the procedure for torque over frequency (`fit:`)."""
    apart: bool = False
    """Whether the no-load points are of another run, and none after show what changed since."""


@dataclass(frozen=True, eq=False)
class SwingSweep(Sweep):
    """A sweep of which every point has its whole swings."""

    loaded: tuple[SwingPoint, ...]
    no_load: tuple[SwingPoint, ...]


@dataclass(frozen=True, eq=False)
class Compensation:
    """The outcome of one method over the whole sweep."""

    measurand: str
    """What the number is, in words: 'load-induced starting torque', 'running torque', ..."""
    points: tuple[CompensatedPoint, ...]
    not_applicable: str = ""
    """Why the method cannot be used on this run; then there are no points."""
    curve: Curve | None = None
    parameters: Mapping[str, Estimate] = field(default_factory=dict)
    """What the method learned of the rig, such as J, fn and damping."""
    checks: tuple[Check, ...] = ()
    notes: tuple[str, ...] = ()


class CompensationMethod(Protocol):
    """Subtracts the no-load torque of the rig from the measured torque."""

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return torque per set-point of the loaded run; raise DataError if data forbid it."""
        ...
