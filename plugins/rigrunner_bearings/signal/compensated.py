"""The point of a compensation, from its measurement model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.signal.propagation import propagate
from rigrunner_bearings.api.compensations import CompensatedPoint

if TYPE_CHECKING:
    from rigrunner.api import MeasurementModel
    from rigrunner_bearings.api.compensations import Trace


def compensated_point(
    model: MeasurementModel,
    *,
    set_frequency_hz: float,
    frequency_hz: float,
    raw_nm: float,
    trace: Trace | None = None,
    cycles_used: int | None = None,
) -> CompensatedPoint:
    """Return the point with this model, from which its torque and budget follow."""
    propagated = propagate(model)
    return CompensatedPoint(
        set_frequency_hz=set_frequency_hz,
        frequency_hz=frequency_hz,
        raw_nm=raw_nm,
        rig_nm=raw_nm - propagated.estimate.value,
        torque=propagated.estimate,
        components=propagated.components,
        trace=trace,
        model=model,
        cycles_used=cycles_used,
    )
