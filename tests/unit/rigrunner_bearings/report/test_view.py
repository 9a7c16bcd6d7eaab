# ruff: noqa: RUF001  (the tests look for typographic signs)
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.instruments import Instrument
from rigrunner_bearings.api.measurand import Condition, MeasurandKind, Nature
from rigrunner_bearings.api.points import MotionSource
from rigrunner_bearings.report.view import headline as head
from rigrunner_bearings.report.view.budget import budget
from rigrunner_bearings.report.view.cycles import rejections
from rigrunner_bearings.report.view.fits import fit_views
from rigrunner_bearings.report.view.frequency_table import frequency_table
from rigrunner_bearings.report.view.meaning import meaning
from rigrunner_bearings.report.view.methods import methods
from rigrunner_bearings.report.view.points import set_points, true_parameter, true_torque
from rigrunner_reports.view.instruments import instruments
from unit.rigrunner_reports.helpers_report import (
    PAPER_ERRORS,
    TEMPLATE_ERRORS,
    TRUTH_NM,
    changed,
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


def milli(errors):
    return [f"{'−' if error < 0 else '+'}{abs(1000 * error):.1f}" for error in errors]


def test_table_has_error_of_each_method_against_truth(result, points):
    table = frequency_table(torque_of(result), points)
    columns = {
        name: [row.cells[i].error for row in table.rows] for i, name in enumerate(table.methods)
    }
    assert columns["template_inverse"] == milli(TEMPLATE_ERRORS)
    assert columns["paper_peak"] == milli(PAPER_ERRORS)
    assert columns["energy"] == [""] * 12


def test_raw_peak_and_rig_part_have_digits_of_result(result, points):
    row = frequency_table(torque_of(result), points).rows[0]
    raw = torque_of(result).loaded[0].peak_nm.mean()
    assert row.raw == f"{raw:.3f}"
    assert row.rig == f"{raw - TRUTH_NM - TEMPLATE_ERRORS[0]:.3f}"


def test_column_has_decimals_of_its_most_certain_row(result):
    name = "template_inverse"
    first, *others = torque_of(result).compensations[name].points
    more_certain = replace(first, torque=replace(first.torque, u=0.001))
    compensation = replace(torque_of(result).compensations[name], points=(more_certain, *others))
    rescaled = changed(result, compensations={name: compensation})
    rows = frequency_table(torque_of(rescaled), set_points(report_input(rescaled))).rows
    assert rows[0].cells[0].interval == "0.7232 ± 0.0020"
    assert {len(row.rig.split(".")[1]) for row in rows} == {3}


def test_entered_frequency_is_not_shown_as_measured(result, points):
    entered = replace(points[0], point=replace(points[0].point, motion=MotionSource.ENTERED))
    first, second = frequency_table(torque_of(result), [entered, points[1]]).rows[:2]
    assert first.measured_hz == "\N{EM DASH}"
    assert second.measured_hz != "\N{EM DASH}"


def test_rejected_cycles_are_counted_and_listed(result, points):
    row = next(row for row in frequency_table(torque_of(result), points).rows if row.set_hz == "8")
    assert (row.peaks, row.swings) == ("29 / 1", "29 / 1")
    table = rejections(torque_of(result))
    assert [(row.frequency, row.cycle, row.judged_by) for row in table.rows] == [
        ("8", "7", "raw peak"),
        ("8", "7", "shape of the swing"),
    ]
    assert (table.rows[0].statistic, table.rows[0].critical) == ("4.810", "2.908")
    assert table.cycles == 24 * 30


def test_repeated_set_point_has_its_own_result(result):
    """Its frequency may be the same number, as that of one that was only entered."""
    twin = replace(torque_of(result).loaded[0], recording="again", load_n=500.0)
    name = "template_inverse"
    compensation = torque_of(result).compensations[name]
    twin_result = replace(compensation.points[0], raw_nm=0.5)
    repeated = changed(
        result,
        loaded=(twin, *torque_of(result).loaded),
        compensations={name: replace(compensation, points=(twin_result, *compensation.points))},
    )
    first, second, *_ = set_points(report_input(repeated))
    assert first.by_method[name] is twin_result
    assert second.by_method[name] is compensation.points[0]


def test_truth_is_matched_by_name_of_measurand():
    truth = {"starting_torque_nm": 0.7, "inertia_kgm2": 0.002}
    assert true_torque(truth, "load-induced starting torque") == 0.7
    assert true_torque(truth, "running torque") is None


def test_parameter_has_truth_if_all_points_agree(points):
    assert true_parameter(points, "inertia") == 0.002324
    assert true_parameter(points, "damping ratio") is None
    disagreeing = replace(points[0], truth={"inertia_kgm2": 0.003})
    assert true_parameter((disagreeing, *points[1:]), "inertia") is None


def test_methods_show_spread_error_and_coverage(result, points):
    views = {view.name: view for view in methods(torque_of(result), points)}
    paper, template = views["paper_peak"], views["template_inverse"]
    assert next(iter(views)) == "template_inverse"
    assert paper.evenness.spread == f"{1000 * (0.165 + 0.163):.0f}"
    assert paper.accuracy.rms == f"{1000 * np.sqrt(np.mean(np.square(PAPER_ERRORS))):.1f}"
    assert (paper.accuracy.worst.value, paper.accuracy.worst.frequency) == ("+165.0", "35")
    assert template.accuracy.covered == "12 of 12"
    assert views["energy"].accuracy is None
    assert views["tacho_only"].not_applicable == "there is no tacho channel"


def test_budget_shares_add_up_to_100_percent(result, points):
    shares = budget(torque_of(result), points)
    assert shares.columns[:3] == ("1 Hz", "18 Hz", "35 Hz")
    for column in range(3):
        assert sum(row.parts[column].percent for row in shares.rows) == pytest.approx(100, abs=0.3)
    drift = next(row for row in shares.rows if row.name == "zero drift")
    assert (drift.dof, drift.common, drift.parts[0].u) == ("∞", "all points", "5.8")


def test_headline_states_set_points_of_mean(result, points):
    detail = head.headline(result, points).detail
    assert "k = 1.96. Mean of 12 set-points, 1 Hz to 35 Hz, under 1000 N" in detail


def test_varying_load_is_shown_as_range(result, points):
    heavy = replace(points[0], point=replace(points[0].point, load_n=1100.0))
    assert "under 1000 N to 1100 N" in head.headline(result, (heavy, *points[1:])).detail


def test_headline_error_is_that_of_mean(result, points):
    assert head.truth(torque_of(result), points) == head.Truth(
        "0.7262 N·m", "+1.2 mN·m", covered=True
    )
    assert head.truth(torque_of(result), set_points(report_input(result, truth={}))) is None


def test_partial_truth_gives_no_error_of_mean(result):
    truth = report_input(result).truth
    partial = {name: truth_nm for name, truth_nm in truth.items() if name != "35 Hz"}
    assert head.truth(torque_of(result), set_points(report_input(result, truth=partial))) is None


def test_no_load_run_shows_range_of_peaks():
    result = no_load_result()
    headline = head.headline(result, set_points(report_input(result)))
    low, high = (
        point.peak_nm[point.peak_kept].mean()
        for point in (torque_of(result).loaded[0], torque_of(result).loaded[-1])
    )
    assert headline.value == f"{low:.3f} to {high:.3f}"
    assert head.raw(torque_of(result)) is None


def test_fits_show_coefficients_or_reason(result):
    good, bad = fit_views(torque_of(result).fits)
    curve = torque_of(result).fits[0].curve
    u = np.sqrt(curve.covariance[0, 0])
    assert good.coefficients[0][0] == "c0"
    assert f"{curve.coefficients[0]:.3f} ± {u:.3f} N·m" == good.coefficients[0][1]
    assert bad.problem == "two points are not enough here"


def test_accuracy_of_transducer_shows_its_origin(result):
    points = [{"applied": "5 N·m", "indicated": "5.04 N·m", "U": "0.01 N·m"}]
    entry = {"channel": "t.torque", "serial": "1", "full_scale": "10 N·m"}
    for accuracy, words in (
        ({"accuracy": "0.5 % FS"}, "±0.5 % of full scale"),
        ({"points": points}, "±50 mN·m, from the calibration points"),
    ):
        transducer = Instrument.model_validate(entry | accuracy)
        (row,) = map(dict, instruments(replace(result.run, instruments={"t.torque": transducer})))
        assert row["Accuracy"] == words


def test_caveats_and_truth_do_not_depend_on_title(result):
    german = replace(result, measurand="lastabhängiges Anlaufmoment")
    assert meaning(torque_of(german)) == meaning(torque_of(result))
    assert len(meaning(torque_of(german))) == 5
    assert "1.0 %" in " ".join(meaning(torque_of(german)))
    assert [point.truth_nm for point in set_points(report_input(german))] == [
        point.truth_nm for point in set_points(report_input(result))
    ]


def test_title_alone_adds_no_caveat(result):
    named = changed(result, measurand="starting torque", kind=None)
    assert meaning(torque_of(named)) == ()


@pytest.mark.parametrize(
    ("kind", "expected", "unexpected"),
    [
        (
            MeasurandKind(Nature.LOAD_INDUCED, Condition.UNDER_WAY),
            ("at zero load", "friction of the supports", "proportional to load"),
            "reversal of an oscillation",
        ),
        (MeasurandKind(Nature.TOTAL, Condition.FROM_REST), (), "zero load"),
    ],
)
def test_each_kind_of_measurand_has_its_caveats(result, kind, expected, unexpected):
    text = " ".join(meaning(torque_of(changed(result, kind=kind))))
    assert all(words in text for words in expected)
    assert unexpected not in text
