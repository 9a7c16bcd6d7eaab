"""The methods side by side: how even, how sure and, in a simulation, how right each one is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_reports.numbers import (
    expanded,
    fixed,
    plain,
    significant,
    with_sign,
    with_standard_uncertainty,
)
from rigrunner_reports.view.points import by_frequency, error, true_parameter

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.analysis import Compensation
    from rigrunner.api.data import Estimate
    from rigrunner.api.results import Result
    from rigrunner_reports.view.points import SetPoint

MILLI = 1e3
PAPER_METHOD = "paper_peak"


@dataclass(frozen=True)
class Parameter:
    """What a method learned of the rig, with the simulated truth where it is known."""

    name: str
    value: str
    truth: str = ""


@dataclass(frozen=True)
class MethodView:
    """One method over the whole run; `rms_error` and what follows only where truth is known."""

    name: str
    primary: bool
    measurand: str
    not_applicable: str
    notes: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    lowest: str = ""
    highest: str = ""
    spread: str = ""
    largest_u: str = ""
    rms_error: str = ""
    worst_error: str = ""
    covered: str = ""


def methods(result: Result, points: Sequence[SetPoint]) -> tuple[MethodView, ...]:
    """Return every method of the run, the primary one first."""
    views = [_view(result, name, each, points) for name, each in result.compensations.items()]
    return tuple(sorted(views, key=lambda view: not view.primary))


def paper_on_this_run(result: Result, points: Sequence[SetPoint]) -> tuple[str, ...]:
    """Return what the published method does on this run, in sentences made of its numbers."""
    paper = result.compensations.get(PAPER_METHOD)
    if paper is None or not paper.points:
        return ()
    found = _found(points, PAPER_METHOD)
    low, high = found[0], found[-1]
    spread = _spread([torque for _, torque in found])
    width = max(expanded(torque) for _, torque in found)
    sentences = [
        f"On this run it gives {fixed(low[1].value, 3)} N·m at {plain(low[0])} Hz and "
        f"{fixed(high[1].value, 3)} N·m at {plain(high[0])} Hz; over all set-points it varies by "
        f"{fixed(spread, 3)} N·m, where its own stated U is at most {fixed(width, 3)} N·m.",
        _comparison(result, points, spread),
        *_against_truth(paper, points),
    ]
    return tuple(sentence for sentence in sentences if sentence)


def _view(
    result: Result, name: str, compensation: Compensation, points: Sequence[SetPoint]
) -> MethodView:
    return MethodView(
        name=name,
        primary=name == result.primary,
        measurand=compensation.measurand,
        not_applicable="" if compensation.points else compensation.not_applicable or "no points",
        notes=compensation.notes,
        parameters=_parameters(compensation.parameters, points),
        **_evenness(points, name),
        **_accuracy(points, name, compensation),
    )


def _evenness(points: Sequence[SetPoint], name: str) -> dict[str, str]:
    found = _found(points, name)
    if not found:
        return {}
    values = [torque.value for _, torque in found]
    return {
        "lowest": _at(min(values), found),
        "highest": _at(max(values), found),
        "spread": fixed(MILLI * _spread([torque for _, torque in found]), 0),
        "largest_u": fixed(MILLI * max(expanded(torque) for _, torque in found), 0),
    }


def _accuracy(points: Sequence[SetPoint], name: str, compensation: Compensation) -> dict[str, str]:
    errors = _errors(points, name, compensation)
    if not errors:
        return {}
    off = np.array([each for _, each, _ in errors])
    worst = int(np.argmax(np.abs(off)))
    covered = sum(abs(each) <= width for _, each, width in errors)
    return {
        "rms_error": fixed(MILLI * float(np.sqrt(np.mean(off**2))), 1),
        "worst_error": f"{with_sign(MILLI * off[worst], 1)} at {plain(errors[worst][0])} Hz",
        "covered": f"{covered} of {len(errors)}",
    }


def _errors(
    points: Sequence[SetPoint], name: str, compensation: Compensation
) -> list[tuple[float, float, float]]:
    """Return (set frequency, error, U) of every set-point of which the truth is known."""
    return [
        (each.point.set_frequency_hz, off, expanded(each.by_method[name].torque))
        for each in by_frequency(points)
        if (off := error(each, name, compensation)) is not None
    ]


def _found(points: Sequence[SetPoint], name: str) -> list[tuple[float, Estimate]]:
    return [
        (each.point.set_frequency_hz, each.by_method[name].torque)
        for each in by_frequency(points)
        if name in each.by_method
    ]


def _spread(torques: Sequence[Estimate]) -> float:
    values = [torque.value for torque in torques]
    return max(values) - min(values)


def _at(value: float, found: Sequence[tuple[float, Estimate]]) -> str:
    frequency = next(hz for hz, torque in found if torque.value == value)
    return f"{fixed(value, 3)} at {plain(frequency)} Hz"


def _comparison(result: Result, points: Sequence[SetPoint], spread: float) -> str:
    primary = _found(points, result.primary) if result.primary != PAPER_METHOD else []
    if not primary:
        return ""
    own = _spread([torque for _, torque in primary])
    return f"By {result.primary} the same recordings vary by {fixed(own, 3)} N·m" + (
        f", {spread / own:.0f} times less." if own > 0 and spread / own > 1.5 else "."  # noqa: PLR2004
    )


def _against_truth(paper: Compensation, points: Sequence[SetPoint]) -> list[str]:
    errors = _errors(points, PAPER_METHOD, paper)
    if not errors:
        return []
    (low_hz, low, _), (high_hz, high, _) = (
        min(errors, key=lambda each: each[1]),
        max(errors, key=lambda each: each[1]),
    )
    covered = sum(abs(off) <= width for _, off, width in errors)
    return [
        f"Against the simulated truth it errs by {with_sign(MILLI * low, 0)} mN·m at "
        f"{plain(low_hz)} Hz to {with_sign(MILLI * high, 0)} mN·m at {plain(high_hz)} Hz; its "
        f"stated U covers the truth at {covered} of {len(errors)} set-points."
    ]


def _parameters(
    parameters: Mapping[str, Estimate], points: Sequence[SetPoint]
) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(
            name,
            with_standard_uncertainty(each.value, each.u, "" if each.unit == "1" else each.unit),
            "" if (true := true_parameter(points, name)) is None else significant(true),
        )
        for name, each in parameters.items()
    )
