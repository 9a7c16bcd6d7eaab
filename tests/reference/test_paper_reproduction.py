"""The published method on the published tables, run by the shipped procedure.

Wang et al., Machines 2025, 13(11), 976. Expected values are computed here from the printed ones, in
rational numbers, or were recomputed elsewhere; none comes from the analysis.
"""

from __future__ import annotations

import json
from fractions import Fraction

import numpy as np
import pytest

from helpers_workflow import run
from reference.helpers_exact import exact_least_squares
from rigrunner.analysis.document import document
from rigrunner.api.analysis import Consequence
from rigrunner.run.locate import find_procedure, find_station
from rigrunner_bearings.api.torque import TorqueDetails

HZ = [1, 5, 10, 15, 20, 25, 30, 35]
NM = [Fraction(t) for t in ("0.83", "1.21", "1.64", "2.32", "3.01", "3.96", "5.12", "6.91")]
LOADED = {1: Fraction("0.88"), 10: Fraction("2.16"), 20: Fraction("4.31")}
PRINTED = [Fraction("0.9173"), Fraction("0.0247"), Fraction("0.0041")]
EXACT = [Fraction(5536529, 6035400), Fraction(1785697, 72424800), Fraction(97813, 24141600)]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    runs = tmp_path_factory.mktemp("runs")
    finished_run = run(find_procedure("paper_reproduction"), runs, station=find_station("paper"))
    assert finished_run.error is None
    return finished_run


@pytest.fixture(scope="module")
def result(finished):
    return finished.result


def value(coefficients, hz):
    return sum(c * hz**power for power, c in enumerate(coefficients))


def torques(result, name):
    return [point.torque.value for point in TorqueDetails.of(result).compensations[name].points]


def test_measured_values_are_those_of_both_tables(result):
    assert [point.frequency_hz.value for point in TorqueDetails.of(result).no_load] == HZ
    assert [float(point.peak_nm[0]) for point in TorqueDetails.of(result).no_load] == [
        float(t) for t in NM
    ]
    assert {p.set_frequency_hz: float(p.peak_nm[0]) for p in TorqueDetails.of(result).loaded} == {
        hz: float(t) for hz, t in LOADED.items()
    }


def test_table_2_gives_equation_1_to_the_last_digit(result):
    (curve,) = (fit.curve for fit in TorqueDetails.of(result).fits if fit.name == "polynomial")
    assert curve.coefficients == pytest.approx([float(c) for c in EXACT], rel=1e-12)
    assert curve.coefficients.round(4).tolist() == [float(c) for c in PRINTED]
    residuals = [float(t - value(EXACT, hz)) for hz, t in zip(HZ, NM, strict=True)]
    assert curve.residuals == pytest.approx(residuals, abs=1e-12)
    assert np.sum(curve.residuals**2) == pytest.approx(0.11088321928400216, rel=1e-11)


def test_equation_2_on_table_1_is_neither_flat_nor_always_positive(result):
    published = [float(t - value(PRINTED, hz)) for hz, t in LOADED.items()]
    assert torques(result, "paper_peak") == pytest.approx(published, abs=1e-12)
    assert np.round(published, 3).tolist() == [-0.066, 0.586, 1.259]
    refitted = [float(t - value(EXACT, hz)) for hz, t in LOADED.items()]
    assert torques(result, "refitted") == pytest.approx(refitted, abs=1e-11)
    assert np.round(refitted, 3).tolist() == [-0.066, 0.591, 1.279]


def test_difference_at_same_frequency_is_that_of_tables(result):
    no_load = dict(zip(HZ, NM, strict=True))
    expected = [float(t - no_load[hz]) for hz, t in LOADED.items()]
    assert torques(result, "peak_same_frequency") == pytest.approx(expected, abs=1e-12)


def test_basis_of_paper_is_not_the_best_by_aicc(result):
    (curve,) = (fit.curve for fit in TorqueDetails.of(result).fits if fit.name == "aicc")
    scores = {candidate.parameters: [] for candidate in curve.candidates}
    for candidate in curve.candidates:
        scores[candidate.parameters].append((candidate.score, candidate.chosen))
    assert sorted(scores[3]) == [
        (pytest.approx(-30.2, abs=0.05), True),
        (pytest.approx(-12.9, abs=0.05), False),
    ]
    assert scores[2] == [(pytest.approx(-19.7, abs=0.05), False)]
    assert scores[4] == [(pytest.approx(-9.3, abs=0.05), False)]
    best = exact_least_squares([[1, hz, hz**4] for hz in HZ], NM).coefficients
    assert curve.coefficients == pytest.approx([float(c) for c in best], rel=1e-10)


def test_impossible_torque_is_flagged_but_counted(result):
    checks = {check.name: check for check in result.checks}
    assert not checks["positive torque"].ok
    assert checks["friction coefficient"].consequence is Consequence.NOTE
    assert result.headline.value == pytest.approx(np.mean(torques(result, "paper_peak")))
    waveforms = TorqueDetails.of(result).compensations["template_inverse"]
    assert waveforms.points == ()
    assert "angle" in waveforms.not_applicable


def test_unknown_scatter_of_single_value_is_noted(result):
    for name in ("paper_peak", "refitted"):
        compensation = TorqueDetails.of(result).compensations[name]
        assert any("scatter is not known" in note for note in compensation.notes)
        assert all(np.isnan(point.torque.u) for point in compensation.points)
        u = {part.name: part.u for part in compensation.points[1].components}
        assert u["no-load fit"] > 0.05


def test_report_shows_numbers_of_json(finished, result):
    content = json.loads((finished.folder / "result.json").read_text(encoding="utf-8"))
    assert content == json.loads(json.dumps(document(result)))
    text = finished.report.read_text(encoding="utf-8")
    minus = "\N{MINUS SIGN}"
    for words in (f"{minus}0.066", "1.259", "1.279", "not applicable", f"{minus}30.2"):
        assert words in text
