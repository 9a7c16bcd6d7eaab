"""The effect on a result of the errors that a register states for a transducer.

Repeatability, hysteresis and resolution act on each reading on its own, and so does a temperature
effect that is not split: how much of them two runs share is not stated. Creep and the
zero's temperature effect change slowly: what of a slow change reaches the result, the method says.
The sensitivity's temperature effect acts as the gain.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

from rigrunner.api.accuracy import OVER_U, Accuracy
from rigrunner.api.uncertainty import Distribution, Effect, Input
from rigrunner.api.units import si_symbol

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.instruments import Instrument


def transducer_effects(
    instrument: Instrument, result: float, readings: Sequence[float], *, slow: float
) -> tuple[Effect, ...]:
    """Return a line of the budget for each error that the register states, with its source.

    `readings` has the largest reading of each run that the result is made of, in SI; `slow` is the
    sensitivity of the result to an offset that changes slowly.
    """
    errors = instrument.accuracy or Accuracy()
    independent = sqrt(sum(reading**2 for reading in readings)), sqrt(len(readings))
    slow_change = slow * max(abs(reading) for reading in readings), slow
    gain = abs(result), sqrt(len(readings))
    terms = (
        ("repeatability", errors.repeatability, independent, 1.0),
        ("hysteresis", errors.hysteresis, independent, 1.0),
        # A reading is off by half a step of the display at most (GUM F.2.2.1).
        ("resolution", errors.resolution, independent, 0.5),
        ("creep", errors.creep, slow_change, 1.0),
        ("temperature effect", errors.temperature, independent, 1.0),
        ("temperature effect on zero", errors.temperature_zero, slow_change, 1.0),
        ("temperature effect on sensitivity", errors.temperature_sensitivity, gain, 1.0),
    )
    effects = []
    for name, error, sensitivities, share in terms:
        if error is None:
            continue
        shape = Distribution(error.distribution)
        parts = error.in_parts(instrument.full_scale)
        limits = zip(parts, ("1", si_symbol(instrument.quantity)), sensitivities, strict=True)
        for half_width, unit, sensitivity in limits:
            if half_width > 0:
                u = share * half_width / OVER_U[shape]
                line = f"transducer {name}" + (f" ({error.source})" if error.source else "")
                input_ = Input(line, 0.0, u, distribution=shape, unit=unit, common=True)
                # The result is the reading less its error.
                effects.append(Effect(input_, -sensitivity))
    return tuple(effects)
