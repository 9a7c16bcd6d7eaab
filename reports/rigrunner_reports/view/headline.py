"""The one number of a run, and what stands beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.torque import TorqueDetails
from rigrunner.signal.coverage import expanded
from rigrunner_reports.numbers import fixed, plain, stated, with_sign
from rigrunner_reports.section import Section
from rigrunner_reports.view.points import by_frequency

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.results import Result
    from rigrunner_reports.view.points import SetPoint

MILLI = 1e3
LOAD_KEPT = 0.01


@dataclass(frozen=True)
class Headline:
    """The large number: value and interval, or words where there is none."""

    label: str
    symbol: str
    value: str
    interval: str
    unit: str
    detail: str
    problem: str = ""


@dataclass(frozen=True)
class Raw:
    """The torque as the sensor shows it."""

    text: str
    factor: str
    ratio: str


@dataclass(frozen=True)
class Truth:
    """The simulated truth beside the headline."""

    value: str
    error: str
    covered: bool


def headline(result: Result, points: Sequence[SetPoint]) -> Headline:
    """Return the compensated torque; why there is none; or the range of a run's own peaks."""
    torque = TorqueDetails.of(result)
    if torque.headline is not None:
        shown = stated(torque.headline)
        return Headline(
            label=result.measurand,
            symbol=result.symbol,
            value=shown.value,
            interval=f"± {shown.expanded}",
            unit=shown.unit,
            detail=f"U for 95 %, k = {shown.factor}. {_span(points)}, by {torque.primary}.",
        )
    if torque.primary:
        problem = result.notes[0] if result.notes else f"{torque.primary} gave no result"
        return Headline(result.measurand, result.symbol, "no result", "", "", "", problem)
    if points:
        return _peaks(result, points)
    if result.other_results:
        return _named(result)
    return _counted(result) if result.limits.values else _recorded(result)


def raw(torque: TorqueDetails) -> Raw | None:
    """Return the raw torque, and how many times the compensated one it is."""
    if torque.raw_headline is None or not torque.compensations:
        return None
    shown = stated(torque.raw_headline)
    value = torque.headline.value if torque.headline else 0.0
    ratio = f"{torque.raw_headline.value / value:.1f}" if value > 0 else ""
    return Raw(str(shown), shown.factor, ratio)


def truth(torque: TorqueDetails, points: Sequence[SetPoint]) -> Truth | None:
    """Return the mean truth over the set-points of the headline, and the headline's error."""
    true = [
        each.truth_nm
        for each in points
        if each.truth_nm is not None and torque.primary in each.by_method
    ]
    if torque.headline is None or len(true) < len(points):
        return None
    mean = float(np.mean(true))
    error = torque.headline.value - mean
    return Truth(
        value=f"{fixed(mean, 4)} N·m",
        error=f"{with_sign(MILLI * error, 1)} mN·m",
        covered=abs(error) <= expanded(torque.headline),
    )


def _span(points: Sequence[SetPoint]) -> str:
    ordered = by_frequency(points)
    load = _load([each.point.load_n for each in ordered])
    if len(ordered) == 1:
        return f"One set-point, {ordered[0].frequency_hz:.4g} Hz, under {load}"
    low, high = (plain(ordered[i].point.set_frequency_hz) for i in (0, -1))
    return f"Mean of {len(ordered)} set-points, {low} Hz to {high} Hz, under {load}"


def _load(loads_n: Sequence[float]) -> str:
    """Return the mean load, or its range where it was not kept within 1 %."""
    low, high = min(loads_n), max(loads_n)
    if high - low <= LOAD_KEPT * high:
        return f"{float(np.mean(loads_n)):.0f} N"
    return f"{low:.0f} N to {high:.0f} N"


def _named(result: Result) -> Headline:
    """Return the result on which the verdict rests, or else the first one."""
    deciding = None if result.decision is None else result.decision.deciding
    found = next(
        (e for e in result.other_results if deciding is not None and e.estimate is deciding.result),
        result.other_results[0],
    )
    estimate, place, several = found.estimate, found.place, len(result.other_results) > 1
    label = found.of.words
    if deciding is not None and deciding.result is not None:
        estimate = deciding.result
        if estimate is not found.estimate:  # a mean of several
            label, place = deciding.of, ""
    shown = stated(estimate)
    where = f"At {place}. " if place else ""
    others = f" One of {len(result.other_results)} results; all are below." if several else ""
    return Headline(
        label=label[:1].upper() + label[1:],
        symbol=found.of.symbol,
        value=shown.value,
        interval=f"± {shown.expanded}",
        unit=shown.unit,
        detail=f"{where}U for 95 %, k = {shown.factor}.{others}",
    )


def _recorded(result: Result) -> Headline:
    """Return what was recorded: of a run without results and limits."""
    recordings, rows = len(result.run.recordings), len(result.run.measurements)
    value = f"{recordings}" if recordings else f"{rows}"
    return Headline(
        label="Recordings" if recordings else "Rows of measured values",
        symbol="",
        value=value,
        interval="",
        unit="",
        detail="The procedure asks for no analysis and has no limits: this is what was recorded.",
    )


def _counted(result: Result) -> Headline:
    """Return how many measured values are within their limits: of a run without an analysis."""
    missed, judged = len(result.limits.missed), len(result.limits.values)
    return Headline(
        label="Measured values out of limits" if missed else "Measured values within limits",
        symbol="",
        value=f"{missed or judged} of {judged}",
        interval="",
        unit="",
        detail="Every one of them is in the table below.",
    )


def _peaks(result: Result, points: Sequence[SetPoint]) -> Headline:
    ordered = by_frequency(points)
    if not ordered:
        problem = "the procedure names neither a fit nor a compensation"
        return Headline(result.measurand, result.symbol, "no result", "", "", "", problem)
    low, high = ordered[0], ordered[-1]
    return Headline(
        label=result.measurand,
        symbol=result.symbol,
        value=f"{fixed(low.raw_peak_nm, 3)} to {fixed(high.raw_peak_nm, 3)}",
        interval="",
        unit="N·m",
        detail=f"Mean raw peak of a swing at {plain(low.point.set_frequency_hz)} Hz and at "
        f"{plain(high.point.set_frequency_hz)} Hz; nothing was compensated or decided.",
    )


SECTIONS = (Section("result", "Result", 0, lambda _, page: page, unbroken=True),)
