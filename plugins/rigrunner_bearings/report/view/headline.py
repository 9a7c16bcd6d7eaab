"""The torque of a run, and the values shown beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.coverage import expanded
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.report.view.points import by_frequency
from rigrunner_reports.numbers import fixed, plain, stated, with_sign
from rigrunner_reports.section import Headline

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.results import Result
    from rigrunner_bearings.report.view.points import SetPoint

MILLI = 1e3
LOAD_KEPT = 0.01
"""Share of the load: if it varied by less, its mean is shown, otherwise its range."""


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


def headline(result: Result, points: Sequence[SetPoint]) -> Headline | None:
    """Return the compensated torque; why there is none; or the range of a run's own peaks."""
    torque = TorqueDetails.of(result)
    if torque.headline is not None:
        shown = stated(torque.headline)
        return Headline(
            label=f"{result.measurand}, compensated",
            symbol=result.symbol,
            value=shown.value,
            interval=f"± {shown.expanded}",
            unit=shown.unit,
            detail=f"U for 95 %, k = {shown.factor}. {_span(points)}, by {torque.primary}.",
        )
    if torque.primary:
        problem = result.notes[0] if result.notes else f"{torque.primary} gave no result"
        return Headline(result.measurand, result.symbol, "no result", "", "", "", problem)
    return _peaks(result, points) if points else None


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
        set_point.truth_nm
        for set_point in points
        if set_point.truth_nm is not None and torque.primary in set_point.by_method
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
    loads_n = [set_point.point.load_n for set_point in ordered]
    least, most = min(loads_n), max(loads_n)
    is_steady = most - least <= LOAD_KEPT * most
    load = f"{float(np.mean(loads_n)):.0f} N" if is_steady else f"{least:.0f} N to {most:.0f} N"
    if len(ordered) == 1:
        return f"One set-point, {ordered[0].frequency_hz:.4g} Hz, under {load}"
    low, high = (plain(ordered[i].point.set_frequency_hz) for i in (0, -1))
    return f"Mean of {len(ordered)} set-points, {low} Hz to {high} Hz, under {load}"


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
