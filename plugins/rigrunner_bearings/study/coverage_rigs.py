"""The population of rigs that the study of coverage draws from.

What a budget states a limit for is drawn from that very distribution: the sensor's errors from the
register's limits, the rig's from those in the methods' settings. Everything else is drawn evenly
from the ranges below.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner_bearings.api.rig import torque_instruments
from rigrunner_bearings.study.bench import (
    LOAD_N,
    NATURAL,
    Bench,
    BenchSettings,
    Range,
    Value,
    drawn,
    scaled,
    with_inertia,
)
from rigrunner_bearings.study.populations import (
    PAUSE_S,
    REFERENCE_TOLERANCE,
    SAMPLES_PER_RESONANCE,
    STRIBECK,
    populations,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.random import Generator

    from rigrunner.api import Instrument
    from rigrunner.station import Station

FREQUENCIES_HZ = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0)
NATURAL_HZ = (200.0, 800.0)
CYCLES = (10, 30)
RATES_HZ = (10e3, 20e3)
CORNER_HZ = (800.0, 2000.0)
"""Of the low-pass filter, as the register has it."""

COMMON = (
    Range("eccentric", 1.8, 2.2, "mm"),
    Range("sensors.noise", 0.005, 0.03, "N·m"),
    Range("sensors.spike_probability", 0.0, 0.004, "%"),
    Range("sensors.encoder_resolution", 0.005, 0.02, "deg"),
    Range("sensors.encoder_noise", 0.0, 0.003, "deg"),
)
RANGES = populations(0.0025, NATURAL_HZ, STRIBECK)
LAWS: Mapping[str, Mapping[str, BenchSettings]] = {
    "swing_tester_sim": {
        "slip-weakening": {"bearing.weakening": "slip"},
        "Stribeck": {"bearing.weakening": "speed"},
    },
    "swing_tester_ode": {
        "slip-weakening": {"bearing.weakening": "slip"},
        "Stribeck": {"bearing.weakening": "speed"},
        "Dahl": {"bearing.overshoot": Value(0.0, "N·m")},
    },
}
"""The bearing's law of friction, each as likely as the others."""


@dataclass(frozen=True)
class Limits:
    """What the methods' budgets allow the rig, relative half-widths of even distributions."""

    inertia_mismatch: float
    support_load_dependence: float
    low_pass_tolerance: float
    load_tolerance: float


@dataclass(frozen=True, eq=False)
class Rig:
    """One rig, and the station that describes it."""

    bench: Bench
    station: Station
    law: str
    natural_hz: float

    @property
    def without_sensor_errors(self) -> Bench:
        """The same recordings by a sensor without constant errors."""
        none = {name: Value(0.0, unit) for name, unit in SENSOR_ERRORS.items()}
        return replace(
            self.bench,
            no_load={**self.bench.no_load, **none},
            loaded={**self.bench.loaded, **none},
        )


SENSOR_ERRORS = {
    "sensors.gain": "%",
    "sensors.offset": "N·m",
    "sensors.drift": "N·m",
    "sensors.nonlinearity": "%",
}


def draw(simulator: str, rng: Generator, station: Station, limits: Limits) -> Rig:
    """Return a rig of the population, described by the station as well as a station can."""
    # All draws in this order, also those among the arguments: so a seed names the same rigs.
    instrument = torque_instrument(station)
    law = str(rng.choice(list(LAWS[simulator])))
    values = drawn((*COMMON, *RANGES[simulator]), rng)
    natural_hz = values[NATURAL[simulator]].number
    rates = [rate for rate in RATES_HZ if rate >= SAMPLES_PER_RESONANCE * natural_hz]
    corner = rng.uniform(*CORNER_HZ)
    # The register's limits of error, from which the simulator draws its own.
    limit = instrument.half_width
    no_load = {
        **values,
        **LAWS[simulator][law],
        "sensors.full_scale": Value(instrument.full_scale, "N·m"),
        "sensors.gain": Value(100 * limit("gain"), "%"),
        "sensors.offset": Value(limit("offset"), "N·m"),
        "sensors.drift": Value(limit("drift"), "N·m"),
        "sensors.nonlinearity": Value(100 * limit("nonlinearity") / instrument.full_scale, "%"),
        "sensors.rate": Value(float(rng.choice(rates)), "Hz"),
        "sensors.low_pass": Value(corner * (1 + _within(limits.low_pass_tolerance, rng)), "Hz"),
    }
    bench = Bench(
        simulator=simulator,
        seed=int(rng.integers(2**31)),
        frequencies_hz=FREQUENCIES_HZ,
        cycles=int(rng.integers(CYCLES[0], CYCLES[1] + 1)),
        no_load=no_load,
        loaded=_under_load(simulator, no_load, rng, limits),
        reference_hz=natural_hz * (1 + _within(REFERENCE_TOLERANCE, rng)),
        pause_s=rng.uniform(*PAUSE_S),
        load_n=LOAD_N * (1 + _within(limits.load_tolerance, rng)),
    )
    described = _described(station, values["eccentric"].number, corner)
    return Rig(bench, described, law, natural_hz)


def _within(limit: float, rng: Generator) -> float:
    return float(rng.uniform(-limit, limit))


def _under_load(
    simulator: str, settings: BenchSettings, rng: Generator, limits: Limits
) -> BenchSettings:
    inertia = 1 + _within(limits.inertia_mismatch, rng)
    friction = 1 + _within(limits.support_load_dependence, rng)
    return scaled(with_inertia(simulator, settings, inertia), "support.friction", friction)


def torque_instrument(station: Station) -> Instrument:
    """Return the one torque transducer of the station's register."""
    (instrument,) = torque_instruments(station.instruments).values()
    return instrument


def _described(station: Station, eccentric_mm: float, corner_hz: float) -> Station:
    instrument = torque_instrument(station)
    assert instrument.low_pass is not None  # noqa: S101  (of the shipped station, for the types)
    low_pass = instrument.low_pass.model_copy(update={"corner": corner_hz})
    return station.model_copy(
        update={
            "rig": {**station.rig, "eccentric": f"{eccentric_mm!r} mm"},
            "instruments": (instrument.model_copy(update={"low_pass": low_pass}),),
        }
    )
