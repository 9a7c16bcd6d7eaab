"""Messages between the panel and its processes.

Commands go to the process that controls the rig. The process sends the engine's events unchanged,
and the sections of the state that only it knows; the panel's board stores the state.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from msgspec import Struct, field

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.api.data import Recording
    from rigrunner.api.errors import Problem
    from rigrunner.api.figures import Curve
    from rigrunner.api.findings import Findings
    from rigrunner.engine import Decision, Interference
    from rigrunner_panel.view.sections import Finished, JobView, LiveView, PreflightItem


class Job(Struct, frozen=True, kw_only=True):
    """What a process is started for: `view` as the screen shows it, the rest as in the files."""

    view: JobView
    procedure: Path
    station: Path
    runs: Path
    partners: Mapping[str, str] = field(default_factory=dict)
    """Partner runs by name, in place of those found automatically."""
    items: tuple[PreflightItem, ...] = ()
    """The failed preflight checks that are overridden."""
    by: str = ""
    reason: str = ""
    """The reason for the override; in a preflight, the reason why a rig left energised is safe."""
    entry: int | None = None
    """The entry of the queue that the run is."""
    resumes: bool = False
    """Whether the view's run was interrupted, and is resumed."""


class Answer(Struct, frozen=True):
    """A validated answer to a prompt."""

    prompt: int
    text: str
    by: str


class Pause(Struct, frozen=True):
    """Pause the run, optionally with a decision to apply at once."""

    by: str
    then: Decision | None = None


class Decide(Struct, frozen=True):
    """How a paused run continues."""

    decision: Decision


class Abort(Struct, frozen=True):
    """Abort the run: do its teardown and make the rig safe."""

    by: str
    reason: str


class Stop(Struct, frozen=True):
    """Make the rig safe at once."""

    by: str
    reason: str


class PutOnRecord(Struct, frozen=True):
    """Something that a person did during the run."""

    what: Interference


class SetDrive(Struct, frozen=True):
    """Set a drive manually, in its SI unit."""

    drive: str
    value: float
    by: str


class RecordPoint(Struct, frozen=True):
    """Record a point manually, for a number of cycles."""

    cycles: int
    by: str


class CloseManual(Struct, frozen=True):
    """End the manual session."""

    by: str


ByHand = SetDrive | RecordPoint | CloseManual
Command = Answer | Pause | Decide | Abort | Stop | PutOnRecord | ByHand


class Show(Struct, frozen=True):
    """Replace sections of the state, by name."""

    sections: Mapping[str, Any]


class Values(Struct, frozen=True):
    """Channel readings between recordings, in SI units by 'role.name'."""

    values: Mapping[str, float]
    time_s: float
    """Time of the readings, in seconds since the epoch."""
    interval_s: float
    """Interval to the next reading, in s."""


class Watching(Struct, frozen=True):
    """The samples that follow are watched in a manual session, and not stored."""

    setpoints: Mapping[str, float]
    units: Mapping[str, str]


class Watched(Struct, frozen=True, eq=False):
    """Data watched in a manual session, for analysis; they are not stored."""

    recording: Recording


class LiveFindings(Struct, frozen=True, eq=False):
    """The findings for the recording in progress."""

    findings: Findings


class Drawn(Struct, frozen=True, eq=False):
    """A curve of a live analysis that ended at `ended_s`, by the clock of the events."""

    recording: str
    curve: Curve
    ended_s: float


class Ended(Struct, frozen=True):
    """The process has finished its job."""

    finished: Finished | None = None
    live: LiveView | None = None


class Failed(Struct, frozen=True):
    """The job did not start, or an internal error ended it."""

    message: str
    hint: str = ""
    code: str = "bug"
    problems: tuple[Problem, ...] = ()
    trace: str = ""


class Follow(Struct, frozen=True):
    """The run whose events follow."""

    folder: Path
    station: Path


class Analyse(Struct, frozen=True, eq=False):
    """Analyse the finished recordings of the run, or watched data by its own analysis."""

    watched: Recording | None = None


class Analysed(Struct, frozen=True, eq=False):
    """The findings; None if there are none yet. `is_watched`: of data that are not stored."""

    view: LiveView | None
    is_watched: bool = False
