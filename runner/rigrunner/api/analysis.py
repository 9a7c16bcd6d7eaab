"""The contracts of the analysis: outlier rules, fits and compensations."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from math import nan
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.data import Array, Estimate, Mask, Points
    from rigrunner.api.instruments import RigDescription, TorqueInstrument
    from rigrunner.api.uncertainty import MeasurementModel


@dataclass(frozen=True)
class Rejection:
    """One value that a rule rejected, with the numbers that made it do so."""

    index: int
    value: float
    rule: str
    statistic: float
    critical: float


class OutlierRule(Protocol):
    """Finds gross errors in values that should agree."""

    def __call__(self, values: Array) -> Sequence[Rejection]:
        """Return what is rejected of values of shape (n,); the values stay as they are."""
        ...


class Curve(Protocol):
    """A fitted curve."""

    @property
    def formula(self) -> str:
        """The curve as a person writes it, with its parameters' names."""
        ...

    @property
    def names(self) -> Sequence[str]:
        """The names of the coefficients."""
        ...

    @property
    def units(self) -> Sequence[str]:
        """The unit of each coefficient."""
        ...

    @property
    def coefficients(self) -> Array:
        """The estimates, shape (p,)."""
        ...

    @property
    def covariance(self) -> Array:
        """Their covariance, shape (p, p)."""
        ...

    @property
    def dof(self) -> float:
        """Degrees of freedom of the residual."""
        ...

    @property
    def residuals(self) -> Array:
        """Observed minus fitted, shape (n,)."""
        ...

    @property
    def residual_s(self) -> float:
        """The residual standard deviation, in the unit of y."""
        ...

    @property
    def r_squared(self) -> float:
        """The coefficient of determination."""
        ...

    @property
    def valid_x(self) -> tuple[float, float]:
        """The range of x within which the curve may be used."""
        ...

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Return the curve at x and its standard uncertainty (of the curve, not of one more point).

        Raises DataError outside `valid_x`.
        """
        ...


@runtime_checkable
class Spreading(Protocol):
    """What a Curve can have besides: its uncertainty in independent directions."""

    def spread(self, x: Array) -> Array:
        """Return the curve's gradient times a square root of the covariance at x (m,).

        Shape (m, p). The norm of a row is the standard uncertainty there, the product of two rows
        the covariance of the curve at two places. Raises DataError outside `valid_x`.
        """
        ...


@dataclass(frozen=True)
class Candidate:
    """One of the curves that a fit chose from."""

    formula: str
    parameters: int
    """How many coefficients it has."""
    score: float
    """By the criterion, less is better; nan where the curve could not be fitted."""
    residual_s: float
    """The residual standard deviation, in the unit of y; nan where there is none."""
    chosen: bool = False
    problem: str = ""
    """Why the curve could not be fitted."""


@runtime_checkable
class Chosen(Protocol):
    """What a Curve can have besides: the candidates that it was chosen from."""

    @property
    def criterion(self) -> str:
        """What the candidates were compared by, such as 'AICc'."""
        ...

    @property
    def candidates(self) -> Sequence[Candidate]:
        """All that were tried, in the order of the procedure, the chosen one among them."""
        ...


class Fit(Protocol):
    """Fits a curve to points."""

    def __call__(self, points: Points) -> Curve:
        """Return the fitted curve; raise DataError where the points do not allow it."""
        ...


class MotionSource(StrEnum):
    """What a set-point's frequency and phase were taken from."""

    ANGLE = "angle"
    """The angle channel: frequency and phase."""
    TACHO = "tacho"
    """The swing's angular velocity, integrated: frequency and phase."""
    INDEX = "index"
    """One pulse in every turn of the crank: frequency, and phase by the kinematics."""
    ENTERED = "entered"
    """The entered frequency, nothing measured: no phase."""


@dataclass(frozen=True, eq=False, kw_only=True)
class PeakPoint:
    """One set-point with its raw peaks: all that a peak method needs."""

    recording: str
    """Its name; of a point from a `measure` step, that of the measurement."""
    set_frequency_hz: float
    frequency_hz: Estimate
    """Measured; only with `motion` ENTERED it is what was entered, with the doubt it deserves."""
    load_n: float
    peak_nm: Array
    """The raw maximum of each cycle as the paper takes it, shape (cycles,).

    Less the zero reading. One value only: a mean or a maximum whose scatter is not known.
    """
    peak_kept: Mask
    """Which peaks remain after the outlier rule (peak methods), shape (cycles,)."""
    peak_rejections: tuple[Rejection, ...] = ()
    spikes: int = 0
    """How many samples the spike filter replaced."""
    motion: MotionSource = MotionSource.ANGLE

    @property
    def cycles(self) -> int:
        """How many whole cycles were recorded."""
        return len(self.peak_nm)


@dataclass(frozen=True, eq=False, kw_only=True)
class SwingPoint(PeakPoint):
    """One set-point with whole swings: despiked, cut into cycles, gross errors marked.

    The crank phase phi runs over [0, 2 pi) in N equal steps from the middle of the forward stroke
    (theta = 0, rising). Torque is corrected for the zero reading.
    """

    sample_rate_hz: float
    angle_rad: Array
    """Mean swing angle over the kept cycles, shape (N,)."""
    torque_nm: Array
    """Torque of every cycle, resampled on the crank phase, shape (cycles, N)."""
    kept: Mask
    """Which cycles take part in a mean over cycles (waveform methods), shape (cycles,)."""
    waveform_rejections: tuple[Rejection, ...] = ()
    phase_u_rad: float = 0.0
    """Standard uncertainty of the crank phase, in this recording alone; 0 from an angle."""
    phase_common_u_rad: float = 0.0
    """The same, of what is common to all recordings of the rig."""
    alignment_u_s: float = 0.0
    """Standard uncertainty of the time between torque and motion in this recording; 0 from one
    clock."""


@dataclass(frozen=True, eq=False, kw_only=True)
class StartPoint(PeakPoint):
    """Starts from rest at one speed: what stands for cycles here are starts.

    Each peak is the greatest torque in a start's first travel. `set_frequency_hz` and
    `frequency_hz` are turns per second.
    """


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


@dataclass(frozen=True, eq=False)
class CompensatedPoint:
    """What one method says of one set-point."""

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
    """Torque over one swing, for the eye: arrays of shape (N,) over the crank phase."""

    angle_rad: Array
    raw_nm: Array
    no_load_nm: Array
    compensated_nm: Array


@dataclass(frozen=True)
class Check:
    """A named diagnostic: what was found, against what, and what to do."""

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
    """Whether nothing can be decided on the run where it failed."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """What a compensation takes: the prepared points of both runs and what is known of the rig."""

    loaded: tuple[PeakPoint, ...]
    """Of a waveform method they must be SwingPoints: `rigrunner.signal.swings.with_swings`."""
    no_load: tuple[PeakPoint, ...]
    rig: RigDescription
    instrument: TorqueInstrument
    fit: Fit
    """The fit named by the procedure for torque over frequency (`fit:`)."""


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
    """Takes the rig's part out of the measured torque."""

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return torque per set-point of the loaded run; raise DataError if data forbid it."""
        ...
