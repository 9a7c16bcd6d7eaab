"""The distributions that all studies draw their rigs from, for both simulators."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_bearings.study.bench import DAMPING, INERTIA, NATURAL, Range

if TYPE_CHECKING:
    from collections.abc import Mapping

SIMULATORS = ("swing_tester_sim", "swing_tester_ode")
REFERENCE_TOLERANCE = 0.02
"""Relative difference between the stated natural frequency and that of the rig."""

PAUSE_S = (300.0, 1800.0)
"""Between the two runs, while the load is applied and the zero drifts."""

SAMPLES_PER_RESONANCE = 25.0
"""The least that a check requires; slower rates are not drawn."""

STRIBECK = Range("bearing.stribeck_speed", 0.3, 1.0, "rad/s")

_SUPPORT_AND_BEARING: Mapping[str, tuple[Range, ...]] = {
    "swing_tester_sim": (
        Range("support.friction", 0.5, 1.0, "N·m"),
        Range("support.damping", 0.2, 0.4, "N·m·s/rad"),
        Range("support.slip", 0.12, 0.25, "deg"),
        Range("bearing.starting_torque", 0.4, 1.2, "N·m"),
        Range("bearing.kinetic_torque", 0.8, 0.95, "N·m", times="bearing.starting_torque"),
        Range("bearing.slip", 0.07, 0.15, "deg"),
        Range("bearing.weakening_slip", 0.3, 0.6, "deg"),
    ),
    "swing_tester_ode": (
        Range("support.friction", 0.5, 1.0, "N·m"),
        Range("support.viscous", 0.2, 0.4, "N·m·s/rad"),
        Range("support.slip", 0.12, 0.25, "deg"),
        Range("bearing.kinetic_torque", 0.35, 1.1, "N·m"),
        Range("bearing.overshoot", 0.1, 0.4, "N·m", times="bearing.kinetic_torque"),
        Range("bearing.stick_slip", 0.07, 0.15, "deg"),
        Range("bearing.overshoot_slip", 0.3, 0.6, "deg"),
    ),
}


def populations(
    inertia_to: float, natural_hz: tuple[float, float], *further: Range
) -> dict[str, tuple[Range, ...]]:
    """Return the ranges to draw, in order, by simulator; `further` come last.

    `inertia_to` is the greatest inertia in kg·m²; the least is 0.0015.
    """
    return {
        name: (
            Range(INERTIA[name], 0.0015, inertia_to, "kg·m²"),
            Range(NATURAL[name], *natural_hz, "Hz"),
            Range(DAMPING[name], 3.0, 8.0, "%"),
            *_SUPPORT_AND_BEARING[name],
            *further,
        )
        for name in SIMULATORS
    }
