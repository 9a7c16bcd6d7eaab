"""What the published method does on a run, in sentences made of the run's own numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.averaging import robust_mean
from rigrunner.signal.rounding import places
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.report.view.methods import (
    covered_points,
    errors,
    largest_expanded,
    spread,
    torques,
)
from rigrunner_reports.numbers import fixed, plain, with_sign

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.torque import TorqueDetails
    from rigrunner_bearings.report.view.methods import Error
    from rigrunner_bearings.report.view.points import SetPoint

METHOD = "paper_peak"
MILLI = 1e3
TURN_DEG = 360
WORTH_SAYING = 1.5


def paper_on_this_run(torque: TorqueDetails, points: Sequence[SetPoint]) -> tuple[str, ...]:
    """Return the sentences; none where the method did not take part."""
    if not torques(points, METHOD):
        return ()
    paper_errors = errors(points, METHOD, torque.compensations[METHOD])
    return (
        _range(points),
        *_extremes(torque, points),
        *_beside_primary(torque, points),
        *([_against_truth(paper_errors)] if paper_errors else []),
    )


def _range(points: Sequence[SetPoint]) -> str:
    paper_torques = torques(points, METHOD)
    (low_hz, low), (high_hz, high) = paper_torques[0], paper_torques[-1]
    return (
        f"On this run it gives {fixed(low.value, 3)} N·m at {plain(low_hz)} Hz and "
        f"{fixed(high.value, 3)} N·m at {plain(high_hz)} Hz; over all set-points it varies by "
        f"{fixed(spread(paper_torques), 3)} N·m, where its own stated U is at most "
        f"{fixed(largest_expanded(paper_torques), 3)} N·m."
    )


def _extremes(torque: TorqueDetails, points: Sequence[SetPoint]) -> Iterator[str]:
    """Yield what the lowest and the highest value are made of, where a no-load point is there."""
    no_load = {point.set_frequency_hz: point for point in torque.no_load}
    measured = [set_point for set_point in points if METHOD in set_point.by_method]
    for pick in (min, max):
        set_point = pick(measured, key=lambda point: point.by_method[METHOD].torque.value)
        if set_point.point.set_frequency_hz in no_load:
            yield _parts(set_point, no_load[set_point.point.set_frequency_hz])


def _parts(set_point: SetPoint, no_load: PeakPoint) -> str:
    """Return the value as difference of the measured peaks plus the misfit of the curve."""
    result = set_point.by_method[METHOD]
    peak_nm = float(no_load.peak_nm[no_load.peak_kept].mean())
    side = "below" if peak_nm > result.rig_nm else "above"
    return (
        f"At {plain(set_point.point.set_frequency_hz)} Hz the measured peaks differ by "
        f"{fixed(result.raw_nm - peak_nm, 3)} N·m{_phases(set_point, no_load)}. The subtracted "
        f"curve is {fixed(abs(peak_nm - result.rig_nm), 3)} N·m {side} the measured no-load peak. "
        f"Together this makes {fixed(result.torque.value, 3)} N·m."
    )


def _phases(set_point: SetPoint, no_load: PeakPoint) -> str:
    if set_point.swing is None or not isinstance(no_load, SwingPoint):
        return ""
    means = [robust_mean(point.torque_nm, point.kept)[0] for point in (set_point.swing, no_load)]
    loaded_deg, no_load_deg = (TURN_DEG * float(np.argmax(mean)) / len(mean) for mean in means)
    return (
        f"; in the mean swings they stand at {loaded_deg:.0f}° (loaded) and {no_load_deg:.0f}° "
        "(no load) of the crank"
    )


def _beside_primary(torque: TorqueDetails, points: Sequence[SetPoint]) -> Iterator[str]:
    primary = torques(points, torque.primary)
    if not primary or torque.primary == METHOD:
        return
    primary_spread, paper_spread = spread(primary), spread(torques(points, METHOD))
    ratio = paper_spread / primary_spread if primary_spread > 0 else 0.0
    times = f", about {fixed(ratio, places(ratio))} times less" if ratio > WORTH_SAYING else ""
    yield f"By {torque.primary} the same recordings vary by {fixed(primary_spread, 3)} N·m{times}."


def _against_truth(paper_errors: Sequence[Error]) -> str:
    low, high = (pick(paper_errors, key=lambda error: error.value) for pick in (min, max))
    return (
        f"Against the simulated truth its error is {_error(low)} to {_error(high)}; its stated U "
        f"covers the truth at {covered_points(paper_errors)} set-points."
    )


def _error(error: Error) -> str:
    return f"{with_sign(MILLI * error.value, 0)} mN·m at {plain(error.set_frequency_hz)} Hz"
