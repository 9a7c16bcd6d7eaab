"""Pausing: who may ask for it, and what a person may decide while the run is paused."""

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
    """What a person may decide while a run is paused."""

    RESUME = "resume"
    OVERRIDE = "override"
    REPEAT = "repeat"
    SKIP = "skip"
    NOTE = "note"
    ABORT = "abort"


@dataclass(frozen=True)
class Paused:
    """Where a run is paused and why."""

    step: str
    point: str
    """What would be repeated or skipped: the set-point of a sweep, or the step itself."""
    reason: str
    moving: tuple[str, ...]
    """Devices that cannot pause, in words, with where their drives stay."""
    choices: tuple[Choice, ...]


@dataclass(frozen=True)
class Decision:
    """What was decided, by whom, and why; a note's text is its reason."""

    choice: Choice
    by: str
    reason: str = ""


class Pauses(Protocol):
    """Asks for pauses, and decides how they end."""

    def wanted(self) -> str:
        """Return who asks for a pause, such as 'keyboard'; an empty text while nobody does."""
        ...

    def decide(self, paused: Paused, watch: Callable[[], None]) -> Decision:
        """Return one of the choices; call `watch` often while waiting, and let what it raises out.

        Asks for no pause any more from then on, until somebody does anew.
        """
        ...


@dataclass(frozen=True)
class Interference:
    """Something else that a person did to a run, to be put on record as an Intervention."""

    action: str
    by: str
    reason: str = ""
    subject: str = ""


@runtime_checkable
class Telling(Protocol):
    """Pauses that know of such things, as that somebody else took control."""

    def told(self) -> Iterable[Interference]:
        """Return what has happened and was not told yet."""
        ...


@runtime_checkable
class Showing(Protocol):
    """Pauses of a person who sees the channels of the rig while nothing is recorded."""

    def show(self, rig: Rig) -> None:
        """Read what the person is to see, if its time has come; raise nothing of a device.

        It is called often while time passes, and never while a device streams.
        """
        ...


@runtime_checkable
class Reasoned(Protocol):
    """A stop token that knows why it is set."""

    def reason(self) -> AbortedError:
        """Return what ends the run."""
        ...


@runtime_checkable
class Forbearing(Protocol):
    """A stop token that would interrupt the run, and can be told to let it be."""

    def let_be(self) -> None:
        """Interrupt nothing from now on: the rig is being made safe, and that put on record."""
        ...


class StopNow(KeyboardInterrupt):
    """A person wants no teardown either: the rig is made safe at once."""

    def __init__(self, reason: str = "interrupted from the keyboard", by: str = "keyboard") -> None:
        super().__init__(reason)
        self.reason = reason
        self.by = by


class PauseWantedError(RigrunnerError):
    """Leaves a step that a pause breaks off; no user sees it."""

    def __init__(self, reason: str, by: str) -> None:
        super().__init__(reason)
        self.by = by
