"""Checks on the numbers of a compensation: whole, true, and as uncertain as it says."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.accuracy import Accuracy
from rigrunner.signal.coverage import expanded
from rigrunner.signal.uncertainty import combine
from rigrunner_bearings.api.measurand import Condition, Nature
from rigrunner_bearings.conformance.recordings import CLOSED_FORM, TIME_DOMAIN, Runs, starts, swings
from rigrunner_bearings.conformance.subject import torques_nm
from rigrunner_bearings.torque.headline import compensated_mean
from rigrunner_testing.check import NotApplicable, applies, check, demand

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigrunner.api import Instrument, RunData
    from rigrunner_bearings.conformance.subject import CompensationSubject

CLOSED_FORM_RIGS, TIME_DOMAIN_RIGS = 5, 3
ERRORS = (
    *("repeatability", "hysteresis", "resolution", "creep"),
    *("temperature_zero", "temperature_sensitivity"),
)
MOST_MISSES = 1
"""Of true intervals of 95 %, two of five miss in 2.3 % of all cases, two of three in 0.7 %."""


@check(
    fix="give the record `yields`, and the Compensation the measurand's name",
    needs=("points_are_whole",),
)
def measurand_stated(subject: CompensationSubject) -> None:
    """The record says which torque comes out, and the result names it: a limit is for one alone."""
    demand(subject.record.yields is not None, "its record does not say what it yields")
    demand(subject.plain.measurand.strip(), "its result does not name the measurand")


@check(fix="give one CompensatedPoint for each point of `sweep.loaded`, with torque = raw - rig")
def points_are_whole(subject: CompensationSubject) -> None:
    """There is a finite torque for each set-point, and it is raw torque less the no-load torque."""
    points = subject.plain.points
    if not subject.of_starts:
        recordings = subject.runs.loaded.recordings
        expected = [recording.setpoints["tester.frequency"] for recording in recordings]
        frequencies = [point.set_frequency_hz for point in points]
        demand(frequencies == expected, f"set-points are {expected} Hz, it gives {frequencies} Hz")
    for point in points:
        where = f"at {point.set_frequency_hz:g} Hz"
        demand(np.isfinite(point.torque.value), f"{where} the torque is {point.torque.value}")
        less = point.raw_nm - point.rig_nm
        demand(
            np.isclose(less, point.torque.value, atol=1e-9),
            f"{where} raw less rig is {less:g} N·m, the torque {point.torque.value:g} N·m",
        )
        demand(
            np.isclose(point.frequency_hz, point.set_frequency_hz, rtol=0.01),
            f"{where} it gives a frequency of {point.frequency_hz:g} Hz",
        )


@check(
    fix="make the point with `rigrunner_bearings.signal.compensated.compensated_point`",
    needs=("points_are_whole",),
)
def uncertainty_is_made_of_its_parts(subject: CompensationSubject) -> None:
    """The uncertainty is finite, in N·m, and what the lines of its budget combine to (GUM 5.1)."""
    for point in subject.plain.points:
        where = f"at {point.set_frequency_hz:g} Hz"
        torque, parts = point.torque, point.components
        demand(parts, f"{where} there is no budget")
        names = [part.name for part in parts]
        demand(len(set(names)) == len(names), f"{where} a line is given twice: {', '.join(names)}")
        u, dof = combine(parts)
        demand(torque.unit == "N·m", f"{where} the torque is in {torque.unit}")
        demand(0 < torque.u < np.inf, f"{where} u is {torque.u}")
        demand(
            np.isclose(torque.u, u, rtol=1e-6),
            f"{where} u is {torque.u:g} N·m, its lines give {u:g} N·m",
        )
        same = torque.dof == dof or np.isclose(torque.dof, dof, rtol=1e-3)
        demand(same, f"{where} there are {torque.dof:g} degrees of freedom, its lines give {dof:g}")


@check(
    fix="bring the register's accuracy in, by `rigrunner_bearings.signal.sensor`",
    needs=("points_are_whole",),
)
def sensor_is_in_the_budget(subject: CompensationSubject) -> None:
    """A transducer that is ten times less accurate makes the uncertainty larger."""
    worse = subject.number(subject.runs.changed(_ten_times_worse))
    for good, bad in zip(subject.plain.points, worse.points, strict=True):
        demand(
            bad.torque.u > good.torque.u,
            f"at {good.set_frequency_hz:g} Hz u is {good.torque.u:g} N·m with the transducer as it"
            f" is, and {bad.torque.u:g} N·m with one ten times less accurate",
        )


@check(
    fix="add `rigrunner.signal.transducer.transducer_effects` to the effects of each point",
    needs=("points_are_whole",),
)
def transducer_errors_are_in_the_budget(subject: CompensationSubject) -> None:
    """Each error that the register states of a transducer is a line that names its source."""
    stated = subject.number(subject.runs.changed(_with_errors))
    for plain, point in zip(subject.plain.points, stated.points, strict=True):
        where = f"at {point.set_frequency_hz:g} Hz"
        lines = [part.name for part in point.components]
        missing = [error for error in ERRORS if not any(_source(error) in line for line in lines)]
        demand(not missing, f"{where} the budget has no line for {', '.join(missing)}")
        demand(
            point.torque.u > plain.torque.u,
            f"{where} u is {plain.torque.u:g} N·m without these errors, and {point.torque.u:g} N·m"
            " with them",
        )


@check(
    fix="let nothing depend on chance, or on what was analysed before", needs=("points_are_whole",)
)
def same_recordings_same_numbers(subject: CompensationSubject) -> None:
    """The same recordings give the same numbers."""
    first, again = subject.plain, subject.number(subject.runs)
    same = np.array_equal(torques_nm(first), torques_nm(again))
    demand(same, f"first it gives {torques_nm(first)}, then {torques_nm(again)}")


@check(
    fix="find what the budget lacks; state a known bias in `not_covered`",
    needs=("points_are_whole",),
)
def truth_is_within_its_interval(subject: CompensationSubject) -> None:
    """On five random rigs in closed form its 95 % interval holds the truth, or misses it once."""
    _require_known_truth(subject)
    simulate = starts if subject.of_starts else lambda number: swings(CLOSED_FORM, number)
    _demand_coverage(subject, [simulate(number) for number in range(CLOSED_FORM_RIGS)])


@check(
    fix="find what the method takes from the closed form, which this rig does not share",
    needs=("points_are_whole",),
)
def truth_is_within_it_on_another_rig(subject: CompensationSubject) -> None:
    """On three random rigs in the time domain it holds the truth, or misses it once."""
    _require_known_truth(subject)
    applies(not subject.of_starts, "starts are simulated by one rig alone")
    _demand_coverage(subject, [swings(TIME_DOMAIN, number) for number in range(TIME_DOMAIN_RIGS)])


def _require_known_truth(subject: CompensationSubject) -> None:
    """Raise NotApplicable where no coverage is claimed, or no simulator knows the truth."""
    applies(not subject.record.not_covered, f"its record says: {subject.record.not_covered}")
    yields = subject.record.yields
    if yields is None:
        raise NotApplicable("its record does not say what it yields")
    simulated = {(Nature.LOAD_INDUCED, Condition.AT_REVERSAL), (Nature.TOTAL, Condition.FROM_REST)}
    applies(
        (yields.nature, yields.condition) in simulated,
        f"no simulator that ships knows the true {yields}",
    )


def _demand_coverage(subject: CompensationSubject, rigs: Sequence[Runs]) -> None:
    errors = []
    for runs in rigs:
        compensation = subject.answer(runs)
        if compensation.points:
            mean = compensated_mean(compensation.points)
            errors.append(abs(mean.value - float(np.mean(runs.truths_nm))) / expanded(mean))
    demand(errors, f"it gives no number on any of {len(rigs)} rigs")
    misses = sum(error > 1 for error in errors)
    demand(
        misses <= MOST_MISSES,
        f"on {misses} of {len(errors)} rigs the mean is farther from the truth than it says: errors"
        f" are {', '.join(f'{error:.1f}' for error in errors)} times U",
    )


def _source(error: str) -> str:
    return f"sheet {ERRORS.index(error) + 1}"


def _with_errors(run: RunData) -> RunData:
    temperature_range = {"per": "10 K", "within": "10 K"}
    stated = {
        name: {"limit": "0.2 % FS", "source": _source(name)}
        | (temperature_range if name.startswith("temperature") else {})
        for name in ERRORS
    }
    return _with_limits(run, lambda _: stated)


def _ten_times_worse(run: RunData) -> RunData:
    return _with_limits(
        run,
        lambda instrument: {
            "gain": f"{1000 * instrument.half_width('gain')!r} %",
            "drift": f"{10 * instrument.half_width('drift')!r} N·m",
        },
    )


def _with_limits(run: RunData, limits: Callable[[Instrument], Mapping[str, object]]) -> RunData:
    """Return a run whose instruments state these limits of error, and what they stated besides."""
    changed = {}
    for name, instrument in run.instruments.items():
        stated = Accuracy.model_validate(limits(instrument)).limits
        accuracy = (instrument.accuracy or Accuracy()).model_copy(update=stated)
        changed[name] = instrument.model_copy(update={"accuracy_": accuracy})
    return replace(run, instruments=changed)


CHECKS = (
    points_are_whole,
    measurand_stated,
    uncertainty_is_made_of_its_parts,
    sensor_is_in_the_budget,
    transducer_errors_are_in_the_budget,
    same_recordings_same_numbers,
    truth_is_within_its_interval,
    truth_is_within_it_on_another_rig,
)
