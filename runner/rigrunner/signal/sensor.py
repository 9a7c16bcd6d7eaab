"""What a torque sensor's limits of error contribute to an uncertainty (GUM 4.3.7).

The gain's error is relative, of the true torque: indicated = (1 + gain) true + the other errors.
"""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from typing import TYPE_CHECKING

from rigrunner.api.uncertainty import Effect
from rigrunner.signal.inputs import limited

if TYPE_CHECKING:
    from rigrunner.api.instruments import TorqueInstrument
    from rigrunner.api.uncertainty import Input


NONLINEAR_SLOPE = 4.0
"""Greatest slope of a parabolic error curve, in its greatest value over full scale."""


def gain(instrument: TorqueInstrument) -> Input:
    """Return the relative error of the sensor's gain."""
    return limited("sensor gain", instrument.accuracy.gain, "1")


def one_figure(instrument: TorqueInstrument) -> tuple[Effect, ...]:
    """Return the whole error of a sensor of which one figure of full scale is known, if it is.

    Nothing says what of it two runs have in common, so a difference may be off by all of it.
    """
    share = instrument.accuracy.of_full_scale
    if share == 0:
        return ()
    return (Effect(limited("sensor accuracy", share * instrument.full_scale), -1.0),)


def reading_effects(instrument: TorqueInstrument, *, zeroed: bool) -> tuple[Effect, ...]:
    """Return what one torque reading may be off by, besides the gain: curve, drift and offset.

    A zero reading takes the offset out; what drifts after it stays.
    """
    accuracy = instrument.accuracy
    offset = limited("sensor offset", accuracy.offset)
    return (
        Effect(_nonlinearity(instrument), -1.0),
        Effect(limited("zero drift", accuracy.drift), -1.0),
        Effect(offset, 0.0 if zeroed else -1.0),
        *one_figure(instrument),
    )


def difference_effects(instrument: TorqueInstrument, runs: int) -> tuple[Effect, ...]:
    """Return what the difference of two runs' peaks may be off by, besides the gain.

    The offset is the same in both and falls out, also where no zero was taken; each run has
    drifted on its own since its zero reading. With one run the other side is no reading of ours.
    """
    accuracy = instrument.accuracy
    drift = limited("zero drift", accuracy.drift)
    return (
        Effect(_nonlinearity(instrument), -1.0),
        Effect(replace(drift, u=drift.u * sqrt(runs)), -1.0),
        Effect(limited("sensor offset", accuracy.offset), 0.0),
        *one_figure(instrument),
    )


def _nonlinearity(instrument: TorqueInstrument) -> Input:
    return limited("sensor non-linearity", instrument.accuracy.nonlinearity * instrument.full_scale)
