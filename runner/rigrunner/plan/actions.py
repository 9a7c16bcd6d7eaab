"""The steps of a plan: explicit, in SI units, with nothing left to look up."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import TYPE_CHECKING

from rigrunner.api.member import Member
from rigrunner.procedure.answers import Expected

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.unit_tables import Unit
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path


class Phase(StrEnum):
    """When a step is run: teardown always, also after a failure."""

    SETUP = "setup"
    MAIN = "main"
    TEARDOWN = "teardown"


@dataclass(frozen=True)
class Confirm:
    """A person confirms that something is so; 'no' stops the run."""

    text: str
    unattended: bool | None
    picture: str = ""
    """The path of a picture to show; empty for none."""


@dataclass(frozen=True)
class Ask:
    """A person is asked for a value; `into` names the input that it becomes."""

    text: str
    into: str
    unattended: str | None
    picture: str = ""
    """The path of a picture to show; empty for none."""
    expected: Expected = field(default_factory=Expected)


@dataclass(frozen=True)
class Note:
    """A remark is put on record."""

    text: str


@dataclass(frozen=True)
class Zero:
    """A channel is read at rest; beyond `within` (SI unit of the channel) the step has failed."""

    role: str
    channel: str
    unit: str
    within: float
    duration_s: float

    @property
    def member(self) -> Member:
        """The channel."""
        return Member(self.role, self.channel)


@dataclass(frozen=True)
class SetDrive:
    """One drive gets a set-point, in its SI unit."""

    role: str
    drive: str
    value: float
    unit: str

    @property
    def member(self) -> Member:
        """The drive, 'role.drive'."""
        return Member(self.role, self.drive)

    @property
    def ends(self) -> tuple[float, ...]:
        """The set-points that it is left at."""
        return (self.value,)


@dataclass(frozen=True)
class Ramp:
    """One drive is brought to a start and led to an end, in its SI unit, over a time."""

    role: str
    drive: str
    start: float
    end: float
    unit: str
    duration_s: float

    @property
    def member(self) -> Member:
        """The drive, 'role.drive'."""
        return Member(self.role, self.drive)

    @property
    def ends(self) -> tuple[float, ...]:
        """The set-points that it is left at."""
        return (self.end,)


@dataclass(frozen=True)
class Wait:
    """Time passes, whatever the rig does."""

    duration_s: float


@dataclass(frozen=True)
class Settle:
    """Time passes until the motion is steady."""

    duration_s: float


@dataclass(frozen=True)
class Record:
    """Channels of one device are recorded."""

    name: str
    role: str
    channels: tuple[str, ...]
    duration_s: float
    setpoints: Mapping[str, float]
    """Every drive that the procedure has set by then: 'role.drive' to value in SI units."""
    units: Mapping[str, str]
    """The unit of each channel and drive: 'role.name' to symbol."""
    cycle_frequency_hz: float | None = None
    """The set frequency of the cyclic motion; None where there is none."""
    sample_rate_hz: float | None = None
    """As the device states it before it is connected; None where it cannot."""
    statistics: tuple[str, ...] = ()
    """The statistics of its samples that have limits, as 'role.name.statistic'."""


@dataclass(frozen=True)
class Measure:
    """Channels are read once, or averaged over a time."""

    name: str
    """Of the table of which the values are a row."""
    channels: tuple[Member, ...]
    """Of one role where they are averaged."""
    duration_s: float
    """How long to average; 0: read once."""
    setpoints: Mapping[str, float]
    """As of a recording."""
    units: Mapping[str, str]
    """As of a recording."""
    sample_rate_hz: float | None = None
    """Of the stream that is averaged; None: the channels are read, again and again."""


@dataclass(frozen=True)
class Scan:
    """One drive goes through set-points; at each one channels are read once: a row of a table."""

    name: str
    """Of the table."""
    role: str
    drive: str
    values: tuple[float, ...]
    """The set-points in order, in the SI unit of the drive."""
    channels: tuple[Member, ...]
    settle_s: float
    """How long to wait at each set-point; 0: not at all."""
    setpoints: Mapping[str, float]
    """As of a recording, without this drive."""
    units: Mapping[str, str]
    """As of a recording."""
    limits: tuple[ValueLimit, ...] = ()
    """What the values of each row may be."""
    stops_at_limit: bool = True
    """Whether the first value out of limits ends the scan and the run."""

    @property
    def member(self) -> Member:
        """The drive, 'role.drive'."""
        return Member(self.role, self.drive)

    @property
    def ends(self) -> tuple[float, ...]:
        """The set-points that it is left at."""
        return self.values

    @property
    def last(self) -> SetDrive:
        """What leads the drive to where the scan leaves it."""
        return SetDrive(self.role, self.drive, self.values[-1], self.units[self.member])


Action = Confirm | Ask | Note | Zero | SetDrive | Ramp | Wait | Settle | Record | Measure | Scan


@dataclass(frozen=True)
class Terms:
    """When a step counts as done, and what follows if it is not."""

    timeout_s: float | None = None
    """How long it may take."""
    tries: int = 1
    """How often it is tried, all in all."""
    goes_on: bool = False
    """Whether the run goes on after the last failure."""
    limits: tuple[ValueLimit, ...] = ()
    """What its values may be; of a scan the action has them."""
    stops_at_limit: bool = True
    """Whether a value out of limits ends the run."""
    repeatable: bool = True
    """Whether it may be done twice; a pause inside one that may not aborts the run."""


@dataclass(frozen=True)
class PlannedStep:
    """One explicit action of a plan."""

    path: str
    """Where it stands in the procedure, such as 'main[1].sweep[3].record'."""
    phase: Phase
    action: Action
    text: str
    """What it does, in words with units, for terminals and reports."""
    estimated_s: float
    terms: Terms = field(default_factory=Terms)
    calls: tuple[str, ...] = ()
    """The calls that it is part of, the outermost first: each a path. A called procedure's teardown
    is run where it stands, and also if the run fails within that call."""
    points: tuple[str, ...] = ()
    """The set-points of sweeps and times of repetitions that it is part of, the outermost first."""

    @property
    def limits(self) -> tuple[ValueLimit, ...]:
        """What the values may be that it finds."""
        return self.action.limits if isinstance(self.action, Scan) else self.terms.limits


@dataclass(frozen=True, kw_only=True)
class Interlock:
    """A channel that is watched throughout the run; values in its SI unit.

    Tripped outside `minimum` to `maximum`, by a faster change than `rate_per_s`, or if nothing
    could be read for `stale_s`.
    """

    name: str
    member: Member
    condition: str
    """What trips it, in words."""
    shown: Unit
    """The unit in which values are shown."""
    minimum: float = -inf
    maximum: float = inf
    rate_per_s: float | None = None
    stale_s: float | None = None
    debounce_s: float = 0.0
    hysteresis: float = 0.0
    latched: bool = False
    every_s: float = 0.1
    does: str = "abort"
    """forbid, pause, abort or make_safe."""
    forbids: tuple[Member, ...] = ()
    """Drives that may not be led away from their safe value."""
    overridable: bool = False


@dataclass(frozen=True)
class Recorded:
    """A recording with the place that asks for it."""

    record: Record
    document: Document
    path: Path
    conditions: Sequence[str] = ()
    """All channels, 'role.name', that are read beside it."""


@dataclass(frozen=True)
class Plan:
    """The whole run, step by step, in order; teardown steps last."""

    steps: tuple[PlannedStep, ...]
    interlocks: tuple[Interlock, ...] = ()
    recordings: tuple[Recorded, ...] = ()
    """All recordings with their places in the procedure."""

    @property
    def estimated_s(self) -> float:
        """How long the run takes, in seconds, if nobody has to be waited for."""
        return sum(step.estimated_s for step in self.steps)
