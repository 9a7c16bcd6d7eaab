#!/usr/bin/env python3
"""Draws what the paper's figures 5, 6, 7 and 9 are about, from two runs on the simulated rig.

    rigrunner demo --dir RUNS
    python docs/images/paper_figures.py RUNS docs/images

RUNS is the folder of the demonstration; the loaded run in it embeds its no-load run. The paper is
Wang et al., Machines 2025, 13(11), 976; its printed numbers are drawn beside ours, its figures are
not copied.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.registry import load_registry
from rigrunner.runfile import read_truth
from rigrunner.signal.kinematics import angular_acceleration, angular_velocity
from rigrunner.signal.peaks import peak_points
from rigrunner.workflow.locate import run_names
from rigrunner.workflow.stored import analyse_run
from rigrunner_reports.plots.canvas import GREY, INK, NO_LOAD, OTHERS, PRIMARY, RAW, draw

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.api.analysis import CompensatedPoint
    from rigrunner.api.results import Result

TABLE_1 = ((1, 10, 20), (0.88, 2.16, 4.31))
TABLE_2 = ((1, 5, 10, 15, 20, 25, 30, 35), (0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91))
EQUATION_1 = (0.0041, 0.0247, 0.9173)
CLAIMED = ((10, 35), (0.7288, 0.7233))
PEAK_VELOCITY, PEAK_ACCELERATION = 9.3578, 2170.5367
BEARING_NM, SENSOR_NM = 0.7262, 5.7268
TOP_HZ = 35.0
PAPER = {"color": INK, "linestyle": "", "marker": "x", "markersize": 6}


def kinematics(ratio: float) -> bytes:
    """Return the spindle's velocity and acceleration over one turn of the crank at 35 Hz."""
    phase = np.linspace(0, 2 * np.pi, 721)
    curves = (
        ("ω / (rad/s)", angular_velocity(phase, TOP_HZ, ratio), PEAK_VELOCITY),
        ("α / (rad/s²)", angular_acceleration(phase, TOP_HZ, ratio), PEAK_ACCELERATION),  # noqa: RUF001  (alpha)
    )

    def paint(figure: Figure) -> None:
        for axes, (label, values, printed) in zip(figure.subplots(1, 2), curves, strict=True):
            axes.plot(np.degrees(phase), values, color=PRIMARY.color)
            name = f"printed maximum {printed:g}"
            axes.axhline(printed, color=INK, linewidth=0.9, linestyle=(0, (6, 3)), label=name)
            axes.set(ylabel=label, xlabel="crank phase / °", xlim=(0, 360))
            axes.set_xticks([0, 90, 180, 270, 360])
            axes.margins(y=0.15)
            axes.legend(loc="upper right")

    return draw(paint, 2.6)


def torque_over_a_swing(point: CompensatedPoint) -> bytes:
    """Return raw, no-load and compensated torque over one swing."""
    trace = point.trace
    if trace is None:
        raise SystemExit("the primary method gives no torque over the swing")
    phase = np.linspace(0, 360, len(trace.angle_rad), endpoint=False)
    series = (
        ("at the sensor, 1000 N", trace.raw_nm, RAW),
        ("at the sensor, no load", trace.no_load_nm, NO_LOAD),
        ("bearing (compensated)", trace.compensated_nm, PRIMARY),
    )

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for name, torque, line in series:
            axes.plot(phase, torque, color=line.color, linestyle=line.linestyle, label=name)
        for printed, name in ((SENSOR_NM, "sensor"), (BEARING_NM, "bearing")):
            label = f"printed maximum, {name}: {printed:g} N·m"
            axes.axhline(printed, color=GREY, linewidth=0.9, linestyle=(0, (6, 3)))
            axes.annotate(label, (180, printed), ha="center", va="bottom", fontsize=7.5)
        axes.set(ylabel="torque / N·m", xlabel="crank phase / °", xlim=(0, 360))
        axes.set_xticks([0, 90, 180, 270, 360])
        axes.legend(loc="lower right")

    return draw(paint, 3.0)


def no_load_over_frequency(result: Result) -> bytes:
    """Return the no-load peaks of the simulated rig, Table 2, Eq. (1), and what both leave over."""
    points = peak_points(result.no_load)
    fit = next(each for each in result.fits if each.name == "polynomial")
    curve = fit.curve
    if curve is None:
        raise SystemExit(f"the quadratic could not be fitted: {fit.problem}")
    x = np.linspace(*curve.valid_x, 120)
    value, _ = curve.predict(x)

    def paint(figure: Figure) -> None:
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1.2))
        style = {"color": PRIMARY.color, "linestyle": "", "marker": "o"}
        upper.plot(points.x, points.y, label="simulated rig", **style)
        upper.plot(x, value, color=PRIMARY.color, label="quadratic fitted to it")
        upper.plot(*TABLE_2, label="the paper's Table 2", **PAPER)
        upper.plot(x, np.polyval(EQUATION_1, x), color=INK, linestyle="--", label="its Eq. (1)")
        lower.plot(points.x, 1e3 * curve.residuals, **style)
        lower.plot(TABLE_2[0], 1e3 * (TABLE_2[1] - np.polyval(EQUATION_1, TABLE_2[0])), **PAPER)
        lower.axhline(0, color=INK, linewidth=0.6)
        upper.set(ylabel="no-load peak / N·m")
        lower.set(ylabel="left over / mN·m", xlabel="frequency / Hz", xlim=(0, 36))
        upper.legend(loc="upper left")

    return draw(paint, 3.8)


def loaded_over_frequency(result: Result, truth_nm: float) -> bytes:
    """Return raw peaks and what each method leaves of them, with the paper's numbers."""

    def paint(figure: Figure) -> None:
        left, right = figure.subplots(1, 2)
        points = peak_points(result.loaded)
        style = {"color": RAW.color, "linestyle": RAW.linestyle, "marker": RAW.marker}
        left.plot(points.x, points.y, label="raw peaks, simulated rig", **style)
        left.plot(*TABLE_1, label="the paper's Table 1", **PAPER)
        left.set(title="Uncompensated", ylim=(0, None))
        _method(right, result, "template_inverse", PRIMARY.color, "-")
        _method(right, result, "paper_peak", OTHERS[0].color, "--")
        right.axhline(truth_nm, color=INK, linewidth=0.9, label="simulated truth", zorder=5)
        difference = TABLE_1[1] - np.polyval(EQUATION_1, TABLE_1[0])
        right.plot(TABLE_1[0], difference, label="Eq. (2) on Table 1", **PAPER)
        right.plot(*CLAIMED, label="claimed by the paper", **(PAPER | {"marker": "+"}))
        right.set(title="Compensated", ylim=(None, 2.1))
        for axes in (left, right):
            axes.set(ylabel="torque / N·m", xlabel="frequency / Hz", xlim=(0, 36))
        left.legend(loc="upper left")
        right.legend(loc="upper left")

    return draw(paint, 3.4)


def _method(axes: Axes, result: Result, name: str, color: str, linestyle: str) -> None:
    found = result.compensations[name].points
    frequency = [each.frequency_hz for each in found]
    torque = [each.torque.value for each in found]
    axes.plot(frequency, torque, color=color, linestyle=linestyle, marker="o", label=name)


def figures(runs: Path) -> dict[str, bytes]:
    """Return the figures of the latest loaded run in the folder, by file name."""
    names = [name for name in run_names(runs) if "_SSPB-STT-1000" in name]
    if not names:
        raise SystemExit(
            f"there is no run of SSPB-STT-1000 in {runs}; do: rigrunner demo --dir {runs}"
        )
    run = runs / names[-1]
    result = analyse_run(run, load_registry())
    truths = [each["starting_torque_nm"] for each in read_truth(run).values()]
    points = result.compensations[result.primary].points
    top = max(points, key=lambda each: each.frequency_hz)
    return {
        "paper-kinematics.svg": kinematics(result.run.rig.eccentric_ratio),
        "paper-torque-35hz.svg": torque_over_a_swing(top),
        "paper-no-load.svg": no_load_over_frequency(result),
        "paper-compensated.svg": loaded_over_frequency(result, float(np.mean(truths))),
    }


def main(runs: str, out: str) -> None:
    """Write the figures of a demonstration into a folder."""
    for name, svg in figures(Path(runs)).items():
        (Path(out) / name).write_bytes(svg)


if __name__ == "__main__":
    main(*sys.argv[1:])
