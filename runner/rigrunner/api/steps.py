"""The contract of a kind of step: how it is written, planned and done.

A kind is one module: a model of what a procedure tells it (`StepSettings`), a function that plans
it (`plan(settings, planning)`), one or more actions of the plan that do it (`Action.do`), and a
`StepRecord` that makes it known. The engine and the plan know no kind; what they must know of an
action, it says itself.
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
    """The base of the model of a kind of step: what stands under its key in a procedure.

    Steps that stand within it are its field `steps`, a `ListOf[Step]`.
    """

    label: Labels = Field(default_factory=dict)
    when: When | None = None
    """The answer by which the step is done or left out; without one it is done."""

    def actions(self) -> int:
        """Return how many actions of the plan it gives by itself, without those within it."""
        return 1

    def times(self) -> int:
        """Return how often the steps within it are done."""
        return 1

    def recordings(self) -> int:
        """Return how many recordings it makes by itself."""
        return 0

    def pictures(self) -> Iterable[tuple[str, str]]:
        """Return the files beside the procedure that it shows, each with its key."""
        return ()

    def answered(self) -> str:
        """Return the input of the run that it gives a value; '' for none."""
        return ""

    def calls(self) -> tuple[str, Mapping[str, Any]] | None:
        """Return the file of a procedure that is done in its place, and its parameters."""
        return None


@dataclass(slots=True)  # to make a frozen one, or a tuple with names, takes twice as long
class Found:
    """What a step found, in SI units by 'role.name', and what a simulator knows of it."""

    values: Mapping[str, float]
    units: Mapping[str, str]
    truth: Mapping[str, float] = field(default_factory=dict)
    statistics: Mapping[str, float] = field(default_factory=dict)
    """Of a recording: what of its samples has limits, in SI units by 'role.name.statistic'."""
    missed: str = ""
    """Of a step that judges its values itself: the one out of limits that ended it, in words."""
    readings: Mapping[str, Reading] = field(default_factory=dict)
    """What was read that is not a number, by 'role.name'."""
    leaves: bool = False
    """Of a condition: whether the steps that hang on it are left out."""


NOTHING = Found(NONE, NONE, NONE)


@dataclass(frozen=True)
class Rows:
    """The rows of a table that an action finds."""

    name: str
    """Of the table."""
    channels: Sequence[Member]
    """What is read for each row."""
    units: Mapping[str, str]
    """Of channels and drives."""
    setpoints: Sequence[Mapping[str, float]]
    """Where the drives stand, for each row in order."""


class Action:
    """What a step of a plan does: explicit, in SI units, with nothing left to look up.

    An action is a frozen dataclass; its fields are kept with the plan in the run file. What the
    engine must know of it beyond `do` are the attributes here, which say by default that it neither
    moves nor reads anything.
    """

    kind: ClassVar[str]
    """The keyword of the step; its events carry it."""
    reads: ClassVar[bool] = False
    """Whether it reads something: what it finds depends on where the drives stand."""
    drives_stay: ClassVar[bool] = False
    """Whether drives must stay where they were set meanwhile: they are watched, and one that falls
    away ends the run."""
    settles: ClassVar[bool] = False
    """Whether it only gives the motion time: after a pause it is done again."""
    outcome_stands: ClassVar[bool] = False
    """Whether a run that is resumed keeps its outcome, and does not do it again."""

    def do(self, step: str, doing: Any) -> Found:
        """Do it, and return what was found; `doing` is a Doing, `step` its place for messages.

        Raises what keeps it from being done: what `doing` raises must not be caught. Whatever takes
        time must pass by `doing`: there the run is stopped and paused, and interlocks are read.
        """
        raise NotImplementedError

    @property
    def led(self) -> Member | None:
        """The drive that it leads."""
        return None

    @property
    def passes(self) -> Sequence[float]:
        """The set-points of that drive, in order; the last one is where it is left."""
        return ()

    @property
    def brings_back(self) -> Action | None:
        """What brings the rig to where it was left by this one, without reading again.

        None where doing it again does that.
        """
        return None

    @property
    def zeroed(self) -> Member | None:
        """The channel whose value at rest it takes as zero."""
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
        """The rows of a table that it finds."""
        return None

    @property
    def table(self) -> str:
        """The table of which the values that it returns are a row; '' for none."""
        return ""

    @property
    def statistics(self) -> Sequence[str]:
        """What of the samples that it records is a row of a table, 'role.name.statistic'."""
        return ()

    @property
    def known(self) -> tuple[Mapping[str, float], Mapping[str, str]]:
        """Where the drives stand when it reads, and the units of all that it reads or sets."""
        return NONE, NONE

    @property
    def judged(self) -> tuple[ValueLimit, ...]:
        """The limits that it judges its values by itself."""
        return ()

    def again(self, total: int) -> Self:  # noqa: ARG002  (of those that need it)
        """Return it as it is begun for the n-th time, counted from 1."""
        return self


class Planning(Protocol):
    """What a kind plans with: what the procedure has set by then, and the devices of the station.

    What cannot be done is a problem with its place in the file; the run is refused with all of them
    before anything moves. A `key` is one of the step's own, a path of keys and indices.
    """

    def emit(
        self,
        action: Action,
        text: str,
        seconds: float = 0.0,
        limits: Iterable[ValueLimit] | None = None,
    ) -> None:
        """Write down one action, in words and with how long it takes.

        The step's own `timeout`, `retries`, `repeatable` and `on_fail` are its terms; `limits` are
        what the values may be that it returns.
        """
        ...

    def complain(self, key: tuple[str | int, ...], message: str, hint: str = "") -> None:
        """Add a problem with what stands under a key of the step."""
        ...

    def channel(self, member: Member, key: tuple[str | int, ...]) -> ChannelInfo | None:
        """Return a channel of a device, or None after adding the problem."""
        ...

    def units(self, channels: Sequence[Member], key: tuple[str | int, ...]) -> dict[Member, str]:
        """Return the unit of each channel; nothing at all where there is a problem with one."""
        ...

    def must_be_read(self, channels: Iterable[Member]) -> None:
        """Add a problem for each device of which single values cannot be read."""
        ...

    def fits(
        self, quantity: Quantity, symbol: str, member: Member, key: tuple[str | int, ...]
    ) -> bool:
        """Say whether a quantity has the dimension of a unit; add the problem if not."""
        ...

    def move(
        self, drive: Member, to: Quantity, named: tuple[str | int, ...], key: tuple[str | int, ...]
    ) -> tuple[str, float] | None:
        """Let the plan know that a drive is set: return its unit, and how long that takes in s.

        None after adding the problem, such as a limit of the drive or of a combination.
        """
        ...

    def require_rest(self, role: str) -> None:
        """Add a problem if the role's device swings or turns by then."""
        ...

    def setpoints(self) -> dict[str, float]:
        """Return what each drive was set to by then, in SI units."""
        ...


class Doing(Protocol):
    """What an action does its work with; each call raises what prevents the run from continuing."""

    @property
    def clock(self) -> Clock:
        """The rig's clock."""
        ...

    def check(self) -> None:
        """Raise if the run is to stop or pause, an interlock trips, or the step's time is over."""
        ...

    def wait(self, duration_s: float) -> None:
        """Let a time pass."""
        ...

    def read(self, channels: Sequence[Member]) -> dict[str, float]:
        """Return the present value of each channel, in SI units and in their order."""
        ...

    def observe(self, readings: Sequence[Member]) -> dict[str, Reading]:
        """Return readings that are not numbers: a text, a yes or no, a tuple of numbers."""
        ...

    def set(self, role: str, drive: str, value: float) -> float:
        """Set a drive and return its read-back; limits, combinations and interlocks hold."""
        ...

    def stream(self, role: str, channels: Sequence[str], duration_s: float) -> Iterator[Block]:
        """Yield the blocks of a device, checked, with their channels named 'role.channel'."""
        ...

    def answer(self, name: str) -> str | None:
        """Return the answer that an input of the run has by now; None where it has none."""
        ...

    def result(self, name: str) -> Estimate:
        """Return a result of the procedure's analyses, of what was recorded by now, in its unit.

        Of several, that of the place that came last. Raises DataError where there is none.
        """
        ...

    def note(self, step: str, text: str) -> None:
        """Put a remark on record."""
        ...
