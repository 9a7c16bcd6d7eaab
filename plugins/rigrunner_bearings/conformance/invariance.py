"""Checks on what is none of a compensation's business, as far as its record claims no more."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.api import Influence
from rigrunner_bearings.conformance.recordings import each_recording
from rigrunner_bearings.conformance.subject import expanded_nm, torques_nm
from rigrunner_testing.check import applies, check, demand

if TYPE_CHECKING:
    from rigrunner.api import Array, Recording, RunData
    from rigrunner_bearings.conformance.recordings import Runs
    from rigrunner_bearings.conformance.subject import CompensationSubject

LATER_S = 0.0437
OFFSET_NM = 0.3
OTHER_RATE = 1.7
LATER, LITTLE = 0.6, 0.03
"""Of U: by other samples of the same swings, and by arithmetic alone."""
TORQUE = "tester.torque"


@check(fix="take the phase from the angle, not from the first sample", needs=("points_are_whole",))
def time_shift_does_not_matter(subject: CompensationSubject) -> None:
    """When a recording begins does not matter, within its uncertainty."""
    _require_independence(subject, Influence.TIME_SHIFT)
    _demand_unmoved(subject, replace(subject.runs, loaded=_later(subject.runs.loaded)), LATER)


@check(fix="work in seconds and radians, not in samples", needs=("points_are_whole",))
def sample_rate_does_not_matter(subject: CompensationSubject) -> None:
    """Sampled faster it gives the same, within both uncertainties."""
    _require_independence(subject, Influence.SAMPLE_RATE)
    rate_hz = subject.runs.loaded.recordings[0].rate_hz
    _demand_unmoved(subject, subject.recorded(0, OTHER_RATE * rate_hz), np.sqrt(2))


@check(fix="compare loaded with no-load recordings of the same set-up", needs=("points_are_whole",))
def common_offset_falls_out(subject: CompensationSubject) -> None:
    """A torque channel that is off by the same in both runs gives the same."""
    applies(subject.runs.no_load, "it takes no no-load run in which the offset could show")
    _require_independence(subject, Influence.TORQUE_OFFSET)
    _demand_unmoved(subject, subject.runs.changed(_shifted), LITTLE)


@check(
    fix="look no-load points up by their frequency, not by their place", needs=("points_are_whole",)
)
def order_of_recordings_does_not_matter(subject: CompensationSubject) -> None:
    """In another order than the no-load recordings the loaded ones give the same."""
    _require_independence(subject, Influence.ORDER)
    loaded = subject.runs.loaded
    backwards = replace(loaded, recordings=loaded.recordings[::-1])
    compensation = subject.number(replace(subject.runs, loaded=backwards))
    _demand_same(torques_nm(compensation)[::-1], subject, LITTLE)


def _require_independence(subject: CompensationSubject, influence: Influence) -> None:
    moved = influence in subject.record.moved_by
    applies(not moved, f"its record says that it is moved by {influence}")


def _demand_unmoved(subject: CompensationSubject, runs: Runs, part: float) -> None:
    _demand_same(torques_nm(subject.number(runs)), subject, part)


def _demand_same(torques: Array, subject: CompensationSubject, part: float) -> None:
    plain = torques_nm(subject.plain)
    off = np.abs(torques - plain)
    demand(
        (off <= part * expanded_nm(subject.plain)).all(),
        f"it moves by up to {off.max():.2g} N·m; the limit is {part:.2g} of U, and U is up to"
        f" {expanded_nm(subject.plain).max():.4f} N·m",
    )


def _later(run: RunData) -> RunData:
    def change(recording: Recording) -> Recording:
        first = round(LATER_S * recording.rate_hz)
        channels = {name: values[first:] for name, values in recording.channels.items()}
        return replace(recording, channels=channels)

    return each_recording(change)(run)


def _shifted(run: RunData) -> RunData:
    def change(recording: Recording) -> Recording:
        moved = {TORQUE: np.asarray(recording.channels[TORQUE]) + OFFSET_NM}
        return replace(recording, channels=dict(recording.channels) | moved)

    return each_recording(change)(run)


CHECKS = (
    time_shift_does_not_matter,
    sample_rate_does_not_matter,
    common_offset_falls_out,
    order_of_recordings_does_not_matter,
)
