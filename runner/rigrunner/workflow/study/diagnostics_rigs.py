"""The population of healthy rigs that the study of the checks draws from.

Settings that are not named keep the simulator's defaults; constant errors of gain, zero, drift and
linearity follow from the seed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.workflow.study.bench import NATURAL, Bench, Range, Value, drawn

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.random import Generator

FREQUENCIES_HZ = (8.0, 12.0, 18.0, 26.0, 35.0)
CYCLES = 20
PAUSE_S = (300.0, 1800.0)
"""Between the two runs: the load is brought up, and the zero drifts."""

REFERENCE_TOLERANCE = 0.02
"""Of the natural frequency that the station states, against the rig's."""

SLOW_RATE_HZ, FAST_RATE_HZ = 10e3, 20e3
SAMPLES_PER_RESONANCE = 25.0

MEASURING = (
    Range("sensors.noise", 0.01, 0.03, "N·m"),
    Range("sensors.spike_probability", 0.0, 0.004, "%"),
    Range("sensors.encoder_resolution", 0.005, 0.02, "deg"),
)
POPULATIONS: Mapping[str, tuple[Range, ...]] = {
    "swing_tester_sim": (
        Range("drive_line.inertia", 0.0015, 0.0021, "kg·m²"),
        Range("drive_line.natural_frequency", 250.0, 700.0, "Hz"),
        Range("drive_line.damping_ratio", 3.0, 8.0, "%"),
        Range("support.friction", 0.5, 1.0, "N·m"),
        Range("support.damping", 0.2, 0.4, "N·m·s/rad"),
        Range("support.slip", 0.12, 0.25, "deg"),
        Range("bearing.starting_torque", 0.4, 1.2, "N·m"),
        Range("bearing.kinetic_torque", 0.8, 0.95, "N·m", times="bearing.starting_torque"),
        Range("bearing.slip", 0.07, 0.15, "deg"),
        Range("bearing.weakening_slip", 0.3, 0.6, "deg"),
        *MEASURING,
    ),
    "swing_tester_ode": (
        Range("shaft.inertia", 0.0015, 0.0021, "kg·m²"),
        Range("shaft.natural_frequency", 250.0, 700.0, "Hz"),
        Range("shaft.damping_ratio", 3.0, 8.0, "%"),
        Range("support.friction", 0.5, 1.0, "N·m"),
        Range("support.viscous", 0.2, 0.4, "N·m·s/rad"),
        Range("support.slip", 0.12, 0.25, "deg"),
        Range("bearing.kinetic_torque", 0.35, 1.1, "N·m"),
        Range("bearing.overshoot", 0.1, 0.4, "N·m", times="bearing.kinetic_torque"),
        Range("bearing.stick_slip", 0.07, 0.15, "deg"),
        Range("bearing.overshoot_slip", 0.3, 0.6, "deg"),
        *MEASURING,
    ),
}


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
