"""Channels of torque and load that exceeded their calibrated range."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.api.rig import torque_instruments
from rigrunner_bearings.torque.channels import role_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Instrument, RunData
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.torque import TorqueDetails


class BeyondRange(NamedTuple):
    """A channel that exceeded its calibrated range, with how far, in words."""

    run_id: str
    channel: str
    text: str


def beyond_calibration(
    details: TorqueDetails, run: RunData, no_load_run: RunData | None
) -> Iterator[BeyondRange]:
    """Yield each channel that exceeded its calibrated range."""
    for source_run, points in ((run, details.loaded), (no_load_run, details.no_load)):
        if source_run is None or not (points or details.primary):
            continue
        ranges = [
            (instrument, *_extremes(points), "N·m")
            for instrument in torque_instruments(source_run.instruments.values()).values()
        ]
        cell = load_cell(source_run)
        loads = [point.load_n for point in points if point.load_n > 0]
        if cell is not None and loads:
            ranges.append((cell, min(loads), max(loads), "N"))
        for instrument, lowest, highest, unit in ranges:
            if text := instrument.beyond_range(lowest, highest, unit):
                yield BeyondRange(source_run.run_id, instrument.channel, text)


def load_cell(run: RunData) -> Instrument | None:
    """Return the instrument of the load in the register; None where there is none."""
    torque = next(iter(torque_instruments(run.instruments.values())), None)
    return None if torque is None else run.instruments.get(f"{role_of(torque)}.load")


def _extremes(points: Sequence[PeakPoint]) -> tuple[float, float]:
    """Return the least and the greatest torque of what was kept, in N·m; 0 is always within."""
    values = [0.0]
    for point in points:
        values.append(float(point.peak_nm[point.peak_kept].max(initial=0.0)))
        if isinstance(point, SwingPoint):
            kept = point.torque_nm[point.kept]
            values.extend((float(kept.min(initial=0.0)), float(kept.max(initial=0.0))))
    return min(values), max(values)
