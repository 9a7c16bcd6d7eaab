"""What a viewer of HDF5 files shows first of an analysed run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.torque import TorqueDetails
from rigrunner.runfile import SweepPlot

if TYPE_CHECKING:
    from rigrunner.api.results import Result


def sweep_plot(result: Result) -> SweepPlot | None:
    """Return raw and compensated torque of the primary method; None where there is none."""
    torque = TorqueDetails.of(result)
    primary = torque.compensations.get(torque.primary)
    if primary is None or not primary.points:
        return None
    return SweepPlot(
        frequency_hz=np.array([point.frequency_hz for point in primary.points]),
        raw_nm=np.array([each.peak_nm[each.peak_kept].mean() for each in torque.loaded]),
        compensated_nm=np.array([point.torque.value for point in primary.points]),
        u_nm=np.array([point.torque.u for point in primary.points]),
    )
