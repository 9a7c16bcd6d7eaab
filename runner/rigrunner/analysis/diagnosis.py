"""Every check of an analysis, in the order in which a report has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.analysis.checks import friction_check, positive_check, run_checks, zero_drift_check
from rigrunner.analysis.consistency import agreement
from rigrunner.analysis.one_setup import setup_check, unloaded_check

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.analysis import Check, Compensation, PeakPoint
    from rigrunner.api.data import RunData


@dataclass(frozen=True)
class Diagnosed:
    """A run and its no-load run, with what was prepared of both."""

    run: RunData
    no_load_run: RunData | None
    loaded: tuple[PeakPoint, ...]
    no_load: tuple[PeakPoint, ...]


def diagnose(
    found: Diagnosed, primary: Compensation | None, *, own_no_load: bool
) -> Iterator[Check]:
    """Yield the checks of both runs and of the primary method; none where nothing was prepared.

    `own_no_load` says that the no-load points are recordings of the run itself.
    """
    loaded, no_load = found.loaded, found.no_load
    if not loaded:
        return
    yield from run_checks(found.run, (*loaded, *no_load) if own_no_load else loaded)
    if found.no_load_run is not None:
        yield from run_checks(found.no_load_run, no_load, "no-load run: ")
        yield zero_drift_check(found.run, found.no_load_run)
        yield setup_check(found.run, found.no_load_run)
    if no_load:
        yield unloaded_check(loaded, no_load, primary.points if primary else ())
    if primary is None or not primary.points:
        return
    yield agreement(primary.points)
    # no mapping: a sweep may come back to a frequency, and each of its points counts
    torques = [(point.set_frequency_hz, point.torque.value) for point in primary.points]
    yield positive_check(torques)
    radius = found.run.rig.swing_radius
    if radius is not None:
        yield friction_check(torques, loaded[0].load_n, radius)
