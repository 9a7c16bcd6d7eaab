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

from rigrunner.api.figures import Axis, Figure, Mark, Picture, Series
from rigrunner.plots import draw
from rigrunner.registry import load_registry
from rigrunner.run.locate import run_names
from rigrunner.run.stored import analyse_run
from rigrunner.runfile import read_truth
from rigrunner_bearings.api.rig import rig_of
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.signal.kinematics import angular_acceleration, angular_velocity
from rigrunner_bearings.signal.peaks import peak_points

if TYPE_CHECKING:
    from rigrunner.api.results import Result
    from rigrunner_bearings.api.compensations import CompensatedPoint

TABLE_1 = ((1, 10, 20), (0.88, 2.16, 4.31))
TABLE_2 = ((1, 5, 10, 15, 20, 25, 30, 35), (0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91))
EQUATION_1 = (0.0041, 0.0247, 0.9173)
CLAIMED = ((10, 35), (0.7288, 0.7233))
PEAK_VELOCITY, PEAK_ACCELERATION = 9.3578, 2170.5367
BEARING_NM, SENSOR_NM = 0.7262, 5.7268
TOP_HZ = 35.0
TURN = tuple((x, f"{x}") for x in range(0, 361, 90))
PHASE = Axis("crank phase", "°", low=0, high=360, ticks=TURN)
FREQUENCY = Axis("frequency", "Hz", low=0, high=36)
TORQUE = Axis("torque", "N·m")


def kinematics(ratio: float) -> bytes:
    """Return the spindle's velocity and acceleration over one turn of the crank at 35 Hz."""
    phase = np.linspace(0, 2 * np.pi, 721)
    curves = (
        (Axis("ω", "rad/s"), angular_velocity(phase, TOP_HZ, ratio), PEAK_VELOCITY),
        (Axis("α", "rad/s²"), angular_acceleration(phase, TOP_HZ, ratio), PEAK_ACCELERATION),  # noqa: RUF001  (alpha)
    )
    panels = tuple(
        Figure(
            f"printed maximum {printed:g}",
            PHASE,
            axis,
            (Series.over(np.degrees(phase), values, kind="line"),),
            (Mark("y", printed),),
        )
        for axis, values, printed in curves
    )
    return draw(Picture("", "", panels, in_a_row=True)).svg


def torque_over_a_swing(point: CompensatedPoint) -> bytes:
    """Return raw, no-load and compensated torque over one swing."""
    trace = point.trace
    if trace is None:
        raise SystemExit("the primary method gives no torque over the swing")
    phase = np.linspace(0, 360, len(trace.angle_rad), endpoint=False)
    series = (
        Series.over(phase, trace.compensated_nm, "bearing (compensated)", "line"),
        Series.over(phase, trace.raw_nm, "at the sensor, 1000 N", "line"),
        Series.over(phase, trace.no_load_nm, "at the sensor, no load", "line"),
    )
    marks = tuple(
        Mark("y", printed, name=f"printed maxima: sensor {SENSOR_NM:g}, bearing {BEARING_NM:g} N·m")
        for printed in (SENSOR_NM, BEARING_NM)
    )
    return draw(Picture("", "", (Figure("", PHASE, TORQUE, series, marks),))).svg


def no_load_over_frequency(result: Result) -> bytes:
    """Return the no-load peaks of the simulated rig, Table 2, Eq. (1), and what both leave over."""
    points = peak_points(TorqueDetails.of(result).no_load)
    fit = next(each for each in TorqueDetails.of(result).fits if each.name == "polynomial")
    curve = fit.curve
    if curve is None:
        raise SystemExit(f"the quadratic could not be fitted: {fit.problem}")
    x = np.linspace(*curve.valid_x, 120)
    value, _ = curve.predict(x)
    hertz, printed = TABLE_2
    peaks = (
        Series.over(points.x, points.y, "simulated rig"),
        Series.over(hertz, printed, "the paper's Table 2"),
        Series.over(x, value, "quadratic fitted to the rig", "line"),
        Series.over(x, np.polyval(EQUATION_1, x), "the paper's Eq. (1)", "line"),
    )
    left = (
        Series.over(points.x, 1e3 * curve.residuals, "simulated rig"),
        Series.over(hertz, 1e3 * (printed - np.polyval(EQUATION_1, hertz)), "the paper's Table 2"),
    )
    panels = (
        Figure("", FREQUENCY, Axis("no-load peak", "N·m"), peaks),
        Figure("", FREQUENCY, Axis("left over", "mN·m"), left, (Mark("y", 0.0),)),
    )
    return draw(Picture("", "", panels)).svg


def loaded_over_frequency(result: Result, truth_nm: float) -> bytes:
    """Return raw peaks and what each method leaves of them, with the paper's numbers."""
    points = peak_points(TorqueDetails.of(result).loaded)
    hertz, printed = TABLE_1
    raw = (
        Series.over(points.x, points.y, "raw peaks, simulated rig", "joined"),
        Series.over(hertz, printed, "the paper's Table 1"),
    )
    compensated = (
        _method(result, "template_inverse"),
        _method(result, "paper_peak"),
        Series.over(hertz, printed - np.polyval(EQUATION_1, hertz), "Eq. (2) on Table 1"),
        Series.over(*CLAIMED, "claimed by the paper", "marked"),
    )
    truth = (Mark("y", truth_nm, name="simulated truth"),)
    panels = (
        Figure("Uncompensated", FREQUENCY, Axis("torque", "N·m", low=0), raw),
        Figure("Compensated", FREQUENCY, Axis("torque", "N·m", high=2.1), compensated, truth),
    )
    return draw(Picture("", "", panels, in_a_row=True)).svg


def _method(result: Result, name: str) -> Series:
    points = TorqueDetails.of(result).compensations[name].points
    frequency = [point.frequency_hz for point in points]
    return Series.over(frequency, [point.torque.value for point in points], name, "joined")


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
    points = TorqueDetails.of(result).compensations[TorqueDetails.of(result).primary].points
    top = max(points, key=lambda each: each.frequency_hz)
    return {
        "paper-kinematics.svg": kinematics(rig_of(result.run).eccentric_ratio),
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
