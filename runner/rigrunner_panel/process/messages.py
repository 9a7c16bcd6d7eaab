"""What passes between the panel and the processes that work for it.

To the process that has the rig go commands. From it come the engine's events as they are, and
sections of the state that it alone knows; the state itself stands on the panel's board.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from msgspec import Struct, field

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from rigrunner.api.data import Recording
    from rigrunner.api.errors import Problem
    from rigrunner.api.findings import Findings
    from rigrunner.engine import Decision, Interference
    from rigrunner_panel.view.sections import Finished, JobView, LiveView, PreflightItem


class Job(Struct, frozen=True, kw_only=True):
    """What a process is started for: `view` as the screen knows it, the rest as files have it."""

    view: JobView
    procedure: Path
    station: Path
    runs: Path
    partners: Mapping[str, str] = field(default_factory=dict)
    """Partner runs by name, in place of those that are found by themselves."""
    items: tuple[PreflightItem, ...] = ()
    """What the preflight found that is overridden."""
    by: str = ""
    reason: str = ""
    """Why it is overridden; of a preflight, why a rig that was left energised is safe."""
    entry: int | None = None
    """The entry of the queue that the run is."""
    resumes: bool = False
    """Whether the view's run was interrupted, and is resumed."""


class Answer(Struct, frozen=True):
    """An answer to the prompt of that number, accepted already."""

    prompt: int
    text: str
    by: str


class Pause(Struct, frozen=True):
    """The run is to pause; with a decision that follows at once, where it is one."""

    by: str
    then: Decision | None = None


class Decide(Struct, frozen=True):
    """How a paused run goes on."""

    decision: Decision


class Abort(Struct, frozen=True):
    """The run is to end: teardown, and the rig is made safe."""

    by: str
    reason: str


class Stop(Struct, frozen=True):
    """The rig is to be made safe at once."""

    by: str
    reason: str


class PutOnRecord(Struct, frozen=True):
    """Something that a person did beside the run."""

    what: Interference


class SetDrive(Struct, frozen=True):
    """A drive gets a set-point by hand, in its SI unit."""

    drive: str
    value: float
    by: str


class RecordPoint(Struct, frozen=True):
    """A point is recorded by hand, so many cycles long."""

    cycles: int
    by: str


class CloseManual(Struct, frozen=True):
    """The manual session ends."""

    by: str


LIVE = "live"
"""The name of a recording that is watched and kept nowhere."""
ByHand = SetDrive | RecordPoint | CloseManual
Command = Answer | Pause | Decide | Abort | Stop | PutOnRecord | ByHand


class Show(Struct, frozen=True):
    """Sections of the state, by name, as they are from now on."""

    sections: Mapping[str, Any]


class Values(Struct, frozen=True):
    """What channels read while nothing is recorded, in SI units by 'role.name'."""

    values: Mapping[str, float]
    time_s: float
    """When they were read, in seconds since the epoch."""
    interval_s: float
    """When they are read again."""


class Watched(Struct, frozen=True, eq=False):
    """What was watched by hand, to be analysed; it is kept nowhere."""

    recording: Recording


class Found(Struct, frozen=True, eq=False):
    """What the analyses show of the recording that goes on."""

    findings: Findings


class Ended(Struct, frozen=True):
    """The process has done its job."""

    finished: Finished | None = None
    live: LiveView | None = None


class Failed(Struct, frozen=True):
    """The job could not be begun, or a bug ended it."""

    message: str
    hint: str = ""
    code: str = "bug"
    problems: tuple[Problem, ...] = ()
    trace: str = ""


class Analyse(Struct, frozen=True, eq=False):
    """Analyse a run as far as it is; or what is watched, by the run's own analysis."""

    folder: Path
    station: Path
    recording: str
    watched: Recording | None = None


class Analysed(Struct, frozen=True, eq=False):
    """What was found; `correction_nm` is taken from the swing of that recording, shape (N,)."""

    view: LiveView | None
    recording: str = ""
    correction_nm: NDArray[np.float64] | None = None
