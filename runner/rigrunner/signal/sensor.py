"""What a torque sensor's limits of error contribute to an uncertainty."""

from __future__ import annotations

from math import inf, sqrt
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Component

if TYPE_CHECKING:
    from rigrunner.api.instruments import TorqueInstrument


def rectangular(name: str, half_width_nm: float) -> Component:
    """Return the component of an error within +/-half_width, the same in the whole run.

    Rectangular distribution, u = a/sqrt(3) (GUM 4.3.7).
    """
    return Component(name, abs(half_width_nm) / sqrt(3), inf, "rectangular", common=True)


def undivided(instrument: TorqueInstrument) -> tuple[Component, ...]:
    """Return the component of an accuracy that is stated in one figure; none where it is split."""
    half_width_nm = instrument.accuracy.of_full_scale * instrument.full_scale
    return (rectangular("sensor accuracy", half_width_nm),) if half_width_nm else ()


def reading_components(
    instrument: TorqueInstrument, torque_nm: float, *, zeroed: bool
) -> tuple[Component, ...]:
    """Return the components of one torque reading: gain, non-linearity, drift and offset.

    A zero reading takes the offset out; what drifts after it stays. An accuracy in one figure is
    a component of its own, from which nothing is taken out.
    """
    accuracy = instrument.accuracy
    offset = 0.0 if zeroed else accuracy.offset
    return (
        rectangular("sensor gain", accuracy.gain * torque_nm),
        rectangular("sensor non-linearity", accuracy.nonlinearity * instrument.full_scale),
        rectangular("zero drift", accuracy.drift),
        *((rectangular("sensor offset", offset),) if offset else ()),
        *undivided(instrument),
    )
