"""The contract of a kind of step: how it is written, planned and executed.

A kind is one module: a model of its settings (`StepSettings`), a function that plans it
(`plan(settings, planning)`), one or more actions of the plan that execute it (`Action.do`), and a
`StepRecord` that registers it. Engine and plan know no kind; an action states what they need to
know.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self

from pydantic import Field

from rigrunner.api.conditions import When
from rigrunner.api.labels import Labels
from rigrunner.api.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner.api.data import Block
    from rigrunner.api.devices import ChannelInfo, Clock
    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.member import Member
    from rigrunner.api.quantity import Estimate, Quantity
    from rigrunner.api.readings import Reading

NONE: Mapping[str, Any] = {}


class StepSettings(Settings):
    """Base class of the settings of a kind of step, the value of its key in a procedure.

    Steps inside it are its field `steps`, a `ListOf[Step]`.
    """

    label: Labels = Field(default_factory=dict)
    when: When | None = None
    """Condition on an answer; without one the step is always executed."""

    def actions(self) -> int:
        """Return its own number of actions of the plan, without the steps inside it."""
        return 1

    def times(self) -> int:
        """Return how often the steps inside it are executed."""
        return 1

    def recordings(self) -> int:
        """Return its own number of recordings."""
        return 0

    def pictures(self) -> Iterable[tuple[str, str]]:
        """Return the picture files that it shows, each with its key."""
        return ()

    def answered(self) -> str:
        """Return the input of the run that its answer becomes; '' for none."""
        return ""

    def calls(self) -> tuple[str, Mapping[str, Any]] | None:
        """Return the file of a called procedure and its parameters."""
        return None


@dataclass(slots=True)  # to make a frozen one, or a tuple with names, takes twice as long
class StepResult:
    """What a step found, in SI units by 'role.name', and the truth of a simulator."""

    values: Mapping[str, float]
    units: Mapping[str, str]
    truth: Mapping[str, float] = field(default_factory=dict)
    statistics: Mapping[str, float] = field(default_factory=dict)
    """Limited statistics of a recording, in SI units by 'role.name.statistic'."""
    missed: str = ""
    """The message for a value out of limits that ended a step which checks its values itself."""
    readings: Mapping[str, Reading] = field(default_factory=dict)
    """Readings that are not numbers, by 'role.name'."""
    leaves: bool = False
    """Of a condition: whether the steps that depend on it are skipped."""
    scatter: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Of a zero: the standard uncertainty of each value and its degrees of freedom."""


NOTHING = StepResult(NONE, NONE, NONE)


@dataclass(frozen=True)
class Rows:
    """The rows of a table that an action makes."""

    name: str
    """Name of the table."""
    channels: Sequence[Member]
    """Channels that are read for each row."""
    units: Mapping[str, str]
    """Units of channels and drives."""
    setpoints: Sequence[Mapping[str, float]]
    """Set-points of the drives for each row, in order."""


class Action:
    """An executable step of a plan: explicit, in SI units, with nothing left to look up.

    An action is a frozen dataclass; its fields are stored with the plan in the run file. What the
    engine needs to know besides `do` are the attributes below; by default it neither moves nor
    reads anything.
    """

    __slots__ = ()  # an action of which a plan may have very many can have slots of its own

    kind: ClassVar[str]
    """The keyword of the step, used by its events."""
    reads: ClassVar[bool] = False
    """Whether it reads values, which depend on the positions of the drives."""
    drives_stay: ClassVar[bool] = False
    """Whether drives must keep their set-points meanwhile: they are monitored, and a deviation ends
    the run."""
    settles: ClassVar[bool] = False
    """Whether it only waits for the motion to settle: after a pause it is executed again."""
    outcome_stands: ClassVar[bool] = False
    """Whether a resumed run keeps its outcome and does not execute it again."""

    def do(self, step: str, doing: Any) -> StepResult:
        """Execute it and return what was found; `doing` is a Doing, `step` its place for messages.

        Raises what prevents execution; exceptions of `doing` must not be caught. Anything that
        takes time must go through `doing`, which handles stop, pause and interlocks.
        """
        raise NotImplementedError

    @property
    def moves(self) -> Member | None:
        """The drive that it sweeps."""
        return None

    @property
    def moves_to(self) -> Sequence[float]:
        """The set-points of that drive, in order; it stays at the last one."""
        return ()

    @property
    def restoring(self) -> Action | None:
        """The action that restores the state of the rig after this one, without reading again.

        None if executing it again does that.
        """
        return None

    @property
    def zeroed(self) -> Member | None:
        """The channel whose reading at rest it stores as zero."""
        return None

    @property
    def streamed(self) -> str:
        """The role of the device that it streams from; '' for none."""
        return ""

    @property
    def recording(self) -> str:
        """The name of the recording that it makes; '' for none."""
        return ""

    @property
    def rows(self) -> Rows | None:
        """The rows of a table that it makes."""
        return None

    @property
    def table(self) -> str:
        """The table to which the returned values are added as a row; '' for none."""
        return ""

    @property
    def statistics(self) -> Sequence[str]:
        """The statistics of its samples that are added to a table, 'role.name.statistic'."""
        return ()

    @property
    def setpoints_and_units(self) -> tuple[Mapping[str, float], Mapping[str, str]]:
        """Set-points of the drives while it reads, and units of all that it reads or sets."""
        return NONE, NONE

    @property
    def checked_limits(self) -> tuple[ValueLimit, ...]:
        """The limits that it checks itself."""
        return ()

    def for_attempt(self, total: int) -> Self:  # noqa: ARG002  (of those that need it)
        """Return it for its n-th attempt, counted from 1."""
        return self


class Planning(Protocol):
    """What a kind plans with: the set-points so far, and the devices of the station.

    Everything impossible is reported as a problem with its place in the file; the run is refused
    with all problems before anything moves. A `key` is one of the step, a path of keys and indices.
    """

    def emit(
        self,
        action: Action,
        text: str,
        seconds: float = 0.0,
        limits: Iterable[ValueLimit] | None = None,
    ) -> None:
        """Add an action with its description and duration.

        `timeout`, `retries`, `repeatable` and `on_fail` of the step apply to it; `limits` are those
        of the values that it returns.
        """
        ...

    def complain(self, key: tuple[str | int, ...], message: str, hint: str = "") -> None:
        """Report a problem at a key of the step."""
        ...

    def channel(self, member: Member, key: tuple[str | int, ...]) -> ChannelInfo | None:
        """Return a channel of a device, or None after reporting a problem."""
        ...

    def units(self, channels: Sequence[Member], key: tuple[str | int, ...]) -> dict[Member, str]:
        """Return the unit of each channel; an empty mapping after reporting a problem."""
        ...

    def must_be_read(
        self,
        channels: Iterable[Member],
        at: Mapping[str, float] = NONE,
        key: tuple[str | int, ...] = (),
    ) -> bool:
        """Report a problem for each device without single values, or with none at its place.

        `at`: set-points in SI units that drives have then, 'role.drive', written under `key`.
        Returns whether all devices can be read there.
        """
        ...

    def fits(
        self, quantity: Quantity, symbol: str, member: Member, key: tuple[str | int, ...]
    ) -> bool:
        """Return whether a quantity has the dimension of a unit; report a problem if not."""
        ...

    def move(
        self, drive: Member, to: Quantity, named: tuple[str | int, ...], key: tuple[str | int, ...]
    ) -> tuple[str, float] | None:
        """Note that a drive is set; return its unit and the duration in s.

        None after reporting a problem, such as a limit of the drive or of a combination.
        """
        ...

    def require_rest(self, role: str) -> None:
        """Report a problem if the device in the role moves at this point."""
        ...

    def setpoints(self) -> dict[str, float]:
        """Return the set-points of the drives at this point, in SI units."""
        ...


class Doing(Protocol):
    """What an action works with; each call raises what prevents the run from continuing."""

    @property
    def clock(self) -> Clock:
        """The clock of the rig."""
        ...

    def check(self) -> None:
        """Raise if the run has to stop or pause, an interlock trips, or the step takes too long."""
        ...

    def wait(self, duration_s: float) -> None:
        """Wait for a duration."""
        ...

    def read(self, channels: Sequence[Member]) -> dict[str, float]:
        """Return the present value of each channel, in SI units and in the given order."""
        ...

    def observe(self, readings: Sequence[Member]) -> dict[str, Reading]:
        """Return readings that are not numbers: a text, a yes or no, a tuple of numbers."""
        ...

    def set(self, role: str, drive: str, value: float) -> float:
        """Set a drive and return its read-back; limits, combinations and interlocks apply."""
        ...

    def stream(self, role: str, channels: Sequence[str], duration_s: float) -> Iterator[Block]:
        """Yield the checked blocks of a device, with channels named 'role.channel'."""
        ...

    def answer(self, name: str) -> str | None:
        """Return the present answer of an input of the run; None for none."""
        ...

    def result(self, name: str) -> Estimate:
        """Return a result of the analyses of the procedure, from the data so far, in its unit.

        Of several, the one of the latest place. Raises DataError for none.
        """
        ...

    def note(self, step: str, text: str) -> None:
        """Record a remark."""
        ...
