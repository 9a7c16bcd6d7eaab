"""The events of a run in order; the journal consists of them."""

from __future__ import annotations

from collections.abc import Mapping  # noqa: TC003  (read at run time, where records are checked)
from enum import StrEnum
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from msgspec import Struct

from rigrunner.api.coordinates import Coordinate  # noqa: TC001  (read at run time, as above)
from rigrunner.api.limits import ValueLimit  # noqa: TC001  (read at run time, as above)
from rigrunner.api.readings import Reading, ReadingLimit  # noqa: TC001  (read at run time, as above)

if TYPE_CHECKING:
    from rigrunner.api.data import Block


RESUME_RUN = "resume run"
"""The intervention that resumes an interrupted run."""


class Outcome(StrEnum):
    """How a run ended; not the verdict on its results."""

    COMPLETED = "completed"
    STOPPED_AT_LIMIT = "stopped at a limit"
    """A value was out of limits and the procedure stops there: the specimen has failed."""
    ABORTED = "aborted"
    ERROR = "error"


RECORDED = "recorded"
"""The table of statistics of recordings, and of their values with limits."""
CONCLUDED = frozenset({Outcome.COMPLETED, Outcome.STOPPED_AT_LIMIT})
"""Outcomes of runs with a verdict; any other run neither passes nor fails."""


class Event(Struct, frozen=True, kw_only=True, tag_field="event", tag=True, gc=False):
    """Base class: sequence number, monotonic time and time of day."""

    # Without `gc`: an event is data, which never refers back to it, and a run has many.
    seq: int
    monotonic_s: float
    utc: str


class RunStarted(Event, frozen=True, kw_only=True):
    """The rig is connected and the plan begins."""

    run_id: str
    steps: int
    estimated_s: float


class StepStarted(Event, frozen=True, kw_only=True):
    """A step of the plan begins; `recording` is the name of its recording, if any."""

    step: str
    index: int
    action: str
    text: str
    recording: str = ""
    setpoints: Mapping[str, float] = {}
    units: Mapping[str, str] = {}
    limits: tuple[ValueLimit, ...] = ()
    """Limits of the values of the step."""
    coordinates: Mapping[str, Coordinate] = {}
    """Counters and labels of the step and its enclosing steps by name; `units` has their units."""
    written_in: Mapping[str, str] = {}
    """By drive and coordinate: the unit in the procedure, if not SI."""
    expected: tuple[ReadingLimit, ...] = ()
    """Expected readings that are not numbers."""
    cycles: Mapping[str, float] = {}
    """By role: cycles of the device since `main` began; only for steps that read."""


class Samples(Event, frozen=True, kw_only=True):
    """A block of a recording; channel names are 'role.name'."""

    recording: str
    """Name of the recording; '' for samples that are displayed but not kept."""
    block: Block


class Prompt(Event, frozen=True, kw_only=True):
    """A question to a person."""

    step: str
    text: str
    choices: tuple[str, ...] = ()
    expected: str = ""
    """Accepted answers as text; empty for any."""
    picture: str = ""
    """The path of a picture to show; empty for none."""


class Answer(Event, frozen=True, kw_only=True):
    """An answer and who gave it: the operator, or the procedure if unattended."""

    step: str
    text: str
    by: str
    into: str = ""
    """The input of the run that the answer becomes, if any."""


class Note(Event, frozen=True, kw_only=True):
    """A remark in the record: of the procedure, or on a marginal value."""

    step: str
    text: str


class LimitMissed(Note, frozen=True, kw_only=True):
    """A value just recorded is out of limits; the verdict on the run is fail."""


class Alarm(Event, frozen=True, kw_only=True):
    """A problem: an error, an interlock, a device that could not be made safe."""

    source: str
    text: str


class InterlockTripped(Alarm, frozen=True, kw_only=True):
    """The channel of an interlock is out of its range."""

    interlock: str
    does: str
    """The consequence: forbid, pause, abort or make_safe."""
    latency_s: float
    """Longest possible time until detection: since it was last known to be good."""


class InterlockCleared(Note, frozen=True, kw_only=True):
    """The channel of an interlock is in its range again."""

    interlock: str


class MadeSafe(Event, frozen=True, kw_only=True):
    """A drive, or a whole device, was made safe, or could not be."""

    what: str
    """The drive, 'role.drive', or the role of the device."""
    read_back: Mapping[str, float] = {}
    """Read-backs afterwards: 'role.drive' in SI units."""
    units: Mapping[str, str] = {}
    """The unit of each read-back."""
    problems: tuple[str, ...] = ()
    """Why it is not confirmed as safe; empty if the read-back confirms it."""


class Intervention(Event, frozen=True, kw_only=True):
    """An action of a person or a signal: pause, abort, skip, override."""

    action: str
    by: str
    reason: str = ""
    subject: str = ""
    """The subject in a sentence; for an override, the failed check."""


class StepEnded(Event, frozen=True, kw_only=True):
    """A step has ended; `values` are its values in SI units ('tester.torque': 0.01).

    It is `ok` if it was executed, even with values out of limits: see `LimitMissed`.
    """

    step: str
    index: int
    action: str
    ok: bool
    recording: str = ""
    measurement: str = ""
    """The table to which `values` are added as a row, at `setpoints`, for a `measure`."""
    setpoints: Mapping[str, float] = {}
    values: Mapping[str, float] = {}
    statistics: Mapping[str, float] = {}
    """Statistics of the samples of a recording that are kept or have limits, 'role.name.statistic'.
    """
    units: Mapping[str, str] = {}
    readings: Mapping[str, Reading] = {}
    """Readings that are not numbers, by 'role.name'."""
    leaves: int = 0
    """Of a condition: how many of the following steps are skipped."""
    cycles: Mapping[str, float] = {}
    """By role: cycles of the device so far, since `main` began."""
    truth: Mapping[str, float] = {}
    """Truth of a simulator; stored in a group for verification that no analysis reads."""
    scatter: Mapping[str, tuple[float, float]] = {}
    """Of a zero: the standard uncertainty of each value in the SI unit, and its degrees of freedom.
    """


class Scanned(Event, frozen=True, kw_only=True):
    """A point of a scan: the drive was at the set-point and the values were read, in SI units.

    It comes between start and end of the step; the start has the limits.
    """

    step: str
    point: int
    """Index, from 0, in the order of the scan."""
    measurement: str
    """The table to which the values are added."""
    setpoints: Mapping[str, float]
    values: Mapping[str, float]


class RunEnded(Event, frozen=True, kw_only=True):
    """The rig is safe (or alarms say why not) and recording has ended."""

    outcome: Outcome
    reason: str = ""
    read_back: Mapping[str, float] = {}
    """Read-back of each drive after making safe: 'role.drive' in SI units."""
    units: Mapping[str, str] = {}
    """The unit of each read-back."""
    resumable: bool = False
    """Whether it can be resumed once the cause is fixed.

    True if recording failed, or if a device was lost or did not answer.
    """


class RunPlanned(Event, frozen=True, kw_only=True):
    """The run that begins, as in its header; only for the listeners of a station."""

    run_id: str
    folder: str
    """Folder of its files."""
    station: str
    procedure: str
    title: str
    inputs: Mapping[str, str] = {}
    due: Mapping[str, str] = {}
    """By instrument, the day on which its calibration expires: '2027-01-31'."""


class RunFinished(Event, frozen=True, kw_only=True):
    """The run is analysed, sealed and reported; the last event for listeners of a station."""

    outcome: Outcome
    reason: str = ""
    verdict: str = ""
    """'' for none."""
    report: str = ""
    """The path of the report; '' for none."""


@runtime_checkable
class ClosingSink(Protocol):
    """A sink that is notified when no further events come."""

    def close(self) -> None:
        """Release everything; work beyond a few seconds is not waited for."""
        ...


class EventSink(Protocol):
    """Takes the events of a run. If a critical sink raises, the run stops safely."""

    def __call__(self, event: Event) -> None:
        """Take one event; samples can be large, so do not keep them without need."""
        ...
