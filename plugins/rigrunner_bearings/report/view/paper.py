"""What the published method does on a run, in sentences made of the run's own numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.averaging import robust_mean
from rigrunner.signal.rounding import places
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.report.view.methods import errors, largest_expanded, spread, torques
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
    off = errors(points, METHOD, torque.compensations[METHOD])
    return (
        _range(points),
        *_made_of(torque, points),
        *_beside_primary(torque, points),
        *([_against_truth(off)] if off else []),
    )


def _range(points: Sequence[SetPoint]) -> str:
    found = torques(points, METHOD)
    (low_hz, low), (high_hz, high) = found[0], found[-1]
    return (
        f"On this run it gives {fixed(low.value, 3)} N·m at {plain(low_hz)} Hz and "
        f"{fixed(high.value, 3)} N·m at {plain(high_hz)} Hz; over all set-points it varies by "
        f"{fixed(spread(found), 3)} N·m, where its own stated U is at most "
        f"{fixed(largest_expanded(found), 3)} N·m."
    )


def _made_of(torque: TorqueDetails, points: Sequence[SetPoint]) -> Iterator[str]:
    """Yield what the lowest and the highest value are made of, where a no-load point is there."""
    no_load = {point.set_frequency_hz: point for point in torque.no_load}
    measured = [each for each in points if METHOD in each.by_method]
    for pick in (min, max):
        each = pick(measured, key=lambda point: point.by_method[METHOD].torque.value)
        if each.point.set_frequency_hz in no_load:
            yield _parts(each, no_load[each.point.set_frequency_hz])


def _parts(each: SetPoint, no_load: PeakPoint) -> str:
    """Return the value as difference of the measured peaks plus the misfit of the curve."""
    found = each.by_method[METHOD]
    own = float(no_load.peak_nm[no_load.peak_kept].mean())
    side = "below" if own > found.rig_nm else "above"
    return (
        f"At {plain(each.point.set_frequency_hz)} Hz the measured peaks differ by "
        f"{fixed(found.raw_nm - own, 3)} N·m{_phases(each, no_load)}. The subtracted curve is "
        f"{fixed(abs(own - found.rig_nm), 3)} N·m {side} the measured no-load peak. Together this "
        f"makes {fixed(found.torque.value, 3)} N·m."
    )


def _phases(each: SetPoint, no_load: PeakPoint) -> str:
    if each.swing is None or not isinstance(no_load, SwingPoint):
        return ""
    means = [robust_mean(point.torque_nm, point.kept)[0] for point in (each.swing, no_load)]
    loaded_deg, no_load_deg = (TURN_DEG * float(np.argmax(mean)) / len(mean) for mean in means)
    return (
        f"; in the mean swings they stand at {loaded_deg:.0f}° (loaded) and {no_load_deg:.0f}° "
        "(no load) of the crank"
    )


def _beside_primary(torque: TorqueDetails, points: Sequence[SetPoint]) -> Iterator[str]:
    primary = torques(points, torque.primary)
    if not primary or torque.primary == METHOD:
        return
    own, paper = spread(primary), spread(torques(points, METHOD))
    ratio = paper / own if own > 0 else 0.0
    times = f", about {fixed(ratio, places(ratio))} times less" if ratio > WORTH_SAYING else ""
    yield f"By {torque.primary} the same recordings vary by {fixed(own, 3)} N·m{times}."


def _against_truth(found: Sequence[Error]) -> str:
    low, high = (pick(found, key=lambda each: each.value) for pick in (min, max))
    return (
        f"Against the simulated truth its error is {_error(low)} to {_error(high)}; its stated U "
        f"covers the truth at {sum(each.covered for each in found)} of {len(found)} set-points."
    )


def _error(each: Error) -> str:
    return f"{with_sign(MILLI * each.value, 0)} mN·m at {plain(each.set_frequency_hz)} Hz"
