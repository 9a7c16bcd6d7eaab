"""Every check of an analysis, in the order in which a report has them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Bias
from rigrunner_bearings.api.rig import rig_of
from rigrunner_bearings.torque.checks import (
    RANGE,
    SAMPLES,
    STROKE,
    ZERO_DRIFT,
    friction_check,
    positive_check,
    run_checks,
    zero_drift_check,
)
from rigrunner_bearings.torque.consistency import agreement
from rigrunner_bearings.torque.one_setup import setup_check, unloaded_check

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api import Check, Component, RunData
    from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation
    from rigrunner_bearings.api.points import PeakPoint

NO_LOAD, NO_LOAD_AFTER = "no-load run: ", "no-load run after: "
"""Prefixes of the names of the checks of these runs."""

_ERRORS: dict[str, tuple[tuple[str, ...], Callable[[float, Component], float]]] = {
    STROKE.name: (("angle scale",), lambda percent, _: percent / 100),
    ZERO_DRIFT.name: (("sensor drift", "zero drift"), lambda drift, _: drift),
    RANGE.name: (
        ("sensor non-linearity",),
        lambda percent, line: 2 * max(percent / 100 - 1, 0.0) * sqrt(3) * line.input_u,
    ),
}
"""Of a check by its name: which inputs of the budget are off, and by how much for its value.

A swing that is not the eccentric's is an error of the angle's scale, at most; zero readings that
differ are a drift; and beyond full scale the slope of a parabolic error curve grows by twice of
what a reading is beyond it.
"""


@dataclass(frozen=True)
class PreparedRuns:
    """A run and its no-load run, with the prepared points of both."""

    run: RunData
    no_load_run: RunData | None
    loaded: tuple[PeakPoint, ...]
    no_load: tuple[PeakPoint, ...]
    with_half_the_samples_nm: tuple[float, ...] = ()
    """What that moves each torque by; nothing where there are samples enough."""
    no_load_after: RunData | None = None


def diagnose(
    prepared: PreparedRuns, primary: Compensation | None, *, own_no_load: bool
) -> Iterator[Check]:
    """Yield the checks of both runs and of the primary method; none where nothing was prepared.

    `own_no_load`: the no-load points are recordings of the run itself.
    """
    if not prepared.loaded:
        return
    points = primary.points if primary else ()
    for check in _recording_checks(prepared, own_no_load=own_no_load):
        yield _with_effect(check, points, prepared.with_half_the_samples_nm)
    loaded, no_load = prepared.loaded, prepared.no_load
    if prepared.no_load_run is not None:
        yield setup_check(prepared.run, prepared.no_load_run)
    if prepared.no_load_after is not None:
        yield _named_after(setup_check(prepared.run, prepared.no_load_after))
    if no_load:
        yield unloaded_check(loaded, no_load, points)
    if primary is None or not primary.points:
        return
    yield agreement(primary.points)
    # no mapping: a sweep may come back to a frequency, and each of its points counts
    torques = [(point.set_frequency_hz, point.torque.value) for point in primary.points]
    yield positive_check(torques)
    radius = rig_of(prepared.run).swing_radius
    if radius is not None:
        yield friction_check(torques, [point.load_n for point in loaded], radius)


def _recording_checks(prepared: PreparedRuns, *, own_no_load: bool) -> Iterator[Check]:
    points = (*prepared.loaded, *prepared.no_load) if own_no_load else prepared.loaded
    yield from run_checks(prepared.run, points)
    if prepared.no_load_run is not None:
        yield from run_checks(prepared.no_load_run, prepared.no_load, NO_LOAD)
        yield zero_drift_check(prepared.run, prepared.no_load_run)
    if prepared.no_load_after is not None:
        yield _named_after(zero_drift_check(prepared.run, prepared.no_load_after))


def _named_after(check: Check) -> Check:
    return replace(check, name=NO_LOAD_AFTER + check.name)


def checked_by(check: Check) -> str:
    """Return the name of a check, whichever run it was made of."""
    return check.name.removeprefix(NO_LOAD_AFTER).removeprefix(NO_LOAD)


def _with_effect(
    check: Check, points: Sequence[CompensatedPoint], with_half_the_samples_nm: Sequence[float]
) -> Check:
    """Return a check of the recordings with what it moves each point by."""
    name = checked_by(check)
    shifts_nm: tuple[float, ...] = ()
    if name == SAMPLES.name:
        shifts_nm = tuple(with_half_the_samples_nm)
    elif name in _ERRORS and check.value is not None:
        inputs, error = _ERRORS[name]
        shifts_nm = tuple(
            sum(c.sensitivity * error(check.value, c) for c in p.components if c.name in inputs)
            for p in points
        )
    if check.ok or not shifts_nm:
        return check
    biases = tuple(
        Bias(f"{point.frequency_hz:.4g} Hz", bias, 0.0)
        for point, bias in zip(points, shifts_nm, strict=True)
    )
    return replace(check, biases=biases)
