"""Compensations: what a plugin of that kind is, what it takes and what it gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from math import hypot, nan
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.analysis.curves import Curve, Fit
    from rigrunner.api.analysis.points import PeakPoint, SwingPoint
    from rigrunner.api.data import Array, Estimate
    from rigrunner.api.instruments import Instrument
    from rigrunner.api.rig import RigDescription
    from rigrunner.api.uncertainty import MeasurementModel


@dataclass(frozen=True)
class Component:
    """One line of an uncertainty budget (GUM 8): an input, and what it contributes in N·m."""

    name: str
    u: float
    """Its contribution to the standard uncertainty of the torque, in N·m: |sensitivity| input_u."""
    dof: float
    distribution: str
    common: bool
    """True if the error is the same in all points of the run (it does not average out)."""
    value: float = nan
    """The input's estimate; nan where a line of several inputs has none."""
    unit: str = "N·m"
    """Of the input, `value` and `input_u`."""
    input_u: float = nan
    """The input's standard uncertainty."""
    sensitivity: float = nan
    """The torque's change in N·m over the input's; 1 for a line of several inputs."""
    shared: bool = True
    """Whether a line of this name in another result is the same error. False of an error that may
    be another one at each reading: nobody states what two results have of it in common."""


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


class Consequence(StrEnum):
    """What follows from a check."""

    NOTHING = ""
    NOTE = "note"
    """Something was found that moves no result by as much as matters."""
    BUDGET = "budget"
    """What was found has a line of its own in the uncertainty budget."""
    INCONCLUSIVE = "inconclusive"
    """Nothing can be decided on the result."""


@dataclass(frozen=True)
class Bias:
    """By how much what a check found moves a result that is not corrected for it (VIM 2.18)."""

    of: str
    """'mean', or the set-point: '35 Hz'."""
    value: float
    u: float
    unit: str = "N·m"

    @property
    def contribution(self) -> float:
        """The root mean square of what the result may be wrong by: a standard uncertainty."""
        return hypot(self.value, self.u)


@dataclass(frozen=True)
class Check:
    """A named check: its finding, its limit and its advice.

    A method says in `ok` whether it found anything, and in `biases` by how much that moves each of
    its points. What follows from it, the analysis decides; from then on `ok`
    is False only of a check that binds.
    """

    name: str
    ok: bool
    text: str
    advice: str = ""
    value: float | None = None
    """What was found, or the worst of it; None where it is not a number."""
    threshold: float | None = None
    """What it may be at most or at least."""
    unit: str = ""
    """Of both: '1' for a bare number."""
    decisive: bool = False
    """Whether its effect cannot be estimated, so that nothing can be decided where it failed."""
    biases: tuple[Bias, ...] = ()
    """Of each point, in the order of the points; once it was judged, that of the mean first."""
    common: bool = True
    """Whether the biases are of one error, the same in all points: those do not average out."""
    covered_by: tuple[str, ...] = ()
    """Lines of the budget that have a part of the effect already."""
    consequence: Consequence = Consequence.NOTHING


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
