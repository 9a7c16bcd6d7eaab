"""The motion: angle, angular velocity and acceleration over the crank phase."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.kinematics import angular_acceleration, angular_velocity, swing_angle
from rigrunner_reports.numbers import fixed
from rigrunner_reports.plots.canvas import BLUE, GREY, INK, VERMILION, Plot, draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rigrunner.api.analysis import SwingPoint
    from rigrunner.api.data import Array

ALPHA = "\N{GREEK SMALL LETTER ALPHA}"
PHASES = 361
SHOWN = 24
"""Of the measured angle, so many marks."""


def motion(point: SwingPoint, eccentric_ratio: float) -> Plot:
    """Return the figure of the motion at a set-point's frequency."""
    phase = np.linspace(0, 2 * np.pi, PHASES)
    frequency = point.frequency_hz.value
    curves = (
        ("Angle", "θ / °", np.degrees(swing_angle(phase, eccentric_ratio))),
        ("Velocity", "ω / (rad/s)", angular_velocity(phase, frequency, eccentric_ratio)),
        (
            "Acceleration",
            f"{ALPHA} / (rad/s²)",
            angular_acceleration(phase, frequency, eccentric_ratio),
        ),
    )

    def paint(figure: Figure) -> None:
        panels = figure.subplots(1, 3)
        for axes, (title, label, values) in zip(panels, curves, strict=True):
            axes.plot(np.degrees(phase), values, color=BLUE, label="from the geometry")
            axes.axhline(0, color=INK, linewidth=0.6)
            for reversal in (np.argmax(curves[0][2]), np.argmin(curves[0][2])):
                axes.axvline(
                    np.degrees(phase[reversal]), color=GREY, linewidth=0.8, linestyle=(0, (1, 2))
                )
            axes.set(title=title, ylabel=label, xlabel="crank phase / °", xlim=(0, 360))
            axes.set_xticks([0, 90, 180, 270, 360])
        panels[0].plot(*_measured(point), "o", color=VERMILION, markersize=3, label="measured")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))

    return Plot(caption=_caption(frequency), alt=_alt(curves), svg=draw(paint, 2.7))


def _measured(point: SwingPoint) -> tuple[Array, Array]:
    step = max(1, len(point.angle_rad) // SHOWN)
    phase = np.linspace(0, 360, len(point.angle_rad), endpoint=False)
    return phase[::step], np.degrees(point.angle_rad)[::step]


def _caption(frequency_hz: float) -> str:
    return (
        f"Motion of the swing at {frequency_hz:.4g} Hz, from the geometry of the oscillating guide "
        "bar, with the measured angle. The dotted uprights are the reversals; the return stroke is "
        "the faster one, so torques of both directions differ by design."
    )


def _alt(curves: tuple[tuple[str, str, Array], ...]) -> str:
    return " ".join(
        f"{label}: from {fixed(values.min(), 3)} to {fixed(values.max(), 3)}."
        for _, label, values in curves
    )
