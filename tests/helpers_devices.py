"""Devices controlled by a test, plans written by hand, and sinks that record events."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.data import Block
from rigrunner.api.devices import ChannelInfo, DriveInfo, Identity
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.plan.actions import Phase, Plan, PlannedStep
from rigrunner.rig import Rig
from rigrunner.runfile.attempts import Attempts
from rigrunner.steps.ask import Ask
from rigrunner.steps.confirm import Confirm
from rigrunner.steps.record import Record
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.settle import Settle
from rigrunner.steps.zero import Zero

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from rigrunner.api.devices import StopToken
    from rigrunner.api.events import Event
    from rigrunner.engine import Pauses, ResumePoint, RunSummary
    from rigrunner.runfile.attempts import MeasuredRows

RATE_HZ = 1000.0
BLOCK = 100
CHANNELS = (
    ChannelInfo("angle", "rad", "swing angle"),
    ChannelInfo("torque", "N·m", "torque"),
    ChannelInfo("load", "N", "radial load"),
)
DRIVES = (
    DriveInfo("load", "N", "radial load", 0.0, 3000.0, rate_per_s=1e6),
    DriveInfo("frequency", "Hz", "swing frequency", 0.0, 35.0, sets_cycle_frequency=True),
)


def samples_of(channel: str, first: int, count: int) -> np.ndarray:
    """Return the samples of the fake tester: a ramp, different for each channel."""
    start = {"angle": 0.25, "torque": -0.01, "load": 1000.0}[channel]
    return start + 1e-6 * np.arange(first, first + count, dtype=np.float64)


@dataclass
class FakeTester:
    """A tester; `before` gets each call and may raise; `spoil` may change the streamed blocks."""

    non_blocking: bool = True
    before: Callable[[str], None] = lambda _: None
    spoil: Callable[[list[Block]], list[Block]] = lambda blocks: blocks
    read_back_offset: float = 0.0
    calls: list[str] = field(default_factory=list)
    drives_at: dict[str, float] = field(default_factory=lambda: {"load": 7.0, "frequency": 3.0})
    threads: set[str] = field(default_factory=set)

    channels: Sequence[ChannelInfo] = CHANNELS
    drives: Sequence[DriveInfo] = DRIVES
    sample_rate_hz: float = RATE_HZ

    def _record_call(self, call: str) -> None:
        self.calls.append(call)
        self.threads.add(threading.current_thread().name)
        self.before(call)

    def connect(self, timeout_s: float) -> Identity:  # noqa: ARG002
        self._record_call("connect")
        return Identity("Fakes", "tester", "1", simulated=True)

    def make_safe(self) -> Mapping[str, float]:
        self._record_call("make_safe")
        self.drives_at = dict.fromkeys(self.drives_at, 0.0)
        return {name: value + self.read_back_offset for name, value in self.drives_at.items()}

    def close(self) -> None:
        self._record_call("close")

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        self._record_call(f"read {','.join(channels)}")
        return dict.fromkeys(channels, 1000.0 + self.read_back_offset)

    def set(self, drive: str, value: float) -> None:
        self._record_call(f"set {drive} {value:g}")
        self.drives_at[drive] = value

    def read_back(self, drive: str) -> float:
        self._record_call(f"read_back {drive}")
        return self.drives_at[drive] + self.read_back_offset

    def truth(self) -> Mapping[str, float]:
        self._record_call("truth")
        return {"starting_torque_nm": 0.7262}

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        self._record_call("stream")
        total = round(duration_s * RATE_HZ)
        blocks = [
            Block(
                RATE_HZ,
                first,
                first / RATE_HZ,
                {name: samples_of(name, first, min(BLOCK, total - first)) for name in channels},
            )
            for first in range(0, total, BLOCK)
        ]
        for block in self.spoil(blocks):
            self._record_call("block")
            yield block
            if stop.is_set():
                return


def record(name: str, seconds: float = 0.25, **setpoints: float) -> Record:
    return Record(
        name=name,
        role="tester",
        channels=("angle", "torque"),
        duration_s=seconds,
        setpoints={f"tester.{drive}": value for drive, value in setpoints.items()},
        units={
            "tester.angle": "rad",
            "tester.torque": "N·m",
            "tester.load": "N",
            "tester.frequency": "Hz",
        },
    )


SETUP = (
    Confirm("Guards closed?", unattended=True),
    Ask("Serial number?", "specimen", "DEMO-0001"),
    SetDrive("tester", "load", 0.0, "N"),
    Zero("tester", "torque", "N·m", within=0.05, duration_s=0.2),
)
MAIN = (
    SetDrive("tester", "load", 1000.0, "N"),
    SetDrive("tester", "frequency", 10.0, "Hz"),
    Settle(0.3),
    record("001_10Hz", load=1000.0, frequency=10.0),
    SetDrive("tester", "frequency", 20.0, "Hz"),
    record("002_20Hz", load=1000.0, frequency=20.0),
)
TEARDOWN = (
    SetDrive("tester", "frequency", 0.0, "Hz"),
    SetDrive("tester", "load", 0.0, "N"),
)


def plan_of(setup: Sequence = SETUP, main: Sequence = MAIN, teardown: Sequence = TEARDOWN) -> Plan:
    phases = ((Phase.SETUP, setup), (Phase.MAIN, main), (Phase.TEARDOWN, teardown))
    return Plan(
        tuple(
            PlannedStep(f"{phase}[{number}]", phase, action, f"{phase} {number}", 1.0)
            for phase, actions in phases
            for number, action in enumerate(actions)
        )
    )


@dataclass
class Listener:
    """A sink that records events, and may raise."""

    before: Callable[[Event], None] = lambda _: None
    events: list[Event] = field(default_factory=list)

    def __call__(self, event: Event) -> None:
        self.before(event)
        self.events.append(event)

    def of(self, kind: type) -> list:
        return [event for event in self.events if isinstance(event, kind)]


def measured(events: Iterable[Event]) -> MeasuredRows:
    """Return the rows of a run from its events."""
    attempts = Attempts()
    for event in events:
        attempts.take(event)
    return attempts.measured()


def run(
    device: FakeTester,
    plan: Plan | None = None,
    *,
    critical: Sequence = (),
    guarded: Sequence = (),
    stop: StopToken | None = None,
    answers: object = None,
    clock: SimulatedClock | None = None,
    pauses: Pauses | None = None,
    resume_at: ResumePoint | None = None,
    inputs: Mapping[str, str] | None = None,
    results: object = None,
) -> RunSummary:
    """Run a plan on a connected rig of one fake tester, in simulated time."""
    clock = clock or SimulatedClock()
    rig = Rig({"tester": device}, clock)
    rig.connect()
    return run_plan(
        plan or plan_of(),
        rig,
        Bus(critical, guarded),
        clock,
        answers or UnattendedAnswers(),
        stop or threading.Event(),
        "test-run",
        pauses=pauses,
        resume_at=resume_at,
        inputs=inputs or {},
        results=results,
    )


class NthCall:
    """Raises at the nth call (counting from 0), and only then."""

    def __init__(
        self,
        number: int,
        error: BaseException,
        never: Sequence[str] = (),
        then: Callable[[object], object] = lambda _: None,
    ) -> None:
        self.then = then
        self.left = number
        self.error = error
        self.never = tuple(never)
        self.raised_at = ""

    def __call__(self, what: object) -> None:
        if str(what) in self.never:
            return
        self.left -= 1
        if self.left == -1:
            self.raised_at = str(what)
            raise self.error
        self.then(what)
