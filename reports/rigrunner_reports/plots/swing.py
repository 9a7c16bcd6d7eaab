"""Torque over one swing, and over the angle: what the methods do inside a cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.averaging import robust_mean
from rigrunner_reports.numbers import fixed, significant
from rigrunner_reports.plots.canvas import (
    GREY,
    INK,
    LOW_MIDDLE_HIGH,
    NO_LOAD,
    PRIMARY,
    RAW,
    Plot,
    draw,
)
from rigrunner_reports.view.points import low_middle_high, traces

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.api.data import Array
    from rigrunner_reports.plots.canvas import Line
    from rigrunner_reports.view.points import SetPoint

TURN_DEG = 360.0
NEARLY_TOP = 0.995


@dataclass(frozen=True, eq=False)
class Swing:
    """One swing at one frequency: the angle and named torques, each of shape (N,)."""

    frequency_hz: float
    angle_rad: Array
    torques_nm: tuple[tuple[str, Line, Array], ...]

    @property
    def title(self) -> str:
        """The frequency, as the panel's title."""
        return f"{self.frequency_hz:.4g} Hz"


def compensated_swings(points: Sequence[SetPoint], method: str) -> list[Swing]:
    """Return raw, no-load and compensated torque at low, middle and high frequency."""
    return [
        Swing(
            frequency,
            trace.angle_rad,
            (
                ("raw", RAW, trace.raw_nm),
                ("no load", NO_LOAD, trace.no_load_nm),
                ("compensated", PRIMARY, trace.compensated_nm),
            ),
        )
        for frequency, trace in traces(points, method)
    ]


def recorded_swings(points: Sequence[SetPoint]) -> list[Swing]:
    """Return the mean of the kept cycles at low, middle and high frequency, where swings are."""
    return [
        Swing(
            each.frequency_hz,
            each.swing.angle_rad,
            (
                (
                    "mean of the kept swings",
                    PRIMARY,
                    robust_mean(each.swing.torque_nm, each.swing.kept)[0],
                ),
            ),
        )
        for each in low_middle_high([each for each in points if each.swing])
        if each.swing
    ]


def over_phase(swings: Sequence[Swing]) -> Plot:
    """Return the figure of torque over the crank phase, one panel per frequency."""

    def paint(figure: Figure) -> None:
        panels = figure.subplots(1, len(swings), squeeze=False)[0]
        for axes, swing in zip(panels, swings, strict=True):
            _phase_panel(axes, swing)
        panels[0].set_ylabel("torque / N·m")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))

    return Plot(
        caption="Torque over one swing, from the middle of the forward stroke. The dotted uprights "
        "are the reversals, where friction changes its sign; each panel has its own scale.",
        alt=_extremes(swings),
        svg=draw(paint, 2.9),
    )


def loops(swings: Sequence[Swing]) -> Plot:
    """Return the figure of torque over the swing angle: first torque left, last one right."""
    first, last = swings[0].torques_nm[0][0], swings[0].torques_nm[-1][0]

    def paint(figure: Figure) -> None:
        panels = figure.subplots(1, 2) if first != last else [figure.subplots()]
        for axes, index in zip(panels, (0, -1), strict=False):
            _loop_panel(axes, swings, index)
        panels[0].set_ylabel("torque / N·m")

    return Plot(caption=_loop_caption(first, last), alt=_loop_alt(swings), svg=draw(paint, 3.2))


def _phase_panel(axes: Axes, swing: Swing) -> None:
    phase = np.linspace(0, TURN_DEG, len(swing.angle_rad), endpoint=False)
    for name, line, torque in swing.torques_nm:
        axes.plot(phase, torque, label=name, color=line.color, linestyle=line.linestyle)
    for angle in (swing.angle_rad, -swing.angle_rad):
        axes.axvline(_top_deg(angle), color=GREY, linewidth=0.8, linestyle=(0, (1, 2)))
    axes.axhline(0, color=INK, linewidth=0.6)
    axes.set(title=swing.title, xlabel="crank phase / °", xlim=(0, TURN_DEG))
    axes.set_xticks([0, 90, 180, 270, 360])


def _top_deg(angle_rad: Array) -> float:
    """Return the phase of the largest angle: the middle of the flat top, as encoders have steps."""
    top = np.flatnonzero(angle_rad >= NEARLY_TOP * angle_rad.max())
    return TURN_DEG * float(top.mean()) / len(angle_rad)


def _loop_panel(axes: Axes, swings: Sequence[Swing], index: int) -> None:
    for depth, (swing, line) in enumerate(
        zip(swings, LOW_MIDDLE_HIGH[-len(swings) :], strict=True)
    ):
        closed = np.arange(len(swing.angle_rad) + 1) % len(swing.angle_rad)
        axes.plot(
            np.degrees(swing.angle_rad[closed]),
            swing.torques_nm[index][2][closed],
            label=swing.title,
            color=line.color,
            linestyle=line.linestyle,
            zorder=3 - depth / 10,
        )
    axes.axhline(0, color=INK, linewidth=0.6)
    name = swings[0].torques_nm[index][0]
    axes.set(title=name[0].upper() + name[1:], xlabel="swing angle / °")
    axes.margins(y=0.12)
    axes.legend(loc="upper center", ncols=len(swings), bbox_to_anchor=(0.5, 1.0))
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.12 * (high - low))


def _loop_caption(first: str, last: str) -> str:
    if first == last:
        return (
            "Torque over the swing angle: tilted by the inertia, opened by friction. The loop's "
            "area is the work of a swing."
        )
    return (
        "Friction loop: torque over the swing angle. Measured, the loops are tilted by the inertia "
        "and differ with frequency; compensated, they should lie on each other. The loop's area is "
        "the work of a swing. The two panels have different scales."
    )


def _extremes(swings: Sequence[Swing]) -> str:
    return " ".join(
        f"{swing.title}: "
        + ", ".join(
            f"{name} from {fixed(torque.min(), 3)} to {fixed(torque.max(), 3)} N·m"
            for name, _, torque in swing.torques_nm
        )
        + "."
        for swing in swings
    )


def _loop_alt(swings: Sequence[Swing]) -> str:
    """Return the area of each loop: the work of one swing."""
    return "Work of one swing: " + "; ".join(
        f"{swing.title} "
        + ", ".join(
            f"{name} {significant(_work(swing.angle_rad, torque), 3)} J"
            for name, _, torque in swing.torques_nm
        )
        for swing in swings
    )


def _work(angle_rad: Array, torque_nm: Array) -> float:
    """Return the closed integral of torque over angle, by the trapezoidal rule."""
    closed = np.arange(len(angle_rad) + 1) % len(angle_rad)
    angle, torque = angle_rad[closed], torque_nm[closed]
    return float(np.sum((torque[1:] + torque[:-1]) / 2 * np.diff(angle)))
