"""Checks on what a compensation says where its inputs are missing: a reason, never a number."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from typing import TYPE_CHECKING

from rigrunner.api import DataError
from rigrunner_bearings.api.measurand import Nature
from rigrunner_bearings.conformance.recordings import each_recording
from rigrunner_bearings.conformance.subject import refusal_reason
from rigrunner_bearings.torque.consistency import NAME as AGREEMENT
from rigrunner_testing.check import Nonconformity, applies, check, demand

if TYPE_CHECKING:
    from rigrunner.api import Recording
    from rigrunner_bearings.api.compensations import CompensatedPoint
    from rigrunner_bearings.conformance.subject import CompensationSubject

ANGLE = "tester.angle"


@check(
    fix="without `sweep.no_load` raise DataError, or say it in `not_applicable`",
    needs=("points_are_whole",),
)
def without_no_load_run_it_refuses(subject: CompensationSubject) -> None:
    """What load adds cannot be told without a no-load run: it says so, and gives no number."""
    yields = subject.record.yields
    load_induced = yields is not None and yields.nature is Nature.LOAD_INDUCED
    applies(load_induced, "it yields no load-induced torque")
    words = refusal_reason(subject, replace(subject.runs, no_load=None))
    demand(words, "it gives a number without a no-load run")
    demand("no-load" in words, f"it refuses without naming the no-load run: {words}")


@check(
    fix="look at `point.motion`: without an angle refuse, or widen the uncertainty",
    needs=("points_are_whole",),
)
def without_angle_it_refuses_or_doubts(subject: CompensationSubject) -> None:
    """Without a channel that shows the motion it refuses, or is less sure."""
    runs = subject.runs.changed(each_recording(_without_angle))
    if refusal_reason(subject, runs):
        return
    for sure, unsure in zip(subject.plain.points, subject.number(runs).points, strict=True):
        with_angle, without = _u_without_disagreement(sure), _u_without_disagreement(unsure)
        demand(
            without >= with_angle,
            f"at {sure.set_frequency_hz:g} Hz u is {with_angle:g} N·m with an angle, and only"
            f" {without:g} N·m without",
        )


def _u_without_disagreement(point: CompensatedPoint) -> float:
    """Return u without what set-points that disagree add: those with less u disagree sooner."""
    added = sum(component.u**2 for component in point.components if component.name == AGREEMENT)
    return sqrt(max(point.torque.u**2 - added, 0.0))  # rounding


@check(
    fix="look at the points' type: SwingPoint, StartPoint, or the peaks alone",
    needs=("points_are_whole",),
)
def other_motion_is_refused(subject: CompensationSubject) -> None:
    """Starts given to a method for swings, or swings to one for starts, give no number."""
    try:
        compensation = subject.answer_to_other_motion()
    except DataError:
        return
    motion = "swings" if subject.of_starts else "starts from rest"
    demand(not compensation.points, f"it gives a number for {motion}")
    if not compensation.not_applicable.strip():
        raise Nonconformity(f"it gives neither a number nor a reason for {motion}")


def _without_angle(recording: Recording) -> Recording:
    channels = {name: values for name, values in recording.channels.items() if name != ANGLE}
    return replace(recording, channels=channels)


CHECKS = (
    without_no_load_run_it_refuses,
    without_angle_it_refuses_or_doubts,
    other_motion_is_refused,
)
