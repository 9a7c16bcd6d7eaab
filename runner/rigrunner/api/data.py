"""Measured data: what comes from devices and what the analysis takes."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rigrunner.api.accuracy import ReadingError
from rigrunner.api.member import channel_of
from rigrunner.api.quantity import Estimate as Estimate  # noqa: PLC0414  (part of the data, without numpy)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.instruments import Instrument
    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.readings import Reading, ReadingLimit
    from rigrunner.api.rig import RigDescription
    from rigrunner.api.verdict import LimitDecision

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Samples(Protocol):
    """Samples of one channel, shape (n,): an Array, or what reads them from a file by slices.

    A recording that is too long for memory has the second. `np.asarray` makes an Array of either.
    """

    def __len__(self) -> int:
        """Return n."""
        ...

    def __getitem__(self, which: slice, /) -> Array:
        """Return those from one index to another, in memory."""
        ...

    def __array__(self) -> NDArray[Any]:
        """Return all of them, in memory."""
        ...


@dataclass(frozen=True, eq=False)
class Block:
    """Consecutive samples of some channels of one device, each of shape (n,)."""

    rate_hz: float
    first_sample: int
    """Counted from the beginning of the stream."""
    monotonic_s: float
    """When the first sample was taken, or this block arrived; it never goes back in a stream."""
    channels: Mapping[str, Array]

    @property
    def samples(self) -> int:
        """How many samples each channel has."""
        return next((len(values) for values in self.channels.values()), 0)


@dataclass(frozen=True, eq=False)
class Points:
    """Values to fit: x, y and, where known, the standard uncertainty of y; all of shape (n,).

    Of k regressors with the names `regressors`, `x` has the shape (n, k): for fits that take them.
    """

    x: Array
    y: Array
    u_y: Array | None = None
    x_unit: str = "Hz"
    y_unit: str = "N·m"
    regressors: tuple[str, ...] = ()
    x_name: str = "f"
    """What formulas and messages call x; of torque over frequency f."""
    y_name: str = "T"


@dataclass(frozen=True, eq=False)
class Recording:
    """One finished recording: channels 'role.name' of shape (n,), on one clock, in SI units."""

    name: str
    rate_hz: float
    started_utc: str
    setpoints: Mapping[str, float]
    channels: Mapping[str, Samples]
    units: Mapping[str, str]
    conditions: Mapping[str, float] = field(default_factory=dict)
    """What the station could read while recording: 'tester.load', 'tester.temperature', ..."""
    coordinates: Mapping[str, Coordinate] = field(default_factory=dict)
    """Counters and labels of the steps around it, by name; see `rigrunner.api.coordinates`."""
    elapsed_s: float | None = None
    """When it began, since the run began `main`; None before that, and where it is not known."""
    cycles: int | None = None
    """How many cycles the device had moved in by then, since the run began `main`; None where
    nothing moves in cycles."""
    written_in: Mapping[str, str] = field(default_factory=dict)
    """Where that is not SI: by drive and coordinate the unit in which the procedure writes it, by
    channel the one in which people see it."""

    @property
    def samples(self) -> int:
        """How many samples each channel has."""
        return next((len(values) for values in self.channels.values()), 0)

    def arrays(self) -> dict[str, Array]:
        """Return all samples of all channels in memory."""
        return {name: np.asarray(values) for name, values in self.channels.items()}


@dataclass(frozen=True)
class Measurement:
    """Single values that a step found at one set-point, in SI units: a row of a table.

    Measurements of one name are the rows of a table, in the order in which they were taken. Values
    of `measure` and `scan` are rows; so are values of `zero` and `record` that have limits.
    """

    name: str
    """Of the table; not unique."""
    utc: str
    """When the step was over."""
    setpoints: Mapping[str, float]
    """Every drive that the procedure had set by then: 'role.drive'."""
    values: Mapping[str, float]
    """By channel, 'role.name': read once, or the mean over the step's duration.

    Of a recording also its limited statistics, by 'role.name.statistic'."""
    units: Mapping[str, str]
    """Of each value and drive, and of coordinates that have one."""
    limits: tuple[ValueLimit, ...] = ()
    """What the values may be, where the procedure says so."""
    recording: str = ""
    """The recording that the values are of; empty where they were read on their own."""
    coordinates: Mapping[str, Coordinate] = field(default_factory=dict)
    """Counters and labels of the steps around it, by name; see `rigrunner.api.coordinates`."""
    elapsed_s: float | None = None
    """When the step was over, since the run began `main`; None before that."""
    cycles: int | None = None
    """How many cycles the device had moved in when the step began, as of a recording."""
    readings: Mapping[str, Reading] = field(default_factory=dict)
    """By channel, 'role.name', readings that are not numbers: a text, a yes or no, an array."""
    expected: tuple[ReadingLimit, ...] = ()
    """What these may be, where the procedure says so."""
    written_in: Mapping[str, str] = field(default_factory=dict)
    """Where that is not SI: by drive and coordinate the unit in which the procedure writes it, by
    channel the one in which people see it."""

    @property
    def decisions(self) -> tuple[LimitDecision, ...]:
        """The decision on each limited value and reading, in the order of the limits."""
        values, readings = self.values, self.readings
        return (
            *(each.decision(values[each.of]) for each in self.limits if each.of in values),
            *(each.decision(readings[each.of]) for each in self.expected if each.of in readings),
        )


@dataclass(frozen=True, eq=False)
class RunData:
    """The data of a run that an analysis can use. The truth of a simulator is not in it."""

    run_id: str
    procedure_id: str
    procedure_revision: str
    procedure_title: str
    station_id: str
    started_utc: str
    ended_utc: str
    outcome: str
    inputs: Mapping[str, str]
    rig: RigDescription
    instruments: Mapping[str, Instrument]
    """The station's register of instruments by channel, torque transducers first."""
    zeros: Mapping[str, float]
    """The zero reading of each zeroed channel; the recordings are stored without correction."""
    recordings: tuple[Recording, ...]
    digest: str = ""
    """SHA-256 over recordings and measurements, by which other files name this run."""
    measurements: tuple[Measurement, ...] = ()
    """The rows of its tables, in order, those out of limits included."""
    people: Mapping[str, str] = field(default_factory=dict)
    """Who did what, by role: 'operator'."""
    approval: Mapping[str, str] = field(default_factory=dict)
    """The state of the procedure when the run began, as in the run's header."""
    imported: Mapping[str, str] = field(default_factory=dict)
    """Of recordings that another program made: by which, and by whose word, as in the header."""
    rig_keys: Mapping[str, Any] = field(default_factory=dict)
    """What the station says of the rig, as it stands there: `own_keys` reads a plugin's keys."""
    recording_zeros: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """By recording, the zero readings in force when it was made, where the run was zeroed again."""
    partners: Mapping[str, RunData] = field(default_factory=dict)
    """The partner runs by name; an analysis is given those that it requires."""

    def reading_errors(self, channel: str, value: float) -> tuple[ReadingError, ...]:
        """Return what readings of a channel up to a value, in the SI unit, may be off by.

        One of which the register says nothing has one line, with an uncertainty of nan. Of a root
        mean square that was kept of a channel, 'role.name.rms', no zero reading is taken off.
        """
        of = channel_of(channel)
        known, zeroed = self.instruments.get(of), of in self.zeros and not channel.endswith(".rms")
        found = known.reading_errors(value, zeroed=zeroed) if known else ()
        return found or (ReadingError(f"reading of {channel}", "each", nan),)

    def readings(self, channel: str, values: Array, zero: float) -> Array:
        """Return values of a channel less a zero reading, in the SI unit, shape (n,).

        They are corrected by the table of the certificate where the register says so.
        """
        known = self.instruments.get(channel)
        return values - zero if known is None else known.corrected(values, zero)

    def zero(self, recording: str, channel: str) -> float:
        """Return the zero reading that belongs to a channel of a recording; 0 without one."""
        return self.recording_zeros.get(recording, {}).get(channel, self.zeros.get(channel, 0.0))
