"""What the panel tells the process that has the rig: its job, and what people want of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.engine import Decision, Interference
    from rigrunner_panel.view.sections import PreflightItem

Kind = Literal["preflight", "run", "manual"]


@dataclass(frozen=True, kw_only=True)
class Job:
    """What a process is started for."""

    kind: Kind
    procedure: Path
    station: Path
    runs: Path
    inputs: Mapping[str, str] = field(default_factory=dict)
    operator: str = ""
    no_load: str | None = None
    realtime: bool = True
    overridden: tuple[str, ...] = ()
    items: tuple[PreflightItem, ...] = ()
    """What the preflight found that is overridden."""
    by: str = ""
    reason: str = ""
    entry: int | None = None
    """The entry of the queue that the run is."""


@dataclass(frozen=True)
class GiveAnswer:
    """An answer to the prompt of that number, accepted already."""

    prompt: int
    text: str
    by: str


@dataclass(frozen=True)
class AskPause:
    """The run is to pause; with a decision that follows at once, where it is one."""

    by: str
    then: Decision | None = None


@dataclass(frozen=True)
class Decide:
    """How a paused run goes on."""

    decision: Decision


@dataclass(frozen=True)
class Abort:
    """The run is to end: teardown, and the rig is made safe."""

    by: str
    reason: str


@dataclass(frozen=True)
class Stop:
    """The rig is to be made safe at once."""

    by: str
    reason: str


@dataclass(frozen=True)
class PutOnRecord:
    """Something that a person did beside the run."""

    what: Interference


@dataclass(frozen=True)
class SetManually:
    """A drive gets a set-point, in its SI unit."""

    drive: str
    value: float
    by: str


@dataclass(frozen=True)
class RecordManually:
    """A point is recorded, so many cycles long."""

    cycles: int
    by: str


@dataclass(frozen=True)
class CloseManual:
    """The manual session ends."""

    by: str


Wish = SetManually | RecordManually | CloseManual
"""What the manual page wants."""
