"""Checks on kinds of steps: each is planned and executed on a simulated rig."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.api.devices import DeviceContext
from rigrunner.api.errors import DataError, InvalidFileError
from rigrunner.api.events import Outcome, StepEnded, StepStarted
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, find_resume_point, run_plan
from rigrunner.plan import make_plan, plan_text
from rigrunner.procedure import kinds_of, parse_procedure
from rigrunner.registry import load_registry
from rigrunner.rig import Rig
from rigrunner.station import parse_station
from rigrunner_testing.check import AnyCheck, Nonconformity, applies, check, demand

if TYPE_CHECKING:
    from rigrunner.api.devices import Clock
    from rigrunner.api.events import Event
    from rigrunner.engine import RunSummary
    from rigrunner.plan import Plan
    from rigrunner_testing.subjects import Subject

ROLE, TESTER = "tester", "swing_tester_sim"
STATION = f"""\
rigrunner: station/1
id: trial
title: A simulated swing tester
rig:
  {{mandrel: M-1, eccentric: 2 mm, centre_distance: 45 mm, inertia: 0.002 kg·m²,
   support_friction: 0.7 N·m, support_damping: 0.3 N·m·s/rad, swing_radius: 10 mm}}
devices: {{{ROLE}: {{type: swing_tester, plugin: {TESTER}}}}}
instruments:
  - {{channel: {ROLE}.torque, serial: T-1, full_scale: 50 N·m, calibration: simulated,
     accuracy: {{gain: 0.1 %, offset: 0.01 N·m, drift: 0.01 N·m, nonlinearity: 0.05 %}},
     low_pass: {{order: 2, corner: 1 kHz}}}}
"""
LITTLE_S = 0.5
"""Tolerance of the duration of a step: it is checked at intervals."""
LITTLE = 0.05
"""The same for long ones, as a fraction of the planned time."""
MIDDLE = 0.37
"""Where a step is stopped, as a fraction of its time: hardly ever between two actions."""
PROMPT_S = 1.0
"""Time limit for the end of a step after the run is asked to stop."""


@dataclass(frozen=True)
class TrialRun:
    """A plan that was run, and its outcome."""

    plan: Plan
    summary: RunSummary
    events: list[Event] = field(repr=False)
    seconds: float = 0.0
    late_s: float = 0.0
    """The time from the stop to the end of the last step."""


@dataclass(frozen=True)
class _StopAt:
    clock: Clock
    at_s: float = math.inf

    def is_set(self) -> bool:
        return self.clock.monotonic_s() >= self.at_s


def _plan(subject: Subject, clock: Clock) -> tuple[Plan, Rig]:
    content = {
        "rigrunner": "procedure/2",
        "id": "TRIAL",
        "revision": "A",
        "title": "One step",
        "measurand": {"symbol": "Td", "name": "torque"},
        "uses": {ROLE: "swing_tester"},
        "main": [{subject.name: dict(subject.settings)}],
    }
    kinds = kinds_of(subject.registry)
    applies(
        subject.registry.validated("step", subject.name, subject.settings).calls() is None,  # type: ignore[attr-defined]  # its record says so
        "it does what another file says",
    )
    device = load_registry().make_device(TESTER, {"seed": 1}, DeviceContext(ROLE, clock, Path()))
    try:
        procedure = parse_procedure(json.dumps(content), "trial", kinds=kinds)
        plan = make_plan(procedure, parse_station(STATION, "trial station"), {ROLE: device})
    except InvalidFileError as error:
        raise Nonconformity(
            str(error), fix="give the record a `trial` for a swing tester in the role 'tester'"
        ) from error
    return plan, Rig({ROLE: device}, clock)


def _run(subject: Subject, stop_after_s: float = math.inf) -> TrialRun:
    clock = SimulatedClock()
    plan, rig = _plan(subject, clock)
    events: list[Event] = []

    def keep(event: Event) -> None:
        events.append(event)

    rig.connect()
    began_s = clock.monotonic_s()
    stop = _StopAt(clock, began_s + stop_after_s)
    try:
        summary = run_plan(plan, rig, Bus([keep]), clock, UnattendedAnswers(), stop, "trial")
    finally:
        rig.close()
    ends_s = [event.monotonic_s for event in events if isinstance(event, StepEnded)]
    starts_s = [event.monotonic_s for event in events if isinstance(event, StepStarted)]
    seconds = ends_s[-1] - starts_s[0] if ends_s else 0.0
    late_s = ends_s[-1] - stop.at_s if ends_s else 0.0
    return TrialRun(plan, summary, events, seconds, late_s)


@check(fix="call planning.emit with each action, a frozen dataclass of numbers and text", needs=())
def is_planned(subject: Subject) -> None:
    """It plans at least one action: a frozen dataclass with a keyword, a text and a duration."""
    plan, _ = _plan(subject, SimulatedClock())
    demand(plan.steps, "it plans nothing")
    kinds = kinds_of(subject.registry)
    for step in plan.steps:
        action, what = step.action, type(step.action).__name__
        frozen = is_dataclass(action) and type(action).__dataclass_params__.frozen
        demand(frozen, f"{what} is not a frozen dataclass")
        demand(getattr(action, "kind", "") in kinds.steps, f"{what}.kind is not a kind of step")
        demand(step.text.strip(), f"{what} is planned without words")
        demand(0 <= step.estimated_s < math.inf, f"{what} is planned for {step.estimated_s} s")
    try:
        for _ in plan_text(plan):
            pass
    except Exception as error:
        raise Nonconformity(f"its actions cannot be kept with the plan: {error}") from error


@check(fix="let the planned time be what the step takes", needs=("is_planned",))
def takes_its_time(subject: Subject) -> None:
    """It is executed, and takes the planned time within 5 % or half a second."""
    run = _run(subject)
    demand(run.summary.outcome is Outcome.COMPLETED, f"it ended as: {run.summary.reason}")
    planned_s = run.plan.estimated_s
    demand(
        abs(run.seconds - planned_s) <= max(LITTLE_S, LITTLE * planned_s),
        f"it took {run.seconds:.3g} s and was planned for {planned_s:.3g} s",
    )


@check(fix="let time pass by doing.wait, or call doing.check often", needs=("takes_its_time",))
def stops_when_asked(subject: Subject) -> None:
    """Stopped in the middle, it ends within a second, and the run is aborted."""
    planned_s = _plan(subject, SimulatedClock())[0].estimated_s
    applies(planned_s > PROMPT_S, "it takes no time in which it could be stopped")
    run = _run(subject, MIDDLE * planned_s)
    demand(run.summary.outcome is Outcome.ABORTED, f"it ended as {run.summary.outcome}")
    demand(run.late_s <= PROMPT_S, f"it ended {run.late_s:.3g} s after it was asked to")


@check(
    fix="let what `doing` raises pass, and move drives by doing.set alone", needs=("is_planned",)
)
def leaves_the_rig_safe(subject: Subject) -> None:
    """After it, or if it is stopped before or in the middle, the rig is read back as safe."""
    planned_s = _plan(subject, SimulatedClock())[0].estimated_s
    for stop_after_s in (math.inf, 0.0, MIDDLE * planned_s):
        run = _run(subject, stop_after_s)
        demand(run.summary.safe, f"the rig was left: {run.summary.unsafe}")


@check(fix="say `repeatable: no` of a step that must not be done twice", needs=("takes_its_time",))
def is_resumed_or_refuses(subject: Subject) -> None:
    """A run that was stopped in this step repeats it when resumed, or refuses."""
    planned_s = _plan(subject, SimulatedClock())[0].estimated_s
    applies(planned_s > PROMPT_S, "it takes no time in which it could be stopped")
    run = _run(subject, MIDDLE * planned_s)
    failed = [event.index for event in run.events if isinstance(event, StepEnded) and not event.ok]
    demand(failed, "it ended as if it was done, though it was stopped in the middle")
    try:
        resume_at = find_resume_point(run.plan.steps, run.events, "the kit")
    except DataError:
        return
    again = {*resume_at.before, *range(resume_at.start, len(run.plan.steps))}
    demand(failed[0] in again, "a resumed run would not do it again, nor refuse to")


CHECKS: tuple[AnyCheck, ...] = (
    is_planned,
    takes_its_time,
    stops_when_asked,
    leaves_the_rig_safe,
    is_resumed_or_refuses,
)
