"""What a torque sensor's limits of error contribute to an uncertainty (GUM 4.3.7).

The gain's error is relative, of the true torque: indicated = (1 + gain) true + the other errors. A
limit that is a share of the reading counts as at full scale.
"""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from typing import TYPE_CHECKING

from rigrunner.api import Distribution, Effect, Input
from rigrunner.api.accuracy import OVER_U

if TYPE_CHECKING:
    from rigrunner.api import Instrument


NONLINEAR_SLOPE = 4.0
"""Greatest slope of a parabolic error curve, in its greatest value over full scale."""


def gain(instrument: Instrument) -> Input:
    """Return the relative error of the sensor's gain."""
    return stated(instrument, "gain", "sensor gain", "1")


def stated(instrument: Instrument, error: str, name: str, unit: str = "N·m") -> Input:
    """Return the input of one error that the register states, the same in the whole run."""
    accuracy = instrument.accuracy
    limit = accuracy.limits.get(error) if accuracy else None
    shape = Distribution(limit.distribution if limit else "rectangular")
    u = instrument.half_width(error) / OVER_U[shape]
    return Input(name, 0.0, u, distribution=shape, unit=unit, common=True)


def curve_slope(instrument: Instrument, torque_nm: float) -> Effect:
    """Return the effect of a smooth error curve on the difference of two torques.

    Only its slope between them is left, of a parabola at most `NONLINEAR_SLOPE`.
    """
    error = stated(instrument, "nonlinearity", "sensor non-linearity", "1")
    of_full_scale = replace(error, u=error.u / instrument.full_scale)
    return Effect(of_full_scale, -NONLINEAR_SLOPE * torque_nm)


def one_figure(instrument: Instrument) -> tuple[Effect, ...]:
    """Return the error of a sensor whose accuracy is stated in one figure; empty for others.

    It is unknown what two runs have in common of it, so all of it counts in a difference.
    """
    if instrument.half_width("overall") == 0:
        return ()
    return (Effect(stated(instrument, "overall", "sensor accuracy"), -1.0),)


def reading_effects(instrument: Instrument, *, zeroed: bool) -> tuple[Effect, ...]:
    """Return the errors of one torque reading except the gain: curve, drift and offset.

    A zero reading removes the offset, but not the drift after it.
    """
    return (
        Effect(stated(instrument, "nonlinearity", "sensor non-linearity"), -1.0),
        Effect(stated(instrument, "drift", "zero drift"), -1.0),
        Effect(stated(instrument, "offset", "sensor offset"), 0.0 if zeroed else -1.0),
        *one_figure(instrument),
    )


def difference_effects(instrument: Instrument, runs: int) -> tuple[Effect, ...]:
    """Return the errors of the difference of two runs' peaks except the gain.

    The offset is the same in both and cancels, also without a zero reading; each run has
    drifted since its own zero reading. With one run the other torque is not read by this sensor.
    """
    drift = stated(instrument, "drift", "zero drift")
    return (
        Effect(stated(instrument, "nonlinearity", "sensor non-linearity"), -1.0),
        Effect(replace(drift, u=drift.u * sqrt(runs)), -1.0),
        Effect(stated(instrument, "offset", "sensor offset"), 0.0),
        *one_figure(instrument),
    )
