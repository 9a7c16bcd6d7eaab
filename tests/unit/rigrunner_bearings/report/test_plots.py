"""The figures of torque, as data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.verdict import Limits
from rigrunner_bearings.report.figures.cycles import cycle_values
from rigrunner_bearings.report.figures.fits import fitted_peaks
from rigrunner_bearings.report.figures.frequency import over_frequency
from rigrunner_bearings.report.figures.kinematics import motion
from rigrunner_bearings.report.figures.swing import (
    compensated_swings,
    loops,
    over_phase,
    recorded_swings,
)
from rigrunner_bearings.report.view.points import set_points
from unit.rigrunner_reports.helpers_report import (
    RATIO,
    TRUTH_NM,
    deciding,
    loaded_result,
    no_load_result,
    report_input,
    torque_of,
)


@pytest.fixture(scope="module")
def result():
    return loaded_result()


@pytest.fixture(scope="module")
def points(result):
    return set_points(report_input(result))


def series_of(panel):
    return {series.name: series for series in panel.series}


def test_raw_and_compensated_torque_are_side_by_side(result, points):
    left, right = over_frequency(result, points).panels
    raw, compensated = (series_of(left)["raw peak"], series_of(left)[torque_of(result).primary])
    # the helper's torque: 0.7262 - 0.003 at each frequency, far below the raw peaks
    assert [p.x for p in raw.points] == [p.x for p in compensated.points]
    assert compensated.points[0].y == pytest.approx(TRUTH_NM - 0.003, abs=0.004)
    assert all(p.U > 0 for p in compensated.points)
    assert raw.points[-1].y > 6
    methods = torque_of(result).compensations.items()
    applicable = [name for name, method in methods if method.points]
    assert set(series_of(right)) == {*applicable, "simulated truth"}
    assert right.series[0].name == torque_of(result).primary  # so it looks as on the left


def test_negative_torque_is_not_cut_off(result, points):
    def bottom(shift_nm):
        moved = [shifted(point, shift_nm, torque_of(result).primary) for point in points]
        return over_frequency(result, moved).panels[0].y.low

    assert bottom(0.0) == 0
    assert bottom(-1.0) is None


def at_frequency(set_point, frequency_hz, **changes):
    measured = replace(set_point.point.frequency_hz, value=frequency_hz)
    methods = {
        k: replace(result, frequency_hz=frequency_hz) for k, result in set_point.by_method.items()
    }
    point = replace(set_point.point, frequency_hz=measured, **changes)
    return replace(set_point, point=point, by_method=methods)


def test_markers_of_methods_are_offset_slightly(result, points):
    slow = [at_frequency(point, 0.01 * point.frequency_hz) for point in points]
    measured_hz = np.array([point.frequency_hz for point in slow])
    methods = series_of(over_frequency(result, slow).panels[1])
    first, second = ([p.x for p in methods[name].points] for name in list(methods)[:2])
    assert first != second
    for method_hz in (first, second):
        assert np.abs(np.array(method_hz) - measured_hz).max() < 0.02 * measured_hz.max()


def test_both_limits_are_marked_and_labelled(result, points):
    limits = Limits.between(0.5, 0.95)
    limited = replace(result, decision=deciding(result.decision, limits=limits))
    for panel in over_frequency(limited, points).panels:
        assert [(mark.axis, mark.at, mark.is_limit) for mark in panel.marks] == [
            ("y", 0.5, True),
            ("y", 0.95, True),
        ]
        assert {mark.name for mark in panel.marks} == {f"limit {limits}"}


def test_single_set_point_is_clear_of_plot_edge(result, points):
    for panel in over_frequency(result, points[-1:]).panels:
        assert panel.x.high > 1.03 * points[-1].frequency_hz


def shifted(set_point, shift_nm, name):
    result = set_point.by_method[name]
    torque = replace(result.torque, value=result.torque.value + shift_nm)
    return replace(
        set_point, by_method={**set_point.by_method, name: replace(result, torque=torque)}
    )


def test_alt_text_has_raw_and_compensated_torque(result, points):
    alt = over_frequency(result, points).alt
    # the helper's torques: 0.7262 - 0.003 and 0.7262 - 0.163 at 1 Hz
    assert "template_inverse in N·m: 1 Hz 0.723 ± 0.015" in alt
    assert "paper_peak in N·m: 1 Hz 0.563 ±" in alt


def test_loop_work_is_that_of_friction(points):
    plot = loops(compensated_swings(points, "template_inverse"))
    rectangle = 4 * TRUTH_NM * np.arcsin(RATIO)
    work = float(plot.alt.split("compensated ")[1].split(" J")[0])
    # friction turns over within 0.002 rad of a stroke of 0.089 rad: 2 x 0.002/0.089 is missing
    assert work == pytest.approx(rectangle * (1 - 2 * 0.002 / (2 * np.arcsin(RATIO))), rel=0.01)


def test_lowest_middle_and_highest_frequency_are_shown(points):
    swings = compensated_swings(points, "template_inverse")
    assert [round(swing.frequency_hz) for swing in swings] == [1, 18, 35]


def test_method_without_traces_has_no_swings(points):
    assert compensated_swings(points, "paper_peak") == []


def test_no_load_run_shows_its_own_swings():
    points = set_points(report_input(no_load_result()))
    plot = over_phase(recorded_swings(points))
    assert "mean of the kept swings from" in plot.alt


def test_alt_text_of_fits_has_peaks_and_residuals(result):
    alt = fitted_peaks(torque_of(result).fits).alt
    first = torque_of(result).fits[0]
    assert f"1 Hz {first.points.y[0]:.3f}" in alt
    assert alt.count("Residuals of") == 1


def test_alt_text_counts_kept_cycles(result):
    alt = cycle_values([("This run", torque_of(result).loaded)]).alt
    assert "8 Hz 29 of 30" in alt
    assert "10 Hz 30 of 30" in alt


def test_motion_has_peaks_of_paper(result):
    # Wang et al. at 35 Hz: 9.3578 rad/s and 2170.5367 rad/s2; drawn at 361 phases
    point = torque_of(result).loaded[-1]
    at_35_hz = replace(point, frequency_hz=replace(point.frequency_hz, value=35.0))
    alt = motion(at_35_hz, RATIO).alt
    assert float(alt.split("rad/s): from ")[1].split(" to ")[1].split(". ")[0]) == pytest.approx(
        9.3578, abs=5e-4
    )
    assert float(alt.rsplit(" to ", 1)[1].rstrip(".")) == pytest.approx(2170.5367, abs=0.5)
