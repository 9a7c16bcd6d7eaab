"""A planned run, for an analysis that checks the plan: its recordings and measurements.

The functions of an `AnalysisRecord` get it as a `PlannedRun`, and answer with data: `PlanProblem`,
the names of channels, `ExpectedReading`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.instruments import Instrument
    from rigrunner.api.measurands import LimitedMeasurand
    from rigrunner.api.member import Member
    from rigrunner.api.quantity import Quantity
    from rigrunner.api.steps import Rows


class RecordingAction(Protocol):
    """An action that records channels of one device."""

    @property
    def name(self) -> str:
        """Its name."""
        ...

    @property
    def role(self) -> str:
        """The role of the device."""
        ...

    @property
    def channels(self) -> tuple[str, ...]:
        """Their names in that role."""
        ...

    @property
    def duration_s(self) -> float:
        """How long it lasts."""
        ...

    @property
    def setpoints(self) -> Mapping[str, float]:
        """Set-points of all drives set so far, by 'role.drive', in SI units."""
        ...

    @property
    def units(self) -> Mapping[str, str]:
        """The unit of each channel and drive."""
        ...

    @property
    def cycle_frequency_hz(self) -> float | None:
        """The set frequency of the cyclic motion; None for none."""
        ...

    @property
    def sample_rate_hz(self) -> float | None:
        """As the device states it before it is connected."""
        ...


class PlannedRecording(Protocol):
    """A recording that the run will make."""

    @property
    def record(self) -> RecordingAction:
        """The recorded channels and the set-points."""
        ...

    @property
    def conditions(self) -> Sequence[str]:
        """All channels, 'role.name', that are read with it."""
        ...

    @property
    def coordinates(self) -> Mapping[str, Coordinate]:
        """Its counters and labels."""
        ...

    @property
    def coordinate_units(self) -> Mapping[str, str]:
        """The units of those that have one."""
        ...

    @property
    def in_cycles(self) -> bool:
        """Whether the procedure states its length in cycles, by the key `cycles`."""
        ...


@dataclass(frozen=True)
class PlannedRows:
    """Rows of a table that one step will make."""

    rows: Rows
    coordinates: Mapping[str, Coordinate]


class PlannedLimit(Protocol):
    """A limit of the procedure."""

    @property
    def of(self) -> str:
        """The name of the result."""
        ...

    @property
    def where(self) -> Mapping[str, tuple[Quantity | str, ...]]:
        """The places to which it is restricted, by coordinate."""
        ...

    @property
    def measurand(self) -> LimitedMeasurand | None:
        """Its key `measurand`."""
        ...

    @property
    def highest(self) -> Quantity | None:
        """The upper limit, where it is one number."""
        ...


@dataclass(frozen=True, kw_only=True)
class PlannedRun:
    """Data of a planned run."""

    rig_keys: Mapping[str, Any]
    """The keys under `rig` of the station; `own_keys` reads those of a plugin."""
    instruments: tuple[Instrument, ...]
    recordings: tuple[PlannedRecording, ...] = ()
    rows: tuple[PlannedRows, ...] = ()
    """The rows of tables, by step."""
    devices: Mapping[str, tuple[str, ...]]
    """The names of the channels of each device, by role."""
    cycle_drive: Member | None = None
    """The drive that sets the cycle frequency; None where there is none."""
    limits: tuple[PlannedLimit, ...] = ()
    """The limits of results."""


class StationPart(StrEnum):
    """A part of the file of the station."""

    RIG = "rig"
    INSTRUMENTS = "instruments"


@dataclass(frozen=True, kw_only=True)
class PlanProblem:
    """Why an analysis cannot use the measurements of a run; the run is refused with this place."""

    message: str
    hint: str = ""
    key: tuple[str | int, ...] = ()
    """Its place in the settings of the analysis, or in `of`; () for all of it."""
    of: PlannedRecording | PlannedLimit | StationPart | None = None
    """The step, the limit or the part of the station with that place; None: the settings."""
    at_key: bool = False
    """Whether the place is the last key itself, not the value of that key."""
    needed_by: PlannedRecording | None = None
    """Of a part of the station: the recording that needs it; None: the analysis."""


@dataclass(frozen=True, kw_only=True)
class ExpectedReading:
    """The lowest and highest value that a channel will probably show in a recording, in SI."""

    recording: str
    channel: Member
    low: float
    high: float
    text: str
    """The value in words, before the number, such as 'the lever goes to'."""
