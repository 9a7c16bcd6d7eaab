"""Where an interrupted run continues, found from its events and the steps of its plan."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.api.events import Alarm, Intervention, StepEnded, StepStarted
from rigrunner.engine.notes import CONTINUES
from rigrunner.engine.pausing import Choice
from rigrunner.engine.points import point_at, unrepeatable
from rigrunner.plan.actions import Phase

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner.api.events import Event
    from rigrunner.api.member import Member
    from rigrunner.plan.actions import PlannedStep


@dataclass(frozen=True, kw_only=True)
class ResumePoint:
    """How to resume an interrupted run."""

    start: int
    """The step to continue at; the start of the teardown if nothing else is left."""
    before: tuple[int, ...]
    """Steps to execute again before it, in order: setup, zeros, set-points of drives."""
    attempts: Mapping[int, int]
    """Number of attempts of each step, by index."""
    passed_over: tuple[str, ...]
    """Failures and skips after which the run continued."""
    next_seq: int
    """Number of its next event."""
    by: str
    left_out: frozenset[int] = frozenset()
    """Steps that a condition skipped, by index."""
    cycles: Mapping[str, float] = field(default_factory=dict)
    """By role: cycles of the device until the last recorded step."""
    subject: str = ""
    """The state at the interruption, in a sentence."""


def find_resume_point(
    steps: Sequence[PlannedStep], events: Sequence[Event], by: str, subject: str = ""
) -> ResumePoint:
    """Return where a run of these steps continues; raise DataError if it cannot.

    The interrupted set-point starts again. A completed step that must not be executed twice is
    kept; an interrupted one cannot be resumed.
    """
    ended = [event for event in events if isinstance(event, StepEnded) and event.ok]
    done = {event.index for event in ended}
    reached = _reached(steps, events)
    start = _start(steps, reached, done)
    attempts = Counter(event.index for event in events if isinstance(event, StepStarted))
    # Nothing but the teardown of the procedure itself is left.
    over = start == len(steps) or (steps[start].phase is Phase.TEARDOWN and not steps[start].calls)
    # The latest result of a condition counts: a set-point can be repeated.
    leaves = {event.index: event.leaves for event in ended}
    left_out = frozenset(
        index for at, count in leaves.items() for index in range(at + 1, at + 1 + count)
    )
    before = () if over else tuple(_to_repeat(steps, start, done, left_out))
    # What was interrupted may have had its effect or not: the events do not show it.
    for index in (*before, *range(start, reached + 1)):
        was_started = index < len(steps) and attempts[index]
        if was_started and not _may_be_repeated(steps[index], done=index in done):
            raise _not_resumable(f"{steps[index].path} was interrupted, and must not be done twice")
    # A kept step is not executed again, so nothing brings its drive back.
    for index in () if over else _led_before(steps, start, before, left_out):
        if index not in before:
            raise _not_resumable(
                f"{steps[index].path} must not be done twice, and what follows needs"
                " the drive where it left it"
            )
    return ResumePoint(
        start=start,
        before=before,
        attempts=dict(attempts),
        passed_over=tuple(passed_over(events)),
        next_seq=max((event.seq for event in events), default=-1) + 1,
        by=by,
        left_out=left_out,
        cycles=_cycles(events),
        subject=subject,
    )


def _not_resumable(message: str) -> DataError:
    return DataError(message, hint="'rigrunner recover' closes the run as it is")


def _may_be_repeated(step: PlannedStep, *, done: bool) -> bool:
    """Return whether a started step may be executed again: see `restoring_step`."""
    return step.terms.repeatable or (done and step.action.restoring is not None)


def restoring_step(step: PlannedStep) -> PlannedStep:
    """Return steps that restore the rig after a completed step: of a scan its last set-point.

    What such a step measured is kept; setup is executed again as it is, with what it measures.
    """
    action = step.action
    is_setup = step.phase is Phase.SETUP and step.terms.repeatable
    if is_setup or action.restoring is None or action.moves is None:
        return step
    value, unit = action.moves_to[-1], action.setpoints_and_units[1][action.moves]
    text = f"Set {action.moves} to {value:g} {unit}, where the {action.kind} left it"
    # The present position of the drive, and so the duration of its motion, is not known.
    return replace(step, action=action.restoring, text=text, estimated_s=0.0)


def streams_before(
    steps: Sequence[PlannedStep], resume_at: ResumePoint
) -> dict[str, list[dict[str, float]]]:
    """Return by role the set-points, by drive, of each stream that is not repeated, in order."""
    set_points: dict[str, dict[str, float]] = {}
    by_role: dict[str, list[dict[str, float]]] = {}
    for index, step in enumerate(steps[: resume_at.start]):
        action = step.action
        if index in resume_at.left_out:
            continue
        if action.moves:
            set_points.setdefault(action.moves.role, {})[action.moves.name] = action.moves_to[-1]
        # Simulators number their streams by set-point: later ones then have the same noise.
        if index not in resume_at.before and (role := action.streamed):
            by_role.setdefault(role, []).append(dict(set_points.get(role, {})))
    return by_role


def _reached(steps: Sequence[PlannedStep], events: Iterable[Event]) -> int:
    """Return the first forward step that was neither completed nor skipped."""
    reached = 0
    for event in events:
        match event:
            case StepStarted(index=index) if _is_forward(steps, index, reached):
                reached = index
            # `index` may differ: steps that settle again after a pause end here too.
            case StepEnded(index=index, ok=True, leaves=leaves) if index == reached:
                reached = index + 1 + leaves
            case Intervention(action=Choice.SKIP) if reached < len(steps):
                reached = point_at(steps, reached).stop
            case Intervention(action=Choice.REPEAT) if reached < len(steps):
                reached = point_at(steps, reached).start
    return reached


def _cycles(events: Iterable[Event]) -> Mapping[str, float]:
    cycles: Mapping[str, float] = {}
    for event in events:
        # Cycles count from the start of main: the events of setup have other counts.
        if isinstance(event, StepStarted | StepEnded) and event.step.startswith(Phase.MAIN):
            cycles = event.cycles or cycles
    return cycles


def _is_forward(steps: Sequence[PlannedStep], index: int, reached: int) -> bool:
    """Return whether a started step is the progress of the run, not an extra execution.

    Settling after a pause is behind it, and the teardown after a failure ahead.
    """
    step = steps[index]
    if step.phase is Phase.TEARDOWN:
        return index == reached
    return index >= reached


def _start(steps: Sequence[PlannedStep], reached: int, done: set[int]) -> int:
    """Return the start of the set-point reached; the step itself if that must not be repeated."""
    if reached >= len(steps):
        return len(steps)
    first = point_at(steps, reached).start
    # Going back to the start of the set-point would execute these twice.
    return reached if unrepeatable(steps, done.intersection(range(first, reached))) else first


def _to_repeat(
    steps: Sequence[PlannedStep], start: int, done: set[int], left_out: frozenset[int]
) -> list[int]:
    """Return setup, the last zero of each channel, and the last settings of the drives."""
    setup = [index for index in range(start) if steps[index].phase is Phase.SETUP]
    # Setup is the beginning of a plan: all other steps follow it.
    forward = [index for index in range(len(setup), start) if index not in left_out]
    zeros = {zeroed: index for index in forward if (zeroed := steps[index].action.zeroed)}
    # A drive that the set-point sets itself would otherwise be moved twice.
    led = _led_at(steps, start)
    # A zero depends on where the drives stood: each is taken again at the same place.
    sets = {
        index
        for zero in zeros.values()
        for index in _last_sets(steps, len(setup), zero, left_out).values()
    }
    last = _last_sets(steps, len(setup), start, left_out)
    sets |= {index for drive, index in last.items() if drive not in led}
    to_repeat = sorted({*setup, *zeros.values(), *sets} - left_out)
    # A completed step is kept that is an answer, or must not be repeated.
    kept = {
        index
        for index in done.intersection(to_repeat)
        if steps[index].action.outcome_stands or not _may_be_repeated(steps[index], done=True)
    }
    return [index for index in to_repeat if index not in kept]


def _led_before(
    steps: Sequence[PlannedStep], start: int, before: Sequence[int], left_out: frozenset[int]
) -> set[int]:
    """Return the steps that set the drives as needed at the start, and at each zero before it."""
    led = _led_at(steps, start)
    last = _last_sets(steps, 0, start, left_out)
    indices = {index for drive, index in last.items() if drive not in led}
    for zero in before:
        if steps[zero].action.zeroed:
            indices |= set(_last_sets(steps, 0, zero, left_out).values())
    return indices


def _last_sets(
    steps: Sequence[PlannedStep], first: int, end: int, left_out: frozenset[int]
) -> dict[Member, int]:
    """Return by drive the step that last set it, before `end`."""
    forward = (index for index in range(first, end) if index not in left_out)
    return {drive: index for index in forward if (drive := steps[index].action.moves)}


def _led_at(steps: Sequence[PlannedStep], start: int) -> set[Member]:
    """Return the drives that a set-point sets itself, with its first steps."""
    led: set[Member] = set()
    for step in steps[start:]:
        if not step.action.moves:
            break
        led.add(step.action.moves)
        if step.action.reads:
            break
    return led


def passed_over(events: Iterable[Event]) -> Iterator[str]:
    """Yield the failures and skips after which a run continued, as text."""
    for event in events:
        match event:
            case Intervention(action=Choice.SKIP, by=by, reason=reason):
                point, _, why = reason.partition(": ")
                yield f"{point}: skipped by {by}: {why}"
            case Alarm(source=source, text=text) if text.endswith(CONTINUES):
                yield f"{source}: {text.removesuffix(CONTINUES)}"
