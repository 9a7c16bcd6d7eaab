"""The motion: angle, angular velocity and acceleration over the crank phase."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.figures import Axis, Figure, Mark, Picture, Series
from rigrunner_bearings.report.figures.swing import CRANK_PHASE
from rigrunner_bearings.signal.kinematics import angular_acceleration, angular_velocity, swing_angle
from rigrunner_reports.numbers import fixed

if TYPE_CHECKING:
    from rigrunner_bearings.api.points import SwingPoint

ALPHA = "\N{GREEK SMALL LETTER ALPHA}"
PHASES = 361
SHOWN = 24
"""Of the measured angle, so many marks."""


def motion(point: SwingPoint, eccentric_ratio: float) -> Picture:
    """Return the picture of the motion at a set-point's frequency."""
    phase = np.linspace(0, 2 * np.pi, PHASES)
    frequency = point.frequency_hz.value
    curves = (
        ("Angle", Axis("θ", "°"), np.degrees(swing_angle(phase, eccentric_ratio))),
        ("Velocity", Axis("ω", "rad/s"), angular_velocity(phase, frequency, eccentric_ratio)),
        (
            "Acceleration",
            Axis(ALPHA, "rad/s²"),
            angular_acceleration(phase, frequency, eccentric_ratio),
        ),
    )
    angle = curves[0][2]
    reversals = (np.degrees(phase[place]) for place in (np.argmax(angle), np.argmin(angle)))
    marks = (Mark("y", 0.0), *(Mark("x", float(reversal)) for reversal in reversals))
    step = max(1, len(point.angle_rad) // SHOWN)
    at_deg = np.linspace(0, 360, len(point.angle_rad), endpoint=False)[::step]
    shown = Series.over(at_deg, np.degrees(point.angle_rad)[::step], "measured")
    measured = ((shown,), (), ())
    panels = tuple(
        Figure(
            title,
            CRANK_PHASE,
            axis,
            (Series.over(np.degrees(phase), values, "from the geometry", "line"), *marked),
            marks,
        )
        for (title, axis, values), marked in zip(curves, measured, strict=True)
    )
    caption = (
        f"Motion of the swing at {frequency:.4g} Hz, from the geometry of the oscillating guide "
        "bar, with the measured angle. The dotted uprights are the reversals; the return stroke is "
        "the faster one, so torques of both directions differ by design."
    )
    alt = " ".join(
        f"{axis}: from {fixed(values.min(), 3)} to {fixed(values.max(), 3)}."
        for _, axis, values in curves
    )
    return Picture(caption, alt, panels, in_a_row=True)
