"""Results of one name as figures: over a coordinate, and within limits that differ."""

from __future__ import annotations

from math import inf, nan

import pytest

from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.data import Estimate
from rigrunner.api.findings import MeasurementResult, ResultDefinition
from rigrunner.api.verdict import Limits
from rigrunner.signal.result_figures import over_coordinate

OHM = ResultDefinition(name="resistance", symbol="R", text="resistance", unit="Ω")


def at(celsius, ohm, u=0.01, **labels):
    places = {"chamber.temperature": CoordinateValue(celsius, "°C")}
    labelled = {name: CoordinateValue(value) for name, value in labels.items()}
    estimate = Estimate(ohm, u, inf, "Ω")
    return MeasurementResult(of=OHM, estimate=estimate, coordinates={**places, **labelled})


def test_values_are_ordered_by_coordinate():
    limits = Limits(99.9, inf, "Ω")
    (figure,) = over_coordinate([(at(50.0, 119.4), None, False), (at(0.0, 100.0), limits, True)])
    assert (str(figure.x), str(figure.y)) == ("chamber.temperature / °C", "R / Ω")
    (series,) = figure.series
    first, second = series.points
    assert (first.x, first.y, first.lower, first.upper, first.missed) == (0, 100, 99.9, None, True)
    assert pytest.approx(0.0196, abs=1e-4) == first.U, "1.96 standard uncertainties"
    assert (second.lower, second.missed) == (None, False)
    assert figure.has_limits


def test_differing_limits_get_a_second_figure():
    low, high = Limits(99.883, 100.117, "Ω"), Limits(138.203, 138.808, "Ω")
    rows = [(at(0.0, 100.03), low, False), (at(100.0, 138.9), high, True)]
    values, within = over_coordinate(rows)
    assert [point.y for point in values.series[0].points] == [100.03, 138.9]
    ends = [(point.y, point.lower, point.upper) for point in within.series[0].points]
    assert ends[0] == pytest.approx((0.03, -0.117, 0.117))
    assert ends[1] == pytest.approx((0.3945, -0.3025, 0.3025))
    assert within.series[0].points[0].U == values.series[0].points[0].U


def test_equal_limits_get_no_second_figure():
    limits = Limits(90.0, 140.0, "Ω")
    assert len(over_coordinate([(at(t, 100.0), limits, False) for t in (0.0, 50.0)])) == 1


def test_limits_with_one_centre_get_no_second_figure():
    """Such as a tolerance that grows with the temperature: the values show it."""
    limited = [(at(t, 0.1), Limits(-w, w, "Ω"), False) for t, w in ((0.0, 0.3), (100.0, 0.8))]
    assert len(over_coordinate(limited)) == 1


def test_labels_separate_series_but_make_no_figure_alone():
    rows = [(at(t, 100.0, phase=p), None, False) for p in ("new", "worn") for t in (0.0, 50.0)]
    assert [series.name for series in over_coordinate(rows)[0].series] == ["new", "worn"]
    assert over_coordinate(rows[::2]) == (), "one temperature"


def test_an_unknown_uncertainty_has_no_bar():
    (figure,) = over_coordinate([(at(t, 1.0, nan), None, False) for t in (0.0, 1.0)])
    assert [point.U for point in figure.series[0].points] == [None, None]


def test_title_has_a_capital_but_a_name_stays_as_it_is():
    assert OHM.title == "Resistance"
    assert ResultDefinition(name="v", unit="V").title == "v"
