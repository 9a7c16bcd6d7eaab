"""Measured data: what devices provide and analyses take."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf, nan, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from rigrunner.api.accuracy import ReadingError
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.member import channel_of
from rigrunner.api.quantity import Estimate as Estimate  # noqa: PLC0414  (part of the data, without numpy)
from rigrunner.moved import moved

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.instruments import Instrument
    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.readings import Reading, ReadingLimit
    from rigrunner.api.verdict import LimitDecision

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Samples(Protocol):
    """Samples of one channel, shape (n,): an Array, or a reader of slices of a file.

    Recordings larger than memory have a reader. `np.asarray` makes an Array of either.
    """

    def __len__(self) -> int:
        """Return n."""
        ...

    def __getitem__(self, which: slice, /) -> Array:
        """Return a slice in memory."""
        ...

    def __array__(self) -> NDArray[Any]:
        """Return all samples in memory."""
        ...


@dataclass(frozen=True, eq=False)
class Block:
    """Consecutive samples of some channels of one device, each of shape (n,)."""

    rate_hz: float
    first_sample: int
    """Index of the first sample in the stream."""
    monotonic_s: float
    """Time of the first sample, or of arrival of the block; never decreases in a stream."""
    channels: Mapping[str, Array]

    @property
    def samples(self) -> int:
        """Number of samples per channel."""
        return next((len(values) for values in self.channels.values()), 0)


@dataclass(frozen=True, eq=False)
class Points:
    """Values to fit: x, y and, if known, the standard uncertainty of y; all of shape (n,).

    For k regressors with the names `regressors`, `x` has the shape (n, k).
    """

    x: Array
    y: Array
    u_y: Array | None = None
    x_unit: str = "Hz"
    y_unit: str = "N·m"
    regressors: tuple[str, ...] = ()
    x_name: str = "f"
    """Name of x in formulas and messages, such as f for frequency."""
    y_name: str = "T"
    dof_y: Array | None = None
    """Degrees of freedom of each `u_y`, shape (n,); None if not known."""
    u_x: Array | None = None
    """Standard uncertainty of x from its scatter, shape (n,), for a fit without residuals: those of
    others show it. None for x without scatter, and for several regressors."""


@dataclass(frozen=True, eq=False)
class Recording:
    """A complete recording: channels 'role.name' of shape (n,), on one clock, in SI units."""

    name: str
    rate_hz: float
    started_utc: str
    setpoints: Mapping[str, float]
    channels: Mapping[str, Samples]
    units: Mapping[str, str]
    conditions: Mapping[str, float] = field(default_factory=dict)
    """Values that the station read while recording: 'tester.load', 'tester.temperature', ..."""
    coordinates: Mapping[str, Coordinate] = field(default_factory=dict)
    """Counters and labels of the enclosing steps by name; see `rigrunner.api.coordinates`."""
    elapsed_s: float | None = None
    """Time of its start since the run began `main`; None before `main` and if unknown."""
    cycles: int | None = None
    """Cycles of the device until its start, since the run began `main`; None without cyclic motion.
    """
    written_in: Mapping[str, str] = field(default_factory=dict)
    """Units other than SI: by drive and coordinate the unit in the procedure, by channel the unit
    for display."""

    @property
    def samples(self) -> int:
        """Number of samples per channel."""
        return next((len(values) for values in self.channels.values()), 0)

    def arrays(self) -> dict[str, Array]:
        """Return all samples of all channels in memory."""
        return {name: np.asarray(values) for name, values in self.channels.items()}


@dataclass(frozen=True, slots=True)
class Measurement:
    """Single values of a step at one set-point, in SI units: a row of a table.

    Measurements of one name are the rows of a table, in chronological order. Rows are made by
    `measure` and `scan`, and by `zero` and `record` with limits.
    """

    name: str
    """Name of the table; not unique."""
    utc: str
    """End of the step."""
    setpoints: Mapping[str, float]
    """All drives set so far by the procedure: 'role.drive'."""
    values: Mapping[str, float]
    """By channel, 'role.name': a single reading, or the mean over the duration of the step.

    For a recording also its limited statistics, by 'role.name.statistic'.
    """
    units: Mapping[str, str]
    """Units of each value and drive, and of coordinates with a unit."""
    limits: tuple[ValueLimit, ...] = ()
    """Limits of the values, from the procedure."""
    recording: str = ""
    """The recording of the values; empty for values that were read without one."""
    coordinates: Mapping[str, Coordinate] = field(default_factory=dict)
    """Counters and labels of the enclosing steps by name; see `rigrunner.api.coordinates`."""
    elapsed_s: float | None = None
    """Time of the end of the step since the run began `main`; None before."""
    cycles: int | None = None
    """Cycles of the device until the start of the step, as for a recording."""
    readings: Mapping[str, Reading] = field(default_factory=dict)
    """By channel, 'role.name': readings that are not numbers: texts, booleans, arrays."""
    expected: tuple[ReadingLimit, ...] = ()
    """Expected readings, from the procedure."""
    written_in: Mapping[str, str] = field(default_factory=dict)
    """Units other than SI: by drive and coordinate the unit in the procedure, by channel the unit
    for display."""

    zeros: Mapping[str, ZeroReading] = field(default_factory=dict)
    """The zero reading in force, by channel; the first one of a channel that was zeroed later."""

    @property
    def decisions(self) -> tuple[LimitDecision, ...]:
        """The decision on each limited value and reading, in the order of the limits."""
        values, readings = self.values, self.readings
        return (
            *(limit.decision(values[limit.of]) for limit in self.limits if limit.of in values),
            *(each.decision(readings[each.of]) for each in self.expected if each.of in readings),
        )


def place_of(of: Recording | Measurement) -> dict[str, CoordinateValue]:
    """Return the set-points and coordinates of a recording or row, with time and cycle count."""
    values = {**of.setpoints, **of.coordinates}
    place = {
        name: CoordinateValue.of_si(value, of.units.get(name, ""), of.written_in.get(name, ""))
        for name, value in values.items()
    }
    if of.elapsed_s is not None:
        place["elapsed"] = CoordinateValue(of.elapsed_s, "s")
    if of.cycles is not None:
        place["cycles"] = CoordinateValue(float(of.cycles))
    return place


class ZeroReading(NamedTuple):
    """A zero reading of a channel, in the SI unit."""

    value: float
    number: int = 0
    """Its number among those of the channel in the run: two readings may be equal. 0: not known."""
    u: float | None = None
    """The uncertainty by its scatter (GUM 4.2). Runs of before 0.2 have none."""
    dof: float = inf


@dataclass(frozen=True, eq=False)
class RunData:
    """The data of a run for analyses. The truth of a simulator is not part of it."""

    run_id: str
    procedure_id: str
    procedure_revision: str
    procedure_title: str
    station_id: str
    started_utc: str
    ended_utc: str
    outcome: str
    inputs: Mapping[str, str]
    instruments: Mapping[str, Instrument]
    """The register of instruments of the station by channel, those of DEFAULT_QUANTITY first."""
    zeros: Mapping[str, float]
    """The zero reading of each zeroed channel; stored recordings are uncorrected."""
    recordings: tuple[Recording, ...]
    digest: str = ""
    """SHA-256 of recordings and measurements, by which other files refer to this run."""
    measurements: tuple[Measurement, ...] = ()
    """The rows of its tables, in order, also those out of limits."""
    people: Mapping[str, str] = field(default_factory=dict)
    """Names by role: 'operator'."""
    approval: Mapping[str, str] = field(default_factory=dict)
    """Approval of the procedure at the start of the run, as in the run's header."""
    imported: Mapping[str, str] = field(default_factory=dict)
    """Of imported recordings: the program that made them and who imported them, as in the header.
    """
    rig_keys: Mapping[str, Any] = field(default_factory=dict)
    """The keys under `rig` of the station; `own_keys` reads those of a plugin."""
    recording_zeros: Mapping[str, Mapping[str, ZeroReading]] = field(default_factory=dict)
    """By recording: the zero readings at that time, if the run was zeroed again."""
    partners: Mapping[str, RunData] = field(default_factory=dict)
    """Partner runs by name; an analysis gets those that it requires."""
    zero_counts: Mapping[str, int] = field(default_factory=dict)
    """Number of zero readings by channel."""

    if not TYPE_CHECKING:  # a checker would take any name

        def __getattr__(self, name: str) -> Any:
            """Return a name that has moved from this class; raise AttributeError for any other."""
            return moved(f"{__name__}.RunData", name)(self)

    @property
    def mandrel(self) -> str:
        """What holds the specimen, by the key `mandrel` of the rig; '' where it has none."""
        return str(self.rig_keys.get("mandrel", ""))

    def reading_errors(self, channel: str, value: float) -> tuple[ReadingError, ...]:
        """Return the errors of readings of a channel up to a value, in the SI unit.

        A channel without accuracy in the register has one error with an uncertainty of nan. No zero
        reading is subtracted from a root mean square, 'role.name.rms'; nor is this or a peak to
        peak value corrected by the calibration points, so their greatest deviation is an error.
        """
        member = channel_of(channel)
        instrument = self.instruments.get(member)
        zeroed = member in self.zeros and not channel.endswith(".rms")
        errors = instrument.reading_errors(value, zeroed=zeroed) if instrument else ()
        if not instrument or not errors:
            return (ReadingError(f"reading of {channel}", "each", nan),)
        if instrument.interpolation and channel.endswith((".rms", ".peak_to_peak")):
            u = max(abs(deviation) for _, deviation in instrument.deviations) / sqrt(3)
            errors += (ReadingError(f"deviation of {member}, not corrected", "each", u),)
        return errors

    def zero_error(self, channel: str, zero: ZeroReading) -> ReadingError | None:
        """Return the error of all values of a channel that a zero reading was subtracted from.

        It is one error of all of them, in the SI unit. Where the samples of the zero did not
        scatter, it is the resolution. None for a zero whose scatter is not known.
        """
        if zero.u is None:
            return None
        member = channel_of(channel)
        of_zero = f"of zero{f' {zero.number}' if self.zero_counts.get(member, 1) > 1 else ''} of"
        if zero.u:
            return ReadingError(f"scatter {of_zero} {member}", "offset", zero.u, zero.dof, "t")
        name = f"resolution of {member}"
        for error in self.reading_errors(channel, zero.value):
            if error.name == name:
                return replace(error, name=name.replace("of", of_zero, 1), acts="offset")
        return None

    def readings(self, channel: str, values: Array, zero: float) -> Array:
        """Return values of a channel minus a zero reading, in the SI unit, shape (n,).

        Corrected by the table of the certificate if the register says so.
        """
        instrument = self.instruments.get(channel)
        if instrument is None:
            return values - zero
        return instrument.corrected(values, zero if channel in self.zeros else None)

    def zero(self, recording: str, channel: str) -> float:
        """Return the value of the zero reading of a channel for a recording; 0 without one."""
        zero = self.recording_zeros.get(recording, {}).get(channel)
        return self.zeros.get(channel, 0.0) if zero is None else zero.value

    def zero_of(self, part: Recording | Measurement, channel: str) -> ZeroReading:
        """Return the zero reading of a channel, 'role.name', for a recording or row.

        Its value is 0 without one.
        """
        if isinstance(part, Recording) or part.recording:
            recording = part.name if isinstance(part, Recording) else part.recording
            zeros = self.recording_zeros.get(recording, {})
        else:
            zeros = part.zeros
        return zeros.get(channel) or ZeroReading(self.zeros.get(channel, 0.0))
