"""The methods side by side: spread over frequency, uncertainty and, in a simulation, error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.coverage import expanded
from rigrunner_bearings.report.view.points import by_frequency, error, true_parameter
from rigrunner_reports.numbers import (
    fixed,
    plain,
    significant,
    with_sign,
    with_standard_uncertainty,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Estimate
    from rigrunner_bearings.api.compensations import Compensation
    from rigrunner_bearings.api.torque import TorqueDetails
    from rigrunner_bearings.report.view.points import SetPoint

MILLI = 1e3
PLACES = 3


@dataclass(frozen=True)
class At:
    """A value and its set frequency in Hz."""

    value: str
    frequency: str


@dataclass(frozen=True)
class Parameter:
    """A parameter of the rig that a method identified, with the simulated truth if known."""

    name: str
    value: str
    truth: str


@dataclass(frozen=True)
class Evenness:
    """How a method's torque varies over frequency: values in N·m, widths in mN·m."""

    lowest: At
    highest: At
    spread: str
    largest_u: str


@dataclass(frozen=True)
class Accuracy:
    """How far a method is from the simulated truth, in mN·m."""

    rms: str
    worst: At
    covered: str


@dataclass(frozen=True)
class MethodView:
    """One method over the whole run; without evenness if it gave no points."""

    name: str
    primary: bool
    measurand: str
    not_applicable: str
    notes: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    evenness: Evenness | None
    accuracy: Accuracy | None


@dataclass(frozen=True)
class Error:
    """A method's value minus the truth at one set frequency, with the U it states; N·m."""

    set_frequency_hz: float
    value: float
    expanded: float

    @property
    def covered(self) -> bool:
        """Whether the stated interval holds the truth."""
        return abs(self.value) <= self.expanded


def methods(torque: TorqueDetails, points: Sequence[SetPoint]) -> tuple[MethodView, ...]:
    """Return every method of the run, the primary one first."""
    views = [
        _view(torque, name, compensation, points)
        for name, compensation in torque.compensations.items()
    ]
    return tuple(sorted(views, key=lambda view: not view.primary))


def torques(points: Sequence[SetPoint], name: str) -> list[tuple[float, Estimate]]:
    """Return (set frequency, torque) of a method in the order of frequency."""
    return [
        (set_point.point.set_frequency_hz, set_point.by_method[name].torque)
        for set_point in by_frequency(points)
        if name in set_point.by_method
    ]


def spread(method_torques: Sequence[tuple[float, Estimate]]) -> float:
    """Return the largest minus the smallest value in N·m."""
    values = [torque.value for _, torque in method_torques]
    return max(values) - min(values)


def largest_expanded(method_torques: Sequence[tuple[float, Estimate]]) -> float:
    """Return the largest U in N·m."""
    return max(expanded(torque) for _, torque in method_torques)


def errors(points: Sequence[SetPoint], name: str, compensation: Compensation) -> list[Error]:
    """Return the error at every set-point of which the truth is known, in order of frequency."""
    return [
        Error(set_point.point.set_frequency_hz, off, expanded(set_point.by_method[name].torque))
        for set_point in by_frequency(points)
        if (off := error(set_point, name, compensation)) is not None
    ]


def _view(
    torque: TorqueDetails, name: str, compensation: Compensation, points: Sequence[SetPoint]
) -> MethodView:
    method_torques = torques(points, name)
    method_errors = errors(points, name, compensation)
    return MethodView(
        name=name,
        primary=name == torque.primary,
        measurand=compensation.measurand,
        not_applicable="" if method_torques else compensation.not_applicable or "it gave no points",
        notes=compensation.notes,
        parameters=tuple(
            _parameter(name, parameter, points)
            for name, parameter in compensation.parameters.items()
        ),
        evenness=_evenness(method_torques) if method_torques else None,
        accuracy=_accuracy(method_errors) if method_errors else None,
    )


def _evenness(method_torques: Sequence[tuple[float, Estimate]]) -> Evenness:
    low, high = (pick(method_torques, key=lambda pair: pair[1].value) for pick in (min, max))
    return Evenness(
        lowest=At(fixed(low[1].value, PLACES), plain(low[0])),
        highest=At(fixed(high[1].value, PLACES), plain(high[0])),
        spread=fixed(MILLI * spread(method_torques), 0),
        largest_u=fixed(MILLI * largest_expanded(method_torques), 0),
    )


def covered_points(method_errors: Sequence[Error]) -> str:
    """Return at how many of the set-points the interval holds the truth: '7 of 8'."""
    return f"{sum(error.covered for error in method_errors)} of {len(method_errors)}"


def _accuracy(method_errors: Sequence[Error]) -> Accuracy:
    worst = max(method_errors, key=lambda error: abs(error.value))
    rms = float(np.sqrt(np.mean([error.value**2 for error in method_errors])))
    return Accuracy(
        rms=fixed(MILLI * rms, 1),
        worst=At(with_sign(MILLI * worst.value, 1), plain(worst.set_frequency_hz)),
        covered=covered_points(method_errors),
    )


def _parameter(name: str, estimate: Estimate, points: Sequence[SetPoint]) -> Parameter:
    unit = "" if estimate.unit == "1" else estimate.unit
    truth = true_parameter(points, name)
    return Parameter(
        name=name,
        value=with_standard_uncertainty(estimate.value, estimate.u, unit),
        truth="" if truth is None else f"{significant(truth)} {unit}",
    )
