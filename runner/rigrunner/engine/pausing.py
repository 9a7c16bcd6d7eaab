"""Actions of people on a run: who can pause it, what they can decide then, what is recorded."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from rigrunner.api.errors import RigrunnerError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rigrunner.api.errors import AbortedError
    from rigrunner.rig import Rig


class Choice(StrEnum):
    """What a person can decide while a run is paused."""

    RESUME = "resume"
    OVERRIDE = "override"
    REPEAT = "repeat"
    SKIP = "skip"
    NOTE = "note"
    ABORT = "abort"


@dataclass(frozen=True)
class Paused:
    """Where and why a run is paused."""

    step: str
    point: str
    """What would be repeated or skipped: the set-point of a sweep, or the step."""
    reason: str
    moving: tuple[str, ...]
    """Devices that cannot pause, as text, with the positions of their drives."""
    choices: tuple[Choice, ...]


@dataclass(frozen=True)
class Decision:
    """A decision, who made it and why; the reason of a note is its text."""

    choice: Choice
    by: str
    reason: str = ""


class Pauses(Protocol):
    """Requests pauses, and decides how they end."""

    def requested_by(self) -> str:
        """Return who requests a pause, such as 'keyboard'; '' for no one."""
        ...

    def decide(self, paused: Paused, watch: Callable[[], None]) -> Decision:
        """Return a decision; call `watch` often while waiting, and pass on what it raises.

        This ends the request until there is a new one.
        """
        ...


@dataclass(frozen=True)
class Override:
    """A failed check before the start, and who overrode it; the run records it at its start."""

    what: str
    """Short name, such as 'overdue tester.torque'."""
    subject: str
    """The failed check in a sentence."""
    by: str
    reason: str


@dataclass(frozen=True)
class Interference:
    """Another action of a person on a run, which is recorded as an Intervention."""

    action: str
    by: str
    reason: str = ""
    subject: str = ""


@runtime_checkable
class Reporting(Protocol):
    """Pauses that also report other actions, such as a change of control."""

    def new_actions(self) -> Iterable[Interference]:
        """Return actions that were not reported yet."""
        ...


@runtime_checkable
class Showing(Protocol):
    """Pauses that display the channels of the rig while nothing is recorded."""

    def show(self, rig: Rig) -> None:
        """Read the displayed channels when due; raises no DeviceError.

        Called often while time passes, and never while a device streams.
        """
        ...


@runtime_checkable
class Reasoned(Protocol):
    """A stop token with a reason."""

    def reason(self) -> AbortedError:
        """Return the reason for stopping."""
        ...


@runtime_checkable
class Interrupting(Protocol):
    """A stop token that interrupts the run, until `stop_interrupting` is called."""

    def stop_interrupting(self) -> None:
        """Stop interrupting: the rig is being made safe, and that is recorded."""
        ...


class StopNow(KeyboardInterrupt):
    """A person requests to skip the teardown: the rig is made safe at once."""

    def __init__(self, reason: str = "interrupted from the keyboard", by: str = "keyboard") -> None:
        super().__init__(reason)
        self.reason = reason
        self.by = by


class PauseRequestedError(RigrunnerError):
    """Leaves a step that a pause interrupts; users never see it."""

    def __init__(self, reason: str, by: str) -> None:
        super().__init__(reason)
        self.by = by
