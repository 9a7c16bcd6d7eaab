"""Two runs on one simulated rig, with settings drawn by a study.

A rig is given by the settings of its simulator: quantities with units, by dotted names, as in a
station. Other settings keep the simulator's default.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.random import Generator

LOAD_N = 1000.0
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
class Range:
    """One setting by its dotted name, drawn from a uniform distribution."""

    setting: str
    low: float
    high: float
    unit: str
    times: str = ""
    """The setting by whose value the drawn number is multiplied; '' for none."""


@dataclass(frozen=True)
class Value:
    """A number with its unit, as in a station."""

    number: float
    unit: str

    def __str__(self) -> str:
        """Return the quantity as written in YAML."""
        return f"{self.number:.9g} {self.unit}"

    def times(self, factor: float) -> Value:
        """Return the value times a factor."""
        return Value(self.number * factor, self.unit)


BenchSettings: TypeAlias = "Mapping[str, Value | str]"
"""Settings of a simulator by their dotted names."""


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Two runs on one rig: its true properties, and what station and procedure state."""

    simulator: str
    seed: int
    frequencies_hz: tuple[float, ...]
    cycles: int
    no_load: BenchSettings
    """The simulator during the no-load run."""
    loaded: BenchSettings
    """The simulator during the loaded run."""
    reference_hz: float
    """The natural frequency that the station states."""
    pause_s: float
    no_load_n: float = 0.0
    """The true load of the no-load run."""
    load_n: float = LOAD_N
    """The true load of the run for which 1000 N is stated."""
    zero_shift_nm: float = 0.0
    """The zero drift of the torque sensor between the two runs."""
    one_sided_nm: float = 0.0
    """A constant torque that acts only under load."""
    spring_nm: float = 0.0
    """A torque under load that is proportional to the angle; its value at the end of a swing."""


def drawn(ranges: Iterable[Range], rng: Generator) -> dict[str, Value]:
    """Return a value drawn from each range, by setting."""
    values: dict[str, Value] = {}
    for range_ in ranges:
        unit_value = rng.uniform(range_.low, range_.high)
        times = values[range_.times].number if range_.times else 1.0
        values[range_.setting] = Value(unit_value * times, range_.unit)
    return values


def scaled(settings: BenchSettings, name: str, factor: float) -> BenchSettings:
    """Return the settings with one of them multiplied."""
    value = settings[name]
    if isinstance(value, str):
        raise TypeError(f"{name} is not a quantity")
    return {**settings, name: value.times(factor)}


def with_inertia(simulator: str, settings: BenchSettings, factor: float) -> BenchSettings:
    """Return the settings with another inertia; spring and damper stay.

    Resonance and damping ratio then go with 1/sqrt(J).
    """
    settings = scaled(settings, INERTIA[simulator], factor)
    settings = scaled(settings, NATURAL[simulator], factor**-0.5)
    return scaled(settings, DAMPING[simulator], factor**-0.5)


def nested(settings: BenchSettings, seed: int) -> dict[str, Any]:
    """Return the settings as the nested mapping that the plugin reads."""
    tree: dict[str, Any] = {"seed": seed}
    for dotted, value in settings.items():
        *within, name = dotted.split(".")
        branch = tree
        for key in within:
            branch = branch.setdefault(key, {})
        branch[name] = str(value)
    return tree
