"""The population of healthy rigs that a study draws from, and what is recorded on one of them.

A rig is a simulator's settings as a station would have them: quantities as texts, drawn from the
ranges below. What is not named keeps the simulator's default; its constant errors of gain, zero,
drift and linearity follow from the seed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.random import Generator

FREQUENCIES_HZ = (8.0, 12.0, 18.0, 26.0, 35.0)
CYCLES = 20
LOAD_N = 1000.0
PAUSE_S = (300.0, 1800.0)
"""Between the two runs: the load is brought up, and the zero drifts."""

REFERENCE_TOLERANCE = 0.02
"""Of the natural frequency that the station states, against the rig's."""

SLOW_RATE_HZ, FAST_RATE_HZ = 10e3, 20e3
SAMPLES_PER_RESONANCE = 25.0


@dataclass(frozen=True)
class Range:
    """One setting by its dotted name, drawn evenly between two values."""

    setting: str
    low: float
    high: float
    unit: str
    times: str = ""
    """The setting whose value it is multiplied by, where that is not empty."""


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
INERTIA = {"swing_tester_sim": "drive_line.inertia", "swing_tester_ode": "shaft.inertia"}
NATURAL = {
    "swing_tester_sim": "drive_line.natural_frequency",
    "swing_tester_ode": "shaft.natural_frequency",
}
DAMPING = {
    "swing_tester_sim": "drive_line.damping_ratio",
    "swing_tester_ode": "shaft.damping_ratio",
}


@dataclass(frozen=True)
class Value:
    """A number with its unit, as it stands in a station."""

    number: float
    unit: str

    def __str__(self) -> str:
        """Return the quantity as YAML has it."""
        return f"{self.number:.9g} {self.unit}"

    def times(self, factor: float) -> Value:
        """Return a multiple of it."""
        return Value(self.number * factor, self.unit)


BenchSettings: TypeAlias = "Mapping[str, Value | str]"
"""Settings of a simulator by their dotted names."""


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Two runs on one rig, as they are done and as they are said to have been done."""

    simulator: str
    seed: int
    no_load: BenchSettings
    """The simulator while the no-load run is done."""
    loaded: BenchSettings
    """The same of the loaded run."""
    reference_hz: float
    """The natural frequency that the station states."""
    pause_s: float
    cycles: int = CYCLES
    no_load_n: float = 0.0
    """The load that is really there in the run that is said to have none."""
    load_n: float = LOAD_N
    """The load that is really there in the run that is said to have 1000 N."""
    zero_shift_nm: float = 0.0
    """By which the zero moves between the two runs."""
    one_sided_nm: float = 0.0
    """A constant torque that comes with the load."""


def healthy(simulator: str, seed: int, rng: Generator) -> Bench:
    """Return a rig of the population with nothing wrong."""
    values = dict(_drawn(simulator, rng))
    natural_hz = values[NATURAL[simulator]].number
    fast = SAMPLES_PER_RESONANCE * natural_hz > SLOW_RATE_HZ
    values["sensors.rate"] = Value(FAST_RATE_HZ if fast else SLOW_RATE_HZ, "Hz")
    return Bench(
        simulator=simulator,
        seed=seed,
        no_load=values,
        loaded=values,
        reference_hz=natural_hz * (1 + rng.uniform(-REFERENCE_TOLERANCE, REFERENCE_TOLERANCE)),
        pause_s=rng.uniform(*PAUSE_S),
    )


def nested(settings: BenchSettings, seed: int) -> dict[str, Any]:
    """Return settings by dotted names as the plugin is told them."""
    tree: dict[str, Any] = {"seed": seed}
    for dotted, value in settings.items():
        *within, name = dotted.split(".")
        branch = tree
        for each in within:
            branch = branch.setdefault(each, {})
        branch[name] = str(value)
    return tree


def _drawn(simulator: str, rng: Generator) -> Iterator[tuple[str, Value]]:
    known: dict[str, float] = {}
    for each in POPULATIONS[simulator]:
        value = rng.uniform(each.low, each.high) * known.get(each.times, 1.0)
        known[each.setting] = value
        yield each.setting, Value(value, each.unit)
