"""Torque over one swing, and over the angle: what the methods do inside a cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.figures import Axis, Figure, Mark, Picture, Series
from rigrunner.signal.averaging import robust_mean
from rigrunner_bearings.report.view.points import low_middle_high, traces
from rigrunner_reports.numbers import fixed, significant

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.report.view.points import SetPoint

TURN_DEG = 360.0
NEARLY_TOP = 0.995
CRANK_PHASE = Axis(
    "crank phase",
    low=0.0,
    high=TURN_DEG,
    ticks=tuple((float(degrees), f"{degrees}°") for degrees in range(0, 361, 90)),
)


@dataclass(frozen=True, eq=False)
class Swing:
    """One swing at one frequency: the angle and named torques, each of shape (N,)."""

    frequency_hz: float
    angle_rad: Array
    torques_nm: tuple[tuple[str, Array], ...]
    """The compensated one last."""

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
                ("raw", trace.raw_nm),
                ("no load", trace.no_load_nm),
                ("compensated", trace.compensated_nm),
            ),
        )
        for frequency, trace in traces(points, method)
    ]


def recorded_swings(points: Sequence[SetPoint]) -> list[Swing]:
    """Return the mean of the kept cycles at low, middle and high frequency, where swings are."""
    return [
        Swing(
            set_point.frequency_hz,
            set_point.swing.angle_rad,
            (
                (
                    "mean of the kept swings",
                    robust_mean(set_point.swing.torque_nm, set_point.swing.kept)[0],
                ),
            ),
        )
        for set_point in low_middle_high([set_point for set_point in points if set_point.swing])
        if set_point.swing
    ]


def over_phase(swings: Sequence[Swing]) -> Picture:
    """Return the picture of torque over the crank phase, one panel per frequency."""
    return Picture(
        caption="Torque over one swing, from the middle of the forward stroke. The dotted uprights "
        "are the reversals, where friction changes its sign; each panel has its own scale.",
        alt=" ".join(
            f"{swing.title}: "
            + ", ".join(
                f"{name} from {fixed(torque.min(), 3)} to {fixed(torque.max(), 3)} N·m"
                for name, torque in swing.torques_nm
            )
            + "."
            for swing in swings
        ),
        panels=tuple(map(_phase_panel, swings)),
        in_a_row=True,
    )


def loops(swings: Sequence[Swing]) -> Picture:
    """Return the picture of torque over the swing angle: first torque left, last one right."""
    first, last = swings[0].torques_nm[0][0], swings[0].torques_nm[-1][0]
    places = (0, -1) if first != last else (0,)
    panels = tuple(_loop_panel(swings, place) for place in places)
    return Picture(_loop_caption(first, last), _loop_alt(swings), panels, in_a_row=True)


def _phase_panel(swing: Swing) -> Figure:
    phase = np.linspace(0, TURN_DEG, len(swing.angle_rad), endpoint=False)
    reversals = (_top_deg(swing.angle_rad), _top_deg(-swing.angle_rad))
    return Figure(
        swing.title,
        CRANK_PHASE,
        Axis("torque", "N·m"),
        tuple(  # the compensated torque first, which so looks as it does elsewhere
            Series.over(phase, torque, name, "line")
            for name, torque in (*swing.torques_nm[-1:], *swing.torques_nm[:-1])
        ),
        (Mark("y", 0.0), *(Mark("x", phase_deg) for phase_deg in reversals)),
    )


def _top_deg(angle_rad: Array) -> float:
    """Return the phase of the largest angle: the middle of the flat top, as encoders have steps."""
    top = np.flatnonzero(angle_rad >= NEARLY_TOP * angle_rad.max())
    return TURN_DEG * float(top.mean()) / len(angle_rad)


def _loop_panel(swings: Sequence[Swing], index: int) -> Figure:
    name = swings[0].torques_nm[index][0]
    series = []
    for swing in swings:
        closed = np.arange(len(swing.angle_rad) + 1) % len(swing.angle_rad)
        angle, torque = np.degrees(swing.angle_rad[closed]), swing.torques_nm[index][1][closed]
        series.append(Series.over(angle, torque, swing.title, "line"))
    return Figure(
        name[0].upper() + name[1:],
        Axis("swing angle", "°"),
        Axis("torque", "N·m"),
        tuple(series),
        (Mark("y", 0.0),),
    )


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


def _loop_alt(swings: Sequence[Swing]) -> str:
    """Return the area of each loop: the work of one swing."""
    return "Work of one swing: " + "; ".join(
        f"{swing.title} "
        + ", ".join(
            f"{name} {significant(_work(swing.angle_rad, torque), 3)} J"
            for name, torque in swing.torques_nm
        )
        for swing in swings
    )


def _work(angle_rad: Array, torque_nm: Array) -> float:
    """Return the closed integral of torque over angle, by the trapezoidal rule."""
    closed = np.arange(len(angle_rad) + 1) % len(angle_rad)
    angle, torque = angle_rad[closed], torque_nm[closed]
    return float(np.sum((torque[1:] + torque[:-1]) / 2 * np.diff(angle)))
