"""What belongs to one set-point of a plan: what is repeated, skipped, or settled anew."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.plan.actions import Phase, Ramp, Scan, SetDrive, Settle

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.plan.actions import PlannedStep


def point_at(steps: Sequence[PlannedStep], index: int) -> range:
    """Return the steps of the set-point, or the time of a repetition, that a step belongs to.

    The innermost one with all that is inside it; the step alone where there is none.
    """
    points = steps[index].points
    if not points:
        return range(index, index + 1)
    first = index
    while first > 0 and steps[first - 1].points[: len(points)] == points:
        first -= 1
    last = index
    while last + 1 < len(steps) and steps[last + 1].points[: len(points)] == points:
        last += 1
    return range(first, last + 1)


def point_name(steps: Sequence[PlannedStep], index: int) -> str:
    """Return how that set-point is called on record."""
    step = steps[index]
    return step.points[-1] if step.points else step.path


def settles_before(steps: Sequence[PlannedStep], index: int) -> list[int]:
    """Return the settle steps since a drive was last set before a step.

    What was paused has to settle again before the step is done, unless the step sets a drive.
    """
    found: list[int] = []
    if isinstance(steps[index].action, (SetDrive, Ramp, Scan)):
        return found
    for at in range(index - 1, -1, -1):
        action = steps[at].action
        if isinstance(action, (SetDrive, Ramp, Scan)):
            break
        if isinstance(action, Settle):
            found.insert(0, at)
    return found


def unrepeatable(steps: Sequence[PlannedStep], indices: range) -> bool:
    """Say whether one of the steps must not be done twice."""
    return any(not steps[at].terms.repeatable for at in indices)


def teardowns_within(
    steps: Sequence[PlannedStep], begun: int, indices: range
) -> Iterator[tuple[int, PlannedStep]]:
    """Yield the teardown steps to come, among these, of the calls that a begun step is in."""
    within = steps[begun].calls if begun >= 0 else ()
    for index in range(max(begun + 1, indices.start), indices.stop):
        step = steps[index]
        if step.phase is Phase.TEARDOWN and step.calls == within[: len(step.calls)]:
            yield index, step
