"""A rig whose device fails on demand, and short forms of the shipped procedures."""

from __future__ import annotations

import os
import signal
import threading
import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING
from unittest.mock import patch

from helpers_devices import Listener
from helpers_workflow import START, edited, registry
from rigrunner.api import calling
from rigrunner.api.errors import DeviceTimeoutError
from rigrunner.api.events import StepStarted
from rigrunner.bus import Bus
from rigrunner.cli.stopping import stop_on_signals
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute, rig_of
from rigrunner.runfile import read

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.data import Block
    from rigrunner.api.devices import ChannelInfo, DriveInfo, Identity, StopToken
    from rigrunner.api.events import Event
    from rigrunner.run.prepare import Planned

HOT_K = 400.0
FAST = (
    "{seed: 1, sensors: {rate: 1 kHz, low_pass: 400 Hz},"
    " frequency_rate: 1000 Hz/s, load_rate: 100 kN/s}"
)
"""A slow converter, for few samples; fast drives, since a hanging one is given its travel time."""
SAFETY = """\
safety:
  order: [tester.frequency, tester.load]
  patience: {connect: 60 s, answer: 60 s}
  interlocks:
    - {name: hot, channel: tester.temperature, above: 100 °C, every: 1 s, does: DOES}
instruments:
"""


class FaultyTester:
    """Passes everything on to a tester; `fault` is called before, and may raise or hang."""

    def __init__(self, tester: object, *, non_blocking: bool = True) -> None:
        self.tester = tester
        self.non_blocking = non_blocking
        self.fault: Callable[[str], None] | None = None
        self.is_hot = False

    def _before(self, call: str) -> None:
        if self.fault is not None:
            self.fault(call)

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        return self.tester.channels

    @property
    def drives(self) -> Sequence[DriveInfo]:
        return self.tester.drives

    @property
    def sample_rate_hz(self) -> float:
        return self.tester.sample_rate_hz

    @property
    def actual(self) -> Mapping[str, float]:
        return {info.name: self.tester.read_back(info.name) for info in self.drives}

    def connect(self, timeout_s: float) -> Identity:
        return self.tester.connect(timeout_s)

    def make_safe(self) -> Mapping[str, float]:
        return self.tester.make_safe()

    def close(self) -> None:
        """Stay connected, for the test to inspect."""

    def set(self, drive: str, value: float) -> None:
        self._before("set")
        self.tester.set(drive, value)

    def read_back(self, drive: str) -> float:
        return self.tester.read_back(drive)

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        self._before("read")
        values = dict(self.tester.read(channels))
        if self.is_hot and "temperature" in values:
            values["temperature"] = HOT_K
        return values

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        for block in self.tester.stream(channels, duration_s, stop):
            self._before("block")
            yield block

    def truth(self) -> Mapping[str, float]:
        return self.tester.truth()


@dataclass
class Faults:
    """Ways in which a step can fail; each arms the device, or the answers, once the step begins."""

    tester: FaultyTester
    answer_error: BaseException | None = None
    hanging: threading.Event = field(default_factory=threading.Event)
    released: threading.Event = field(default_factory=threading.Event)

    def exception(self) -> None:
        self._raise_once(ZeroDivisionError("a plugin's bug"))

    def timeout(self) -> None:
        self._raise_once(DeviceTimeoutError("no answer within 0.1 s"))

    def hang(self) -> None:
        def hang(_call: str) -> None:
            self.tester.fault = None
            self.hanging.set()
            self.released.wait()
            # the tester is now used by the next run, which a late call would disturb
            raise DeviceTimeoutError("it hung until the run was over")

        self.tester.fault = hang

    def interlock(self) -> None:
        self.tester.is_hot = True

    def terminate(self) -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    def interrupt(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    def _raise_once(self, error: BaseException) -> None:
        def fail(_call: str) -> None:
            self.tester.fault = None
            raise error

        self.tester.fault, self.answer_error = fail, error


def is_over_or_hung(hanging: threading.Event) -> Callable[..., bool]:
    """Return an `_is_over` that waits for a call only until the device hangs."""
    is_over = calling._is_over

    def is_over_now(call: object, within_s: float = 0.0) -> bool:
        ends = time.monotonic() + within_s
        while not is_over(call, min(within_s, 0.01)):
            if hanging.is_set() or time.monotonic() > ends:
                hanging.clear()
                return is_over(call)  # just now
        return True

    return is_over_now


@dataclass
class FailingAnswers(UnattendedAnswers):
    """The procedure's own answers; a confirmation may raise the error of a fault."""

    faults: Faults

    def confirm(self, step, question):
        if self.faults.answer_error is not None:
            raise self.faults.answer_error
        return super().confirm(step, question)


def moment_procedure(folder: Path, name: str) -> Path:
    """Write a shipped procedure with all its steps, each as short as can be, and no analysis."""
    shipped = find_procedure(name)
    text = shipped.read_text(encoding="utf-8")
    end = text[text.index("\nanalysis:") :]
    changes = [(end, "\n"), ("cycles: 30}", "cycles: 1}"), ("cycles: 5}", "cycles: 1}")]
    if "cycles: 100}" in text:
        changes.append(("cycles: 100}", "cycles: 1}"))
    return edited(
        shipped, folder / f"{name}.yaml", **{str(i): pair for i, pair in enumerate(changes)}
    )


def moment_station(folder: Path, does: str) -> Path:
    """Write the simulated station with a slow converter and an interlock."""
    source = find_station("simulated")
    text = source.read_text(encoding="utf-8")
    start = text.find("safety:\n")
    end = text.index("instruments:\n") + len("instruments:\n")
    old = text[start if start >= 0 else end - len("instruments:\n") : end]
    return edited(
        source,
        folder / f"{does}.yaml",
        safety=(old, SAFETY.replace("DOES", does)),
        rate=("{seed: 1}", FAST),
    )


def planned_moment(folder: Path, name: str, does: str = "abort", scan: str = "") -> Planned:
    """Plan a shipped procedure in its short form; with a `scan` at the beginning of its main."""
    procedure, station = moment_procedure(folder, name), moment_station(folder, does)
    if scan:
        edited(procedure, procedure, scan=("\nmain:\n", f"\nmain:\n  - scan: {scan}\n"))
    return plan_run(procedure, station, registry(), SimulatedClock(START))


def run_with_fault(
    planned: Planned, index: int, fault: str, runs: Path | None = None
) -> list[Event]:
    """Run with a fault that starts with one step; return the recorded events.

    With `runs` they are read from a sealed run file. Asserts that the simulated rig is at its safe
    values.
    """
    tester = FaultyTester(planned.devices["tester"], non_blocking=fault != "hang")
    faults = Faults(tester)

    def arm(event: object) -> None:
        if isinstance(event, StepStarted) and event.index == index and not armed:
            armed.append(event.step)
            getattr(faults, fault)()

    armed: list[str] = []
    faulty, answers = replace(planned, devices={"tester": tester}), FailingAnswers(faults)
    with (
        stop_on_signals() as stop,
        patch.object(calling, "_is_over", is_over_or_hung(faults.hanging)),
        patch.object(calling.MovingCall, "wait", lambda *_: None),  # it never comes back
    ):
        listeners = [stop, arm]
        if runs is None:
            events = _events(faulty, answers, stop, listeners)
        else:
            finished = execute(
                faulty, runs=runs, inputs={}, partners={}, answers=answers, stop=stop,
                listeners=listeners,
            )  # fmt: skip
            events = list(read(finished.folder).events)
    faults.released.set()
    assert armed, f"the step did not begin: {events[-12:]}"
    assert armed == [planned.plan.steps[index].path]
    assert tester.actual == {"frequency": 0.0, "load": 0.0}
    return events


def _events(planned, answers, stop, listeners) -> list[Event]:
    """Run in memory, on the rig that `execute` makes of a station."""
    rig, listener = rig_of(planned), Listener()
    rig.connect()
    bus = Bus([listener], listeners)
    run_plan(planned.plan, rig, bus, planned.clock, answers, stop, "moment")
    rig.close()
    return listener.events
