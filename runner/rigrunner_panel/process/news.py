"""What the process that has the rig tells the panel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from rigrunner.api.data import Recording
    from rigrunner.api.errors import Problem
    from rigrunner.api.events import Event
    from rigrunner.api.findings import Findings
    from rigrunner.engine import Paused
    from rigrunner.procedure.answers import Expected
    from rigrunner_panel.view.manual import ManualView
    from rigrunner_panel.view.sections import (
        ChannelView,
        Finished,
        LiveView,
        PlanView,
        PreflightItem,
    )


@dataclass(frozen=True)
class Planned:
    """The files are read, and nothing of the rig is touched yet."""

    plan: PlanView
    no_load: str
    title: str
    channels: tuple[ChannelView, ...] = ()


@dataclass(frozen=True)
class Happened:
    """An event of the run; samples come as a Curve."""

    event: Event


@dataclass(frozen=True, eq=False)
class Curve:
    """A block of samples for the screen: channels by 'role.name', float32 of shape (n,)."""

    recording: str
    rate_hz: float
    first_sample: int
    monotonic_s: float
    channels: Mapping[str, NDArray[np.float32]]


@dataclass(frozen=True)
class ChannelValues:
    """What channels read while nothing is recorded, in SI units by 'role.name'."""

    values: Mapping[str, float]
    time_s: float
    """When they were read, in seconds since the epoch."""


@dataclass(frozen=True)
class Asked:
    """A person is asked something, and the run waits."""

    number: int
    step: str
    kind: Literal["confirm", "ask"]
    text: str
    picture: str
    expected: Expected


@dataclass(frozen=True)
class Answered:
    """The run no longer waits for that answer."""

    number: int


@dataclass(frozen=True)
class PausedNow:
    """The run is paused and waits for a decision."""

    paused: Paused


@dataclass(frozen=True)
class WentOn:
    """It was decided."""


@dataclass(frozen=True)
class Checked:
    """A part of the preflight."""

    item: PreflightItem


@dataclass(frozen=True)
class Analysing:
    """How far a part of the analysis is."""

    what: str
    done: int
    of: int


@dataclass(frozen=True)
class ManualNow:
    """What the manual session shows, and at what frequency the rig swings."""

    view: ManualView
    frequency_hz: float


@dataclass(frozen=True, eq=False)
class LiveRecording:
    """What was watched, to be analysed; it is kept nowhere."""

    recording: Recording
    frequency_hz: float


@dataclass(frozen=True, eq=False)
class LiveNow:
    """What the analyses show of the recording that goes on."""

    found: Findings


@dataclass(frozen=True)
class Ended:
    """The process has done its job."""

    finished: Finished | None = None
    live: LiveView | None = None


@dataclass(frozen=True)
class Failed:
    """The job could not be begun, or a bug ended it."""

    message: str
    hint: str = ""
    code: str = "bug"
    problems: tuple[Problem, ...] = ()
    trace: str = ""
