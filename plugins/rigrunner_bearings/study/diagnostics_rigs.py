"""The population of healthy rigs that the study of the checks draws from.

Settings that are not named keep the simulator's defaults; constant errors of gain, zero, drift and
linearity follow from the seed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_bearings.study.bench import NATURAL, Bench, Range, Value, drawn
from rigrunner_bearings.study.populations import (
    PAUSE_S,
    REFERENCE_TOLERANCE,
    SAMPLES_PER_RESONANCE,
    populations,
)

if TYPE_CHECKING:
    from numpy.random import Generator

FREQUENCIES_HZ = (8.0, 12.0, 18.0, 26.0, 35.0)
CYCLES = 20
SLOW_RATE_HZ, FAST_RATE_HZ = 10e3, 20e3

MEASURING = (
    Range("sensors.noise", 0.01, 0.03, "N·m"),
    Range("sensors.spike_probability", 0.0, 0.004, "%"),
    Range("sensors.encoder_resolution", 0.005, 0.02, "deg"),
)
POPULATIONS = populations(0.0021, (250.0, 700.0), *MEASURING)


def healthy(simulator: str, seed: int, rng: Generator) -> Bench:
    """Return a rig of the population with nothing wrong."""
    values = drawn(POPULATIONS[simulator], rng)
    natural_hz = values[NATURAL[simulator]].number
    fast = SAMPLES_PER_RESONANCE * natural_hz > SLOW_RATE_HZ
    values["sensors.rate"] = Value(FAST_RATE_HZ if fast else SLOW_RATE_HZ, "Hz")
    return Bench(
        simulator=simulator,
        frequencies_hz=FREQUENCIES_HZ,
        cycles=CYCLES,
        seed=seed,
        no_load=values,
        loaded=values,
        reference_hz=natural_hz * (1 + rng.uniform(-REFERENCE_TOLERANCE, REFERENCE_TOLERANCE)),
        pause_s=rng.uniform(*PAUSE_S),
    )
