from __future__ import annotations

from dataclasses import replace
from io import BytesIO

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import style
from matplotlib.figure import Figure

from rigrunner.api.verdict import Limits
from rigrunner_reports.plots import canvas
from rigrunner_reports.plots.cycles import cycle_values
from rigrunner_reports.plots.fits import fitted_peaks
from rigrunner_reports.plots.frequency import _methods, _raw_and_compensated, over_frequency
from rigrunner_reports.plots.kinematics import motion
from rigrunner_reports.plots.swing import compensated_swings, loops, over_phase, recorded_swings
from rigrunner_reports.view.points import set_points
from unit.rigrunner_reports.helpers_report import (
    RATIO,
    TRUTH_NM,
    deciding,
    loaded_result,
    no_load_result,
    report_input,
)

pytestmark = pytest.mark.figures


@pytest.fixture(scope="module")
def result():
    return loaded_result()


@pytest.fixture(scope="module")
def points(result):
    return set_points(report_input(result))


def test_the_users_own_matplotlib_settings_change_nothing(result, points):
    plain = over_frequency(result, points).svg
    with mpl.rc_context({"font.size": 30, "axes.facecolor": "red", "svg.fonttype": "none"}):
        mine = dict(mpl.rcParams)
        assert over_frequency(result, points).svg == plain
        assert dict(mpl.rcParams) == mine


def test_a_torque_below_zero_is_not_cut_off(result, points):
    def bottom(shift_nm):
        moved = [shifted(each, shift_nm, result.primary) for each in points]
        axes = Figure().subplots()
        _raw_and_compensated(axes, result, moved)
        return axes.get_ylim()[0]

    assert bottom(0.0) == 0
    assert bottom(-1.0) < -1.0 + TRUTH_NM


def painted(points, result):
    """Return both panels of torque over frequency."""
    figure = Figure()
    figure.subplots(1, 2)
    _raw_and_compensated(figure.axes[0], result, points)
    _methods(figure.axes[1], result, points)
    return figure.axes


def at(each, frequency_hz, **changes):
    measured = replace(each.point.frequency_hz, value=frequency_hz)
    methods = {k: replace(found, frequency_hz=frequency_hz) for k, found in each.by_method.items()}
    point = replace(each.point, frequency_hz=measured, **changes)
    return replace(each, point=point, by_method=methods)


def test_methods_of_slow_swings_stand_apart_but_in_their_place(result, points):
    slow = [at(each, 0.01 * each.frequency_hz) for each in points]
    own = np.array([each.frequency_hz for each in slow])
    bars = painted(slow, result)[1].containers
    assert bars
    for each in bars:
        assert np.abs(each.lines[0].get_xdata() - own).max() < 0.02 * own.max()


def test_a_limit_is_named_on_the_side_where_the_result_is_not(result, points):
    for upper, side in ((0.5, "top"), (0.95, "bottom")):
        limited = replace(
            result, decision=deciding(result.decision, limits=Limits.between(None, upper))
        )
        for axes in painted(points, limited):
            assert [text.get_va() for text in axes.texts] == [side]


def test_no_curve_runs_through_a_legend(result, points):
    """Raw peaks that hardly grow, as over 1 Hz to 3 Hz, stand at the top of their panel."""
    flat = [at(each, each.frequency_hz, peak_nm=0 * each.point.peak_nm + 1.6) for each in points]
    for axes in painted(flat, result):
        axes.figure.canvas.draw()
        low, high = axes.get_ylim()
        box = axes.get_legend().get_window_extent().transformed(axes.transAxes.inverted())
        assert (axes.dataLim.y1 - low) / (high - low) < box.y0


def test_one_set_point_stands_clear_of_the_edge(result, points):
    for axes in painted(points[-1:], result):
        assert axes.get_xlim()[1] > 1.03 * points[-1].frequency_hz


def shifted(each, shift_nm, name):
    found = each.by_method[name]
    torque = replace(found.torque, value=found.torque.value + shift_nm)
    return replace(each, by_method={**each.by_method, name: replace(found, torque=torque)})


def test_a_picture_carries_no_date(result, points):
    assert b"dc:date" not in over_frequency(result, points).svg


def test_a_picture_is_what_matplotlib_saves(result, points, monkeypatch):
    """Drawing once instead of twice is quicker, and changes no byte."""
    monkeypatch.setattr("rigrunner_reports.plots.frequency.draw", saved)
    slowly = over_frequency(result, points).svg
    monkeypatch.undo()
    assert over_frequency(result, points).svg == slowly


def saved(paint, height_in):
    with style.context(["default", canvas.STYLE]):
        figure = Figure(figsize=(canvas.WIDTH_IN, height_in), layout="constrained")
        paint(figure)
        figure.savefig(buffer := BytesIO(), format="svg", metadata={"Date": None})
    return buffer.getvalue()


def test_the_text_beside_raw_and_compensated_torque_has_both(result, points):
    alt = over_frequency(result, points).alt
    # the errors that the helper put in: 0.7262 - 0.003 and 0.7262 - 0.163 at 1 Hz
    assert "template_inverse in N·m: 1 Hz 0.723 ± 0.015" in alt
    assert "paper_peak in N·m: 1 Hz 0.563 ±" in alt


def test_the_work_of_a_compensated_swing_is_that_of_its_friction(points):
    plot = loops(compensated_swings(points, "template_inverse"))
    rectangle = 4 * TRUTH_NM * np.arcsin(RATIO)
    work = float(plot.alt.split("compensated ")[1].split(" J")[0])
    # friction turns over within 0.002 rad of a stroke of 0.089 rad: 2 x 0.002/0.089 is missing
    assert work == pytest.approx(rectangle * (1 - 2 * 0.002 / (2 * np.arcsin(RATIO))), rel=0.01)


def test_low_middle_and_high_frequency_are_shown(points):
    swings = compensated_swings(points, "template_inverse")
    assert [round(swing.frequency_hz) for swing in swings] == [1, 18, 35]


def test_a_method_without_traces_has_no_swings(points):
    assert compensated_swings(points, "paper_peak") == []


def test_a_no_load_run_shows_its_own_swings():
    points = set_points(report_input(no_load_result()))
    plot = over_phase(recorded_swings(points))
    assert "mean of the kept swings from" in plot.alt


def test_fits_say_peaks_and_residuals(result):
    alt = fitted_peaks(result.fits).alt
    first = result.fits[0]
    assert f"1 Hz {first.points.y[0]:.3f}" in alt
    assert alt.count("Residuals of") == 1


def test_kept_cycles_are_counted(result):
    alt = cycle_values([("This run", result.loaded)]).alt
    assert "8 Hz 29 of 30" in alt
    assert "10 Hz 30 of 30" in alt


def test_the_motion_has_the_peaks_of_the_paper(result):
    # Wang et al. at 35 Hz: 9.3578 rad/s and 2170.5367 rad/s2; drawn at 361 phases
    point = result.loaded[-1]
    at_35_hz = replace(point, frequency_hz=replace(point.frequency_hz, value=35.0))
    alt = motion(at_35_hz, RATIO).alt
    assert float(alt.split("rad/s): from ")[1].split(" to ")[1].split(". ")[0]) == pytest.approx(
        9.3578, abs=5e-4
    )
    assert float(alt.rsplit(" to ", 1)[1].rstrip(".")) == pytest.approx(2170.5367, abs=0.5)


def test_lines_can_be_told_apart_without_colour():
    lines = (canvas.PRIMARY, *canvas.OTHERS)
    assert len({(line.linestyle, line.marker) for line in lines}) == len(lines)
    assert len({line.linestyle for line in canvas.LOW_MIDDLE_HIGH}) == 3
