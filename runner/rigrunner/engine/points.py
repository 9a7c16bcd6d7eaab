"""The steps of one set-point of a plan, which are repeated, skipped, or settled together."""

from __future__ import annotations

from math import isclose
from typing import TYPE_CHECKING

from rigrunner.api.member import Member
from rigrunner.plan.actions import Phase

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from rigrunner.plan.actions import PlannedStep


def point_at(steps: Sequence[PlannedStep], index: int) -> range:
    """Return the steps of the set-point, or of the pass of a repetition, that contains a step.

    The innermost one with everything inside; the step alone if there is none.
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
    """Return the name of that set-point for the record."""
    step = steps[index]
    return step.points[-1] if step.points else step.path


def settles_before(steps: Sequence[PlannedStep], index: int) -> list[int]:
    """Return the settle steps between the last change of a drive and a step.

    After a pause the rig must settle again before the step, unless the step sets a drive.
    """
    settles: list[int] = []
    if steps[index].action.moves:
        return settles
    for earlier in range(index - 1, -1, -1):
        action = steps[earlier].action
        if action.moves:
            break
        if action.settles:
            settles.insert(0, earlier)
    return settles


def unrepeatable(steps: Sequence[PlannedStep], indices: Iterable[int]) -> bool:
    """Return whether one of the steps must not be executed twice."""
    return any(not steps[index].terms.repeatable for index in indices)


def may_be_skipped(
    steps: Sequence[PlannedStep], index: int, standing: Callable[[str, str], float]
) -> bool:
    """Return whether drives are at their planned set-points for the steps after the set-point.

    False if a skipped step would have set a drive elsewhere, and it is not set again before
    something is read.
    """
    point, planned = point_at(steps, index), dict[Member, float]()
    for step in steps[index : point.stop]:
        if drive := step.action.moves:
            planned.pop(drive, None)
            if step.phase is not Phase.TEARDOWN:  # the teardown of a call is still done
                planned[drive] = step.action.moves_to[-1]
    return _led_before_read(steps, point.stop, planned, standing)


def _led_before_read(
    steps: Sequence[PlannedStep],
    start: int,
    planned: dict[Member, float],
    standing: Callable[[str, str], float],
) -> bool:
    """Return whether each drive is at its planned set-point, or is set before something is read.

    Both branches of a condition count.
    """
    for index in range(start, len(steps)):
        if not planned:
            return True
        step = steps[index]
        # Before `reads`: a scan sets its drive and reads in the same step.
        if drive := step.action.moves:
            planned.pop(drive, None)
        if step.action.reads:
            return all(isclose(standing(d.role, d.name), value) for d, value in planned.items())
        beyond = index + 1 + step.leaves
        if step.leaves and not _led_before_read(steps, beyond, dict(planned), standing):
            return False
    return True


def teardowns_within(
    steps: Sequence[PlannedStep], started: int, indices: range
) -> Iterator[tuple[int, PlannedStep]]:
    """Yield the remaining teardown steps, among these, of the calls that contain a started step."""
    calls = steps[started].calls if started >= 0 else ()
    for index in range(max(started + 1, indices.start), indices.stop):
        step = steps[index]
        if step.phase is Phase.TEARDOWN and step.calls == calls[: len(step.calls)]:
            yield index, step
