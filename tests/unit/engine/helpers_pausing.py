"""A person who pauses a run and decides how it goes on, and a device that can pause."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from helpers_devices import FakeTester, Listener, plan_of, record, run
from rigrunner.api.events import Samples, StepStarted
from rigrunner.clock import SimulatedClock
from rigrunner.engine import Choice, Decision
from rigrunner.plan.actions import Phase, Plan, PlannedStep, Terms
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.settle import Settle

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.engine import Paused

POINTS = 3


@dataclass
class Person:
    """Requests a pause while `pausing`, and gives the decisions one after the other."""

    decisions: list[Decision]
    pausing: bool = False
    seen: list[Paused] = field(default_factory=list)
    clock: SimulatedClock = field(default_factory=SimulatedClock)

    def requested_by(self) -> str:
        return "keyboard" if self.pausing else ""

    def decide(self, paused: Paused, watch: Callable[[], None]) -> Decision:
        self.pausing = False
        self.seen.append(paused)
        self.clock.sleep(1.0)
        watch()
        return self.decisions.pop(0)


def decided(choice: Choice, reason: str = "") -> Decision:
    return Decision(choice, "Ada", reason)


def sweep(points: int = POINTS, **terms: object) -> Plan:
    """Three set-points: set, settle, record; each a point of its own."""
    steps = []
    for number in range(points):
        name = f"main[0].sweep[{number}]"
        actions = (
            SetDrive("tester", "frequency", 10.0 + number, "Hz"),
            Settle(0.5),
            record(f"{number + 1:03d}", seconds=0.5, frequency=10.0 + number),
        )
        for action in actions:
            kind = type(action).__name__.lower()
            step = PlannedStep(f".{kind}", Phase.MAIN, action, "", 1.0, points=(name,))
            if kind == "record":
                step = replace(step, terms=Terms(**terms))
            steps.append(step)
    return Plan((*steps, *plan_of((), ()).steps))


def pausing_run(
    at: str,
    *decisions: Decision,
    plan: Plan | None = None,
    device: FakeTester | None = None,
    inside: bool = False,
    **more: object,
):
    """Pause once, when the step `at` begins (or inside its recording); return all objects."""
    person, listener = Person(list(decisions)), Listener()

    def notice(event: object) -> None:
        if isinstance(event, StepStarted) and event.step == at and not inside and not person.seen:
            person.pausing = True
        if isinstance(event, Samples) and inside and not person.seen:
            person.pausing = listener.of(StepStarted)[-1].step == at

    listener.before = notice
    device = device or FakeTester()
    summary = run(
        device, plan or sweep(), critical=[listener], pauses=person, clock=person.clock, **more
    )
    return summary, listener, person, device


class Patient(FakeTester):
    """A tester that can pause."""

    held = 0.0

    def pause(self) -> None:
        self._record_call("pause")
        self.held, self.drives_at["frequency"] = self.drives_at["frequency"], 0.0

    def resume(self) -> None:
        self._record_call("resume")
        self.drives_at["frequency"] = self.held
