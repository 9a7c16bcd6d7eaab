"""The events of a run, in the order in which they happen; the journal of all that matters."""

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
"""The intervention with which an interrupted run is resumed."""


class Outcome(StrEnum):
    """How a run ended; not to be confused with the verdict on what it measured."""

    COMPLETED = "completed"
    STOPPED_AT_LIMIT = "stopped at a limit"
    """A value was out of its limits where the procedure says to stop: the specimen has failed."""
    ABORTED = "aborted"
    ERROR = "error"


RECORDED = "recorded"
"""The table of what is found of the samples of recordings: statistics, and values with limits."""
CONCLUDED = frozenset({Outcome.COMPLETED, Outcome.STOPPED_AT_LIMIT})
"""How a run ends that has a verdict: any other neither passes nor fails."""


class Event(Struct, frozen=True, kw_only=True, tag_field="event", tag=True):
    """The base: sequence number, monotonic and wall time."""

    seq: int
    monotonic_s: float
    utc: str


class RunStarted(Event, frozen=True, kw_only=True):
    """The rig is connected and the plan begins."""

    run_id: str
    steps: int
    estimated_s: float


class StepStarted(Event, frozen=True, kw_only=True):
    """A step of the plan begins; `recording` names the recording that it makes, if it does."""

    step: str
    index: int
    action: str
    text: str
    recording: str = ""
    setpoints: Mapping[str, float] = {}
    units: Mapping[str, str] = {}
    limits: tuple[ValueLimit, ...] = ()
    """What the values may be that the step finds."""
    coordinates: Mapping[str, Coordinate] = {}
    """Counters and labels of the step and those around it, by name; `units` has their units."""
    written_in: Mapping[str, str] = {}
    """By drive and coordinate, the unit in which the procedure writes it, where it is not SI."""
    expected: tuple[ReadingLimit, ...] = ()
    """What the readings may be that are no numbers."""
    cycles: Mapping[str, float] = {}
    """By role, how many cycles its device had moved in since `main` began; of a step that reads."""


class Samples(Event, frozen=True, kw_only=True):
    """A block of a recording; channel names are 'role.name'."""

    recording: str
    """Its name; '' of one of which no samples are kept: to be looked at while it lasts."""
    block: Block


class Prompt(Event, frozen=True, kw_only=True):
    """A person is asked something."""

    step: str
    text: str
    choices: tuple[str, ...] = ()
    expected: str = ""
    """What is allowed as an answer, in words; empty where anything is."""
    picture: str = ""
    """The path of a picture to show; empty for none."""


class Answer(Event, frozen=True, kw_only=True):
    """What was answered, and by whom: the operator, or the procedure's unattended answer."""

    step: str
    text: str
    by: str
    into: str = ""
    """The name of the run's input that the answer becomes, if it does."""


class Note(Event, frozen=True, kw_only=True):
    """A remark for those who read the record: of the procedure, or on a marginal value."""

    step: str
    text: str


class LimitMissed(Note, frozen=True, kw_only=True):
    """A value that was just put on record is out of its limits; the verdict on the run is fail."""


class Alarm(Event, frozen=True, kw_only=True):
    """Something is wrong: an error, an interlock, a device that could not be made safe."""

    source: str
    text: str


class InterlockTripped(Alarm, frozen=True, kw_only=True):
    """The channel of an interlock is not what it should be."""

    interlock: str
    does: str
    """What follows: forbid, pause, abort or make_safe."""
    latency_s: float
    """How long it may have been so before it was detected: since it was last known to be good."""


class InterlockCleared(Note, frozen=True, kw_only=True):
    """The channel of an interlock is again what it should be."""

    interlock: str


class MadeSafe(Event, frozen=True, kw_only=True):
    """A drive, or a whole device, was brought to its safe state, or could not be."""

    what: str
    """The drive, 'role.drive', or the device's role."""
    read_back: Mapping[str, float] = {}
    """What was read back afterwards: 'role.drive' in SI units."""
    problems: tuple[str, ...] = ()
    """Why it does not count as safe; empty where the read-back confirms it."""


class Intervention(Event, frozen=True, kw_only=True):
    """A person or a signal interfered: pause, abort, skip, override."""

    action: str
    by: str
    reason: str = ""
    subject: str = ""
    """What it is about, in a sentence: of an override what stood against the run."""


class StepEnded(Event, frozen=True, kw_only=True):
    """A step is over; `values` holds what it measured, in SI units ('tester.torque': 0.01).

    It is `ok` if it was carried out, also where a value is out of its limits: see `LimitMissed`.
    """

    step: str
    index: int
    action: str
    ok: bool
    recording: str = ""
    measurement: str = ""
    """The table that `values` is a row of, at `setpoints`, where the step is a `measure`."""
    setpoints: Mapping[str, float] = {}
    values: Mapping[str, float] = {}
    statistics: Mapping[str, float] = {}
    """Of a recording: those of its samples that are kept or have limits, 'role.name.statistic'."""
    units: Mapping[str, str] = {}
    readings: Mapping[str, Reading] = {}
    """What it read that is not a number, by 'role.name'."""
    leaves: int = 0
    """Of a condition: how many of the steps that follow in the plan it leaves out."""
    cycles: Mapping[str, float] = {}
    """By role, how many cycles its device had moved in by then, since `main` began."""
    truth: Mapping[str, float] = {}
    """Of a simulator; goes into the run file's verification group, which no analysis reads."""


class Scanned(Event, frozen=True, kw_only=True):
    """A point of a scan: its drive stood at the set-point, and these values were read, in SI units.

    It comes between the start and the end of the scan's step, whose start has the limits.
    """

    step: str
    point: int
    """From 0, in the order in which they are gone through."""
    measurement: str
    """The table that the values are a row of."""
    setpoints: Mapping[str, float]
    values: Mapping[str, float]


class RunEnded(Event, frozen=True, kw_only=True):
    """The rig is safe (or its alarms say why not) and nothing more will be recorded."""

    outcome: Outcome
    reason: str = ""
    read_back: Mapping[str, float] = {}
    """What was read back of each drive after making safe: 'role.drive' in SI units."""
    resumable: bool = False
    """Whether it may be resumed once its cause is fixed.

    That is so where it could not be kept on record, or where a device was lost or did not answer.
    """


class RunPlanned(Event, frozen=True, kw_only=True):
    """What run it is that begins; for a station's listeners alone, as the run's header has it."""

    run_id: str
    folder: str
    """Where its files are written."""
    station: str
    procedure: str
    title: str
    inputs: Mapping[str, str] = {}
    due: Mapping[str, str] = {}
    """By instrument, on what day its calibration is due: '2027-01-31'."""


class RunFinished(Event, frozen=True, kw_only=True):
    """The run is analysed, sealed and reported; for a station's listeners alone, as the last."""

    outcome: Outcome
    reason: str = ""
    verdict: str = ""
    """'' where there is none."""
    report: str = ""
    """The path of the report; '' where there is none."""


@runtime_checkable
class ClosingSink(Protocol):
    """A sink that wants to know that no further event comes."""

    def close(self) -> None:
        """Let go of everything; what takes longer than a few seconds is not waited for."""
        ...


class EventSink(Protocol):
    """Takes the events of a run. A critical sink that raises stops the run, safely."""

    def __call__(self, event: Event) -> None:
        """Take one event; samples may be large and must not be kept without need."""
        ...
