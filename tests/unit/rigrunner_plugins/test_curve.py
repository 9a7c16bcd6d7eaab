"""The analysis `curve`, against certified values and independent computations."""

from __future__ import annotations

import re
from dataclasses import replace
from math import isnan, sqrt
from pathlib import Path

import numpy as np
import pytest

from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.data import Measurement, Recording, RunData
from rigrunner.api.errors import DataError, PluginError
from rigrunner.api.instruments import Instrument
from rigrunner.registry import load_registry
from rigrunner_plugins.analyses.curve.points import sources
from rigrunner_plugins.analyses.curve.settings import CurveSettings

STRD = Path(__file__).parents[2] / "reference" / "strd"
START = "2026-01-05T10:00:00+00:00"
UNITS = {"cell.signal": "V", "lever.torque": "N·m", "meter.current": "A", "room.air": "K"}
LINE = {"polynomial": {"degree": 1}}


def rows(x, y, *, of="cell.signal", over="lever.torque", labels=(), read=False, units=UNITS):
    """Return a row for each point; x is a set-point unless it is read."""
    labels = labels or [{}] * len(x)
    return [
        Measurement(
            "points", START, {} if read else {over: float(a)},
            {of: float(b)} | ({over: float(a)} if read else {}), units, coordinates=label,
        )
        for a, b, label in zip(x, y, labels, strict=True)
    ]  # fmt: skip


def entry(channel, measures, accuracy):
    return Instrument.model_validate(
        {"channel": channel, "measures": measures, "serial": "S-1", "accuracy": accuracy}
    )


EXACT = entry("cell.signal", "voltage", {"drift": "0 V"})


def run_of(measured, *instruments, recordings=()) -> RunData:
    return RunData(
        run_id="r", procedure_id="P", procedure_revision="A", procedure_title="", station_id="s",
        started_utc=START, ended_utc=START, outcome="completed", inputs={},
        instruments={instrument.channel: instrument for instrument in instruments},
        zeros={}, recordings=tuple(recordings), measurements=tuple(measured),
    )  # fmt: skip


def findings(run, results, fit=LINE, **settings):
    common = {"of": "cell.signal", "over": "lever.torque", "fit": fit, "results": results}
    return Scrutiny(load_registry()).make("analysis", "curve", common | settings)(run)


def results_of(run, results, fit=LINE, **settings):
    return {result.name: result for result in findings(run, results, fit, **settings).results}


def nist(name):
    """Return y, the columns of x, and certified values with standard deviations."""
    lines = (STRD / f"{name}.dat").read_text(encoding="utf-8").splitlines()
    data = np.array([list(map(float, line.split())) for line in lines[60:] if line.strip()])
    table = [line.split() for line in lines[:60]]
    certified = [
        (float(words[1]), float(words[2]))
        for words in table
        if len(words) == 3 and re.fullmatch("B[0-9]", words[0])
    ]
    return data[:, 0], data[:, 1:], np.array(certified)


@pytest.mark.parametrize(("name", "degree", "digits"), [("Norris", 1, 11), ("Pontius", 2, 11)])
def test_parameters_equal_those_certified_by_nist(name, degree, digits):
    y, x, certified = nist(name)
    units = {"cell.signal": "1", "lever.torque": "1"}
    results = {f"c{k}": {"name": f"b{k}", "unit": "1"} for k in range(degree + 1)}
    run = run_of(rows(x[:, 0], y, units=units))
    got = results_of(run, {"parameters": results}, {"polynomial": {"degree": degree}})
    for k, (value, u) in enumerate(certified):
        assert got[f"b{k}"].estimate.value == pytest.approx(value, rel=10.0**-digits)
        assert got[f"b{k}"].components[0].u == pytest.approx(u, rel=1e-9)
        assert got[f"b{k}"].components[0].dof == len(y) - degree - 1


def test_several_regressors_equal_those_certified_by_nist():
    y, x, certified = nist("Longley")
    names = [f"x{k}" for k in range(1, 7)]
    sources = {name: f"in.{name}" for name in names}
    measured = [
        Measurement("points", START, {sources[n]: v for n, v in zip(names, row, strict=True)},
                    {"cell.signal": value}, {})
        for row, value in zip(x, y, strict=True)
    ]  # fmt: skip
    measured = [
        Measurement(row.name, START, row.setpoints, row.values,
                    dict.fromkeys((*row.setpoints, *row.values), "1"))
        for row in measured
    ]  # fmt: skip
    model = "b0 + " + " + ".join(f"b{k}*x{k}" for k in range(1, 7))
    fit = {"expression": {"over": names, "model": model, "start": {f"b{k}": 1 for k in range(7)}}}
    at = {name: f"{value:.6f} 1" for name, value in zip(names, x.mean(axis=0), strict=True)}
    results = {
        "parameters": {f"b{k}": {"name": f"b{k}", "unit": "1"} for k in range(7)},
        "value": {"name": "middle", "unit": "1", "at": at},
    }
    got = results_of(run_of(measured), results, fit, over=sources)
    for k, (value, u) in enumerate(certified):
        assert got[f"b{k}"].estimate.value == pytest.approx(value, rel=1e-9)
        assert got[f"b{k}"].components[0].u == pytest.approx(u, rel=1e-9)
    # at the mean of the regressors least squares gives the mean of y, u = s/sqrt(n)
    assert got["middle"].estimate.value == pytest.approx(y.mean(), rel=1e-8)
    assert got["middle"].components[0].u == pytest.approx(304.854073561965 / 4, rel=1e-5)


X = np.array([0, 2, 4, 6, 8, 10.0])
NOISE = np.array([1.2, -0.7, 0.3, -1.1, 0.9, -0.4]) * 1e-3
Y = 0.05 + 0.2 * X + NOISE


def test_gain_and_offset_act_as_one_error_on_all_points():
    """y = a + b x: a gain g of y moves b by b g, an offset moves a alone."""
    results = {
        "parameters": {"c0": {"name": "a", "unit": "mV"}, "c1": {"name": "b", "unit": "mV/(N·m)"}},
        "slope": {"name": "slope", "unit": "V/(N·m)"},
    }
    of_y = entry("cell.signal", "voltage", {"gain": "0.3 %", "offset": "2 mV"})
    of_x = entry("lever.torque", "force", {"offset": "0.1 N"}).model_copy(
        update={"measures": "torque"}
    )
    got = results_of(run_of(rows(X, Y), of_y, of_x), results)
    b, a = np.polyfit(X, Y, 1)
    lines = {name: {line.name: line.u for line in got[name].components} for name in got}
    assert lines["slope"]["gain of cell.signal"] == pytest.approx(b * 0.003 / sqrt(3), rel=1e-6)
    assert lines["b"]["gain of cell.signal"] == pytest.approx(1e3 * b * 0.003 / sqrt(3), rel=1e-6)
    assert lines["a"]["gain of cell.signal"] == pytest.approx(1e3 * a * 0.003 / sqrt(3), rel=1e-6)
    assert lines["slope"]["offset of cell.signal"] == pytest.approx(0, abs=1e-9)
    assert lines["a"]["offset of cell.signal"] == pytest.approx(2 / sqrt(3), rel=1e-6)
    assert lines["a"]["offset of lever.torque"] == pytest.approx(1e3 * b * 0.1 / sqrt(3), rel=1e-5)
    assert lines["slope"]["offset of lever.torque"] == pytest.approx(0, abs=1e-9)


def test_accuracy_in_one_figure_counts_with_its_greatest_effect():
    """For a slope the sum of |weights|: errors of -1 and +1 on either side of the middle."""
    results = {"slope": {"name": "slope", "unit": "V/(N·m)"}}
    got = results_of(run_of(rows(X, Y), entry("cell.signal", "voltage", "3 mV")), results)
    weights = (X - X.mean()) / np.sum((X - X.mean()) ** 2)
    (line,) = (line for line in got["slope"].components if line.name.startswith("reading"))
    assert line.u == pytest.approx(np.abs(weights).sum() * 0.003 / sqrt(3), rel=1e-6)


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("at", ["first", "between", "last"])
def test_slope_of_large_nearly_constant_y_has_the_error_of_its_readings(degree, at):
    """10 kV that changes by 20 mV, against the exact weights of the readings in the slope."""
    x = np.array([0.0, 1.1, 2.3, 3.0, 4.2, 5.5, 6.1, 8.0])
    y = 1e4 + 0.01 * np.sin(x)
    x_at = {"first": x[0], "between": 3.7, "last": x[-1]}[at]
    results = {"slope": {"name": "slope", "at": f"{x_at} N·m", "unit": "V/(N·m)"}}
    run = run_of(rows(x, y), entry("cell.signal", "voltage", "3 mV"))
    got = results_of(run, results, {"polynomial": {"degree": degree}})["slope"]
    powers = np.arange(degree + 1)
    design = x[:, None] ** powers
    gradient = powers * x_at ** np.maximum(powers - 1, 0)
    weights = gradient @ np.linalg.pinv(design)
    (line,) = (line for line in got.components if line.name.startswith("reading"))
    assert line.u == pytest.approx(np.abs(weights).sum() * 0.003 / sqrt(3), rel=2e-3)
    assert got.estimate.value == pytest.approx(weights @ (y - y[0]), rel=1e-6)
    scatter = next(line for line in got.components if line.name.startswith("scatter"))
    residuals = y - y[0] - design @ (np.linalg.pinv(design) @ (y - y[0]))
    s = sqrt(float(residuals @ residuals) / (len(x) - degree - 1))
    assert scatter.u == pytest.approx(s * float(np.linalg.norm(weights)), rel=1e-5)


def test_unregistered_instrument_makes_u_unknown():
    got = results_of(run_of(rows(X, Y)), {"slope": {"name": "slope", "unit": "V/(N·m)"}})
    assert isnan(got["slope"].estimate.u)


def test_set_point_without_register_entry_is_exact_with_a_note():
    results = {"slope": {"name": "slope", "unit": "V/(N·m)"}}
    notes = findings(run_of(rows(X, Y), EXACT), results).notes
    assert "lever.torque counts as exact: the register has no entry for it." in notes


def simulated_inverse(readings, rng):
    """Return x at the y of x = 7, in each of many calibrations."""
    s, trials = 1e-3, 40_000
    y = 0.05 + 0.2 * X + rng.normal(0, s, (trials, len(X)))
    y_read = 0.05 + 0.2 * 7 + (rng.normal(0, s / sqrt(readings), trials) if readings else 0.0)
    middle = X - X.mean()
    slopes = y @ middle / (middle @ middle)
    return X.mean() + (y_read - y.mean(axis=1)) / slopes, s


@pytest.mark.parametrize("readings", [None, 1, 4])
def test_u_of_inverse_use_equals_scatter_of_simulated_calibrations(readings):
    simulated_x, s = simulated_inverse(readings, np.random.default_rng(5))
    results = {"x_at": {"name": "x", "unit": "N·m", "y": "1.45 V"} | (
        {"readings": readings} if readings else {})}  # fmt: skip
    y = 0.05 + 0.2 * X + NOISE
    got = results_of(run_of(rows(X, y), EXACT), results)["x"]
    line, residual = np.polyfit(X, y, 1), np.polyval(np.polyfit(X, y, 1), X) - y
    scale = s / sqrt(residual @ residual / 4)  # the scatter of the trials, not of this calibration
    assert got.estimate.value == pytest.approx((1.45 - line[1]) / line[0], rel=1e-9)
    assert got.components[0].u * scale == pytest.approx(simulated_x.std(), rel=0.02)
    assert got.components[0].dof == 4


def test_gain_of_the_meter_cancels_if_the_same_meter_reads_both():
    """Calibration and use have the same gain: x does not depend on it."""
    gain = entry("cell.signal", "voltage", {"gain": "1 %", "offset": "5 mV"})
    run = run_of(rows(X, Y), gain)
    fixed_y = results_of(run, {"x_at": {"name": "x", "unit": "N·m", "y": "1.45 V"}})["x"]
    with_reading = results_of(
        run, {"x_at": {"name": "x", "unit": "N·m", "y": "1.45 V", "readings": 1}}
    )["x"]
    of_gain = {line.name: line.u for line in fixed_y.components}["gain of cell.signal"]
    assert of_gain == pytest.approx(1.45 * 0.01 / sqrt(3) / 0.2, rel=0.01)
    for line in with_reading.components[1:]:
        assert line.u == pytest.approx(0, abs=1e-6)


def test_unknown_x_is_computed_from_its_own_readings():
    labels = [{"phase": "calibration"}] * 6 + [{"phase": "unknown"}] * 2
    run = run_of(rows([*X, 3, 3], [*Y, 1.449, 1.451], labels=labels), EXACT)
    results = {"x_at": {"name": "x", "unit": "N·m", "where": {"phase": "unknown"}}}
    got = results_of(run, results, where={"phase": "calibration"})["x"]
    slope, constant = np.polyfit(X, Y, 1)
    assert got.estimate.value == pytest.approx((1.45 - constant) / slope, rel=1e-9)
    assert got.readings == 6


def test_unread_unknown_is_missing_and_other_results_remain():
    results = {
        "x_at": [
            {"name": "x", "unit": "N·m", "where": {"phase": "unknown"}},
            {"name": "given", "unit": "N·m", "y": "1.45 V"},
        ],
        "slope": {"name": "slope", "unit": "V/(N·m)"},
    }
    got = findings(run_of(rows(X, Y), EXACT), results)
    assert {result.name for result in got.results} == {"given", "slope"}
    (x,) = got.missing
    assert x.sentence == (
        "There is no value of x: cell.signal was not measured at phase = unknown."
    )


def test_shared_error_of_x_keeps_its_sign():
    """x too high by a fraction g makes the slope too low by g; an equation needs the sign."""
    meter = entry("meter.current", "current", {"gain": "1 %"})
    run = run_of(rows(X, Y, over="meter.current", read=True), EXACT, meter)
    slope = results_of(run, {"slope": {"name": "slope", "unit": "Ω"}}, over="meter.current")[
        "slope"
    ]
    (line,) = (line for line in slope.components if line.name == "gain of meter.current")
    assert line.sensitivity == pytest.approx(-slope.estimate.value, rel=1e-5)
    assert line.u == pytest.approx(slope.estimate.value * 0.01 / sqrt(3), rel=1e-5)


def test_value_outside_the_curve_is_missing_with_the_reason():
    results = {
        "value": {"name": "far", "unit": "V", "at": "12 N·m"},
        "x_at": {"name": "x", "unit": "N·m", "y": "9 V"},
        "slope": {"name": "slope", "unit": "V/(N·m)"},
    }
    got = findings(run_of(rows(X, Y), EXACT), results)
    assert [result.name for result in got.results] == ["slope"]
    assert [gap.name for gap in got.missing] == ["far", "x"]
    assert "12 N·m is outside the points, 0 to 10 N·m" in got.missing[0].why
    assert "the value 9 V nowhere" in got.missing[1].why


def test_place_without_a_curve_leaves_results_of_other_places():
    """At 2 A there is one point, too few for a line; at 3 A the points end at 5 N·m."""
    loads = [{"load": "1 A"}] * 6 + [{"load": "2 A"}] + [{"load": "3 A"}] * 6
    x, y = [*X, 3, *(X / 2)], [*Y, 1.4, *(Y / 2)]
    results = {
        "slope": {"name": "slope", "unit": "V/(N·m)"},
        "value": {"name": "at_8", "unit": "V", "at": "8 N·m"},
    }
    got = findings(run_of(rows(x, y, labels=loads), EXACT), results, per="load")
    assert [(result.name, result.place) for result in got.results] == [
        ("at_8", "load = 1 A"), ("slope", "load = 1 A"), ("slope", "load = 3 A"),
    ]  # fmt: skip
    alone = findings(run_of(rows(X, Y), EXACT), results)
    # As text: since Python 3.13 equal records with a NaN are not equal.
    assert [
        [repr(replace(line, of_points="")) for line in result.components]
        for result in got.results
        if result.place == "load = 1 A"
    ] == [
        [repr(replace(line, of_points="")) for line in result.components]
        for result in alone.results
    ]
    assert [(gap.name, gap.place) for gap in got.missing] == [
        ("at_8", "load = 2 A"), ("at_8", "load = 3 A"), ("slope", "load = 2 A"),
    ]  # fmt: skip
    assert "8 N·m is outside the points, 0 to 5 N·m" in got.missing[1].why


def test_curve_without_a_value_at_any_place_is_refused():
    loads = [{"load": "1 A"}, {"load": "2 A"}]
    results = {"slope": {"name": "slope", "unit": "V/(N·m)"}}
    with pytest.raises(DataError):
        findings(run_of(rows([1, 2], [1, 2], labels=loads), EXACT), results, per="load")


def test_curve_that_takes_a_value_twice_is_not_inverted():
    run = run_of(rows(X, (X - 5) ** 2 + NOISE), EXACT)
    results = {"x_at": {"name": "x", "unit": "N·m", "y": "4 V"}}
    got = findings(run, results, {"polynomial": {"degree": 2}})
    assert "at 2 places" in got.missing[0].why


def test_no_x_if_the_slope_is_not_significant():
    y = 1 + 0.001 * X + np.array([1, -1, 1, -1, 1, -1]) * 0.1
    results = {"x_at": {"name": "x", "unit": "N·m", "y": f"{y.mean()} V"}}
    got = findings(run_of(rows(X, y), EXACT), results)
    assert "is not significantly different from zero" in got.missing[0].why


def test_values_and_parameters_of_a_nonlinear_fit_have_units():
    """U = U0 exp(-x/x0) exactly: 10 V, 4 N·m; the start values are in other units."""
    y = 10 * np.exp(-X / 4) * (1 + np.array([1, -1, 1, -1, 1, -1]) * 1e-6)
    fit = {"expression": {"over": ["x"], "model": "U0*exp(-x/x0)",
                          "start": {"U0": "9000 mV", "x0": "3 N·m"}}}  # fmt: skip
    results = {
        "parameters": {"x0": {"name": "decay", "unit": "mN·m"}, "U0": {"name": "U0", "unit": "mV"}},
        "value": {"name": "at_3", "unit": "mV", "at": "3 N·m"},
    }
    got = results_of(run_of(rows(X, y), EXACT), results, fit)
    assert got["decay"].estimate.value == pytest.approx(4000, rel=1e-5)
    assert got["U0"].estimate.value == pytest.approx(10_000, rel=1e-5)
    assert got["at_3"].estimate.value == pytest.approx(10_000 * np.exp(-0.75), rel=1e-5)


def test_parameter_in_a_unit_of_another_quantity_is_refused():
    results = {"parameters": {"c1": {"name": "b", "unit": "V"}}}
    with pytest.raises(
        DataError, match=r"b is stated in V; the parameter 'c1' of the fit is in V/"
    ):
        results_of(run_of(rows(X, Y), EXACT), results)
    with pytest.raises(DataError, match="no parameter 'c7'; it has: c0, c1"):
        results_of(run_of(rows(X, Y), EXACT), {"parameters": {"c7": {"name": "b", "unit": "V"}}})


BENT = np.array([0, 1.03, 2.045, 3.03, 4.0])
"""Over 0 to 4: the least-squares line is y = 0.021 + x, off it by -21, 9, 24, 9 and -21 mV."""


def test_nonlinearity_is_the_greatest_deviation_from_the_best_line():
    run = run_of(rows(range(5), BENT), EXACT)
    results = {"nonlinearity": [
        {"name": "linearity", "unit": "mV"},
        {"name": "of_span", "unit": "%", "of_span": "yes"},
    ]}  # fmt: skip
    got = results_of(run, results)
    assert got["linearity"].estimate.value == pytest.approx(24.0, rel=1e-9)
    assert got["of_span"].estimate.value == pytest.approx(100 * 0.024 / 4.0, rel=1e-9)
    s = sqrt(sum(np.array([21, 9, 24, 9, 21]) ** 2) / 3)
    # in the middle of five points 1 - h = 1 - 1/5 of the variance is off the line
    assert got["linearity"].components[0].u == pytest.approx(s * sqrt(1 - 0.2), rel=1e-9)


def test_gain_cancels_in_a_ratio_without_rounding_error():
    """Rounding errors differ between machines, and `rigrunner verify` would report them."""
    accuracy = {"gain": "0.1 %", "offset": "1 mV"}
    run = run_of(rows(range(5), BENT), entry("cell.signal", "voltage", accuracy))
    results = {"nonlinearity": [
        {"name": "linearity", "unit": "mV"},
        {"name": "of_span", "unit": "%", "of_span": "yes"},
    ]}  # fmt: skip
    got = results_of(run, results)
    assert [line.u for line in got["of_span"].components[1:]] == [0.0, 0.0]
    gain, offset = got["linearity"].components[1:]
    assert gain.u == pytest.approx(0.001 / sqrt(3) * 24, rel=1e-6)
    assert offset.u == 0


def test_nonlinearity_relative_to_a_span_of_zero_is_missing():
    run = run_of(rows(range(5), np.ones(5)), EXACT)
    results = {"nonlinearity": {"name": "of_span", "unit": "%", "of_span": "yes"}}
    got = findings(run, results)
    assert not got.results
    (missing,) = got.missing
    assert "its span is 0" in missing.why


UP_AND_DOWN = [{"way": "up"}] * 3 + [{"way": "down"}] * 3
BOTH_WAYS = {"way": ["up", "down"]}


def test_hysteresis_is_falling_minus_rising_and_zero_return_is_that_at_zero():
    x = [0, 5, 10, 10, 5, 0]
    y = [0.000, 1.000, 2.000, 2.002, 1.010, 0.004]
    results = {
        "hysteresis": {"name": "hysteresis", "unit": "mV", "between": BOTH_WAYS},
        "zero_return": {"name": "zero", "unit": "mV", "between": BOTH_WAYS},
    }
    run = run_of(rows(x, y, labels=UP_AND_DOWN), entry("cell.signal", "voltage", "1 mV"))
    got = results_of(run, results)
    assert got["hysteresis"].estimate.value == pytest.approx(10.0, rel=1e-9)
    assert got["zero"].estimate.value == pytest.approx(4.0, rel=1e-9)
    lines = [line.u for line in got["zero"].components[1:]]
    assert lines == pytest.approx([1 / sqrt(3)] * 2, rel=1e-6)  # each reading has its own error


def test_hysteresis_tolerates_small_differences_of_a_measured_x():
    """The spring's travel is read: 5.00 and 5.02 mm on a slope of 0.2 are no hysteresis."""
    x = np.array([0, 5.00, 10, 10.01, 5.02, 0.01])
    run = run_of(rows(x, 0.2 * x, labels=UP_AND_DOWN, read=True), EXACT,
                 entry("lever.torque", "force", "0.001 N"))  # fmt: skip
    results = {"hysteresis": {"name": "hysteresis", "unit": "mV", "between": BOTH_WAYS}}
    assert results_of(run, results)["hysteresis"].estimate.value == pytest.approx(0, abs=1e-9)


def test_loop_of_many_set_points_is_compared_at_each_of_them():
    """Falling is above rising by 10 sin(πx/100) mV: 10 mV at 50, and 0 at 0."""
    up = np.linspace(0, 100, 121)
    x, off = np.r_[up, up[::-1]], np.r_[0 * up, 0.010 * np.sin(np.pi * up[::-1] / 100)]
    labels = [{"way": "up"}] * len(up) + [{"way": "down"}] * len(up)
    results = {
        "hysteresis": {"name": "hysteresis", "unit": "mV", "between": BOTH_WAYS},
        "zero_return": {"name": "zero", "unit": "mV", "between": BOTH_WAYS},
    }
    got = results_of(run_of(rows(x, 0.2 * x + off, labels=labels), EXACT), results)
    assert got["hysteresis"].estimate.value == pytest.approx(10.0, rel=1e-9)
    assert got["zero"].estimate.value == pytest.approx(0, abs=1e-9)


def test_nonlinearity_of_many_points_is_the_deviation_of_one_point():
    x = np.linspace(0, 100, 121)
    y = 0.2 * x + np.where(x == 50, 0.010, 0)
    results = {"nonlinearity": {"name": "linearity", "unit": "mV"}}
    got = results_of(run_of(rows(x, y), EXACT), results)["linearity"]
    assert got.estimate.value == pytest.approx(10.0 * (1 - 1 / len(x)), rel=1e-6)


def test_many_measured_x_are_compared_within_one_percent_of_their_range():
    up = np.linspace(0, 100, 121)
    x, off = np.r_[up, up[::-1]], np.r_[0 * up, 0.010 * np.sin(np.pi * up[::-1] / 100)]
    labels = [{"way": "up"}] * len(up) + [{"way": "down"}] * len(up)
    results = {"hysteresis": {"name": "hysteresis", "unit": "mV", "between": BOTH_WAYS}}
    run = run_of(rows(x, 0.2 * x + off, labels=labels, read=True), EXACT,
                 entry("lever.torque", "force", "0.001 N"))  # fmt: skip
    lower = 10 * np.sin(np.pi * 0.49)  # all within 1 % of the middle are above
    assert lower < results_of(run, results)["hysteresis"].estimate.value < 10.0


def test_repeated_values_give_u_of_hysteresis():
    x = [0, 5, 10, 10, 5, 0] * 2
    y = [0.001, 1.0, 2.0, 2.0, 1.0, 0.011, -0.001, 1.0, 2.0, 2.0, 1.0, 0.009]
    labels = UP_AND_DOWN * 2
    results = {"hysteresis": {"name": "hysteresis", "unit": "mV", "between": BOTH_WAYS}}
    got = results_of(run_of(rows(x, y, labels=labels), EXACT), results)["hysteresis"]
    # pooled: two pairs 2 mV apart, four that agree: s² = 2·(2 mV²)/6, and twice s²/2
    assert got.estimate.value == pytest.approx(10.0, rel=1e-9)
    assert (got.components[0].u, got.components[0].dof) == pytest.approx(
        (sqrt(2 / 3), 6.0), rel=1e-6
    )


def test_hysteresis_without_repeated_values_takes_u_from_the_curves():
    """Rising y = 0.2 x, falling 0.2 x + 10 mV, each ± 1 mV about its line, by hand.

    Residuals of +1, -1, -1, +1 mV are orthogonal to 1 and to x, so that s² = 4 mV² / (4 - 2) in
    each way, pooled with 4 degrees of freedom; two single values differ by √2 s = 2 mV.
    """
    x = np.array([0.0, 1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 0.0])
    off = np.array([1, -1, -1, 1, 1, -1, -1, 1]) / 1000
    way = [{"way": "up"}] * 4 + [{"way": "down"}] * 4
    y = 0.2 * x + off + np.array([0.0] * 4 + [0.010] * 4)
    results = {"hysteresis": {"name": "hysteresis", "unit": "mV", "between": BOTH_WAYS}}
    got = results_of(run_of(rows(x, y, labels=way), EXACT), results)["hysteresis"]
    assert got.estimate.value == pytest.approx(10.0, rel=1e-9)
    assert got.components[0].u == pytest.approx(2.0, rel=1e-9)
    assert got.components[0].dof == pytest.approx(4.0)


def test_curve_is_fitted_for_each_value_of_a_coordinate():
    labels = [{"lot": "a"}] * 6 + [{"lot": "b"}] * 6
    run = run_of(rows([*X, *X], [*Y, *(2 * Y)], labels=labels), EXACT)
    got = findings(run, {"slope": {"name": "slope", "unit": "V/(N·m)"}}, per="lot").results
    slopes = {str(result.coordinates["lot"]): result.estimate.value for result in got}
    assert slopes["b"] == pytest.approx(2 * slopes["a"], rel=1e-9)


def test_recording_is_a_point_with_the_value_of_its_statistic():
    recordings = [
        Recording(f"r{i}", 100.0, START, {"lever.torque": x}, {"cell.signal": np.array([y, y + 2])},
                  UNITS)
        for i, (x, y) in enumerate(zip(X, Y, strict=True))
    ]  # fmt: skip
    run = run_of([], EXACT, recordings=recordings)
    results = {"parameters": {"c0": {"name": "a", "unit": "V"}}}
    highest = results_of(run, results, statistic="maximum")["a"].estimate.value
    assert highest == pytest.approx(np.polyfit(X, Y, 1)[1] + 2, rel=1e-9)


def test_temperatures_count_from_0_celsius_by_default():
    celsius = np.array([0, 25, 50, 75, 100.0])
    run = run_of(rows(celsius + 273.15, 1 + 0.01 * celsius, over="room.air"), EXACT)
    results = {"parameters": {"c0": {"name": "a", "unit": "V"}},
            "x_at": {"name": "t", "unit": "°C", "y": "1.6 V"}}  # fmt: skip
    got = results_of(run, results, over="room.air")
    assert got["a"].estimate.value == pytest.approx(1.0, rel=1e-9)
    assert got["t"].estimate.value == pytest.approx(60.0, rel=1e-9)
    got = results_of(run, results, over="room.air", reference="50 °C")
    assert got["a"].estimate.value == pytest.approx(1.5, rel=1e-9)


def test_unknown_fit_is_refused_with_its_name():
    with pytest.raises(PluginError, match="there is no fit 'polynom'"):
        results_of(
            run_of(rows(X, Y), EXACT), {"slope": {"name": "s", "unit": "V/(N·m)"}}, "polynom"
        )


def test_figure_has_points_curve_band_and_residuals():
    celsius = np.array([0, 25, 50, 75, 100.0])
    y = 1 + 0.01 * celsius + np.array([1, -1, 0, -1, 1]) * 1e-3
    results = {"slope": {"name": "slope", "unit": "V/K"}}
    run = run_of(rows(celsius + 273.15, y, over="room.air"), EXACT)
    upper, lower = findings(run, results, over="room.air").figures
    assert (upper.of, str(upper.x), lower.of, lower.x) == (
        "slope",
        "room.air / °C",
        "slope",
        upper.x,
    )
    curve, points = upper.series
    assert (curve.kind, points.kind) == ("line", "points")
    assert [point.x for point in points.points] == pytest.approx(celsius)
    assert [point.y for point in points.points] == pytest.approx(y)
    residuals = y - np.polyval(np.polyfit(celsius, y, 1), celsius)
    left = [point.y for point in lower.series[1].points]
    assert left == pytest.approx(residuals, abs=1e-12)
    s = sqrt(residuals @ residuals / 3)
    at_end = s * sqrt(1 / 5 + 50**2 / 6250)  # of the mean, and of the slope 50 K from it
    width = curve.points[0].U
    assert width == pytest.approx(3.182446 * at_end, rel=1e-6)  # Student's t for 3, 95 %


MM = {"lever.travel": "m", "cell.force": "N"}
STROKE_MM = np.array([0, 2, 4, 6, 8.0])
FORCE_N = np.array([-0.4, 23.7, 47.6, 71.8, 95.5])
LENGTH = {"slope": {"name": "slope", "unit": "N/mm"}}


def spring(labels=(), force=FORCE_N):
    measured = rows(
        STROKE_MM / 1000, force, of="cell.force", over="lever.travel", units=MM, labels=labels
    )
    return [replace(measurement, written_in={"lever.travel": "mm"}) for measurement in measured]


def spring_findings(measured, fit=LINE, results=LENGTH, **settings):
    channels = {"of": "cell.force", "over": "lever.travel"}
    return findings(run_of(measured), results, fit, **channels | settings)


def test_formula_and_parameters_are_in_the_units_of_the_procedure():
    """Newton over millimetres by numpy, whose covariance is that of the scatter (H.3)."""
    got = spring_findings(spring())
    (c1, c0), covariance = np.polyfit(STROKE_MM, FORCE_N, 1, cov=True)
    by_name, by_value = got.formulas
    assert (by_name.symbol, by_name.text, by_name.quantities) == ("force", "c0 + c1*travel", {})
    assert by_value.text == by_name.text
    assert by_value.quantities == {
        "c0": f"(\N{MINUS SIGN}{-c0:.2f} N)", "c1": f"{c1:.3f} N/mm",
    }  # fmt: skip
    (table,) = got.tables
    assert table.columns == ("", "estimate", "u", "unit")
    assert [(row[0], row[3]) for row in table.rows] == [("c0", "N"), ("c1", "N/mm")]
    numbers = [row[1:3] for row in table.rows]
    expected = [(c0, sqrt(covariance[1, 1])), (c1, sqrt(covariance[0, 0]))]
    assert numbers == pytest.approx(np.array(expected), rel=2e-3)
    for figure in got.figures:
        assert figure.x.unit == "mm"
        assert [point.x for point in figure.series[1].points] == pytest.approx(STROKE_MM)
    assert [point.y for point in got.figures[0].series[1].points] == pytest.approx(FORCE_N)


def test_quadratic_shows_its_powers_and_a_stated_parameter_its_unit():
    fit = {"polynomial": {"degree": 2}}
    results = {"parameters": {"c1": {"name": "c", "unit": "kN/m"}}}
    got = spring_findings(spring(), fit, results)
    c2, c1, _ = np.polyfit(STROKE_MM, FORCE_N, 2)
    assert got.formulas[0].text == "c0 + c1*travel + c2*travel**2"
    units = {row[0]: (row[1], row[3]) for row in got.tables[0].rows}
    assert units["c1"] == (pytest.approx(c1, rel=1e-3), "kN/m")
    assert units["c2"] == (pytest.approx(c2, rel=1e-2), "N/mm²")


def test_expression_keeps_its_names_and_counts_x_from_its_reference():
    fit = {
        "expression": {"over": ["s"], "model": "F0 + k*s", "start": {"F0": "1 N", "k": "9 N/mm"}}
    }
    got = spring_findings(spring(), fit, reference="2 mm")
    by_name, _ = got.formulas
    assert by_name.text == "F0 + k*(travel - origin)"
    assert by_name.quantities == {"origin": "2 mm"}
    assert [row[0] for row in got.tables[0].rows] == ["F0", "k"]


def test_curves_at_several_places_share_a_formula():
    labels = [{"way": "up"}] * 5 + [{"way": "down"}] * 5
    measured = spring(labels[:5]) + spring(labels[5:], FORCE_N + 1)
    got = spring_findings(measured, per="way")
    assert len(got.formulas) == 1
    (table,) = got.tables
    assert [row[:2] for row in table.rows] == [
        ("way = up", "c0"), ("way = up", "c1"), ("way = down", "c0"), ("way = down", "c1"),
    ]  # fmt: skip


def test_temperature_axis_counts_from_0_celsius():
    run = run_of(rows(X + 273.15, Y, over="room.air"), EXACT)
    got = findings(run, {"slope": {"name": "s", "unit": "V/K"}}, over="room.air")
    assert got.formulas[0].text == "c0 + c1*(air - origin)"
    assert got.formulas[0].quantities == {"origin": "0 °C"}
    assert got.figures[0].x.unit == "°C"
    assert [row[-1] for row in got.tables[0].rows] == ["V", "V/K"]


def test_interpolation_has_no_formula():
    recordings = [
        Recording(f"r{i}", 100.0, START, {"lever.travel": x / 1000},
                  {"cell.force": y + np.array([0.1, -0.1, 0.2, -0.2])}, MM)
        for i, (x, y) in enumerate(zip(STROKE_MM, FORCE_N, strict=True))
    ]  # fmt: skip
    results = {"value": {"name": "F", "unit": "N", "at": "3 mm"}}
    got = findings(run_of([], recordings=recordings), results, "pchip", of="cell.force",
                   over="lever.travel")  # fmt: skip
    assert got.results
    assert (got.formulas, got.tables) == ((), ())


@pytest.mark.parametrize(
    ("results", "key", "words"),
    [
        ({"parameters": {"c0": {"name": "b", "unit": "°C"}}}, ("parameters", "c0", "unit"), "°C"),
        ({"hysteresis": {"name": "h", "unit": "dBm", "between": {"way": ["up", "down"]}}},
         ("hysteresis", "unit"), "got 'dBm', a power level; it is a level"),
        ({"value": {"name": "v", "unit": "dBm", "at": "1 A"}}, ("statistic",), "a logarithm"),
        ({"nonlinearity": {"name": "n", "unit": "°C"}}, ("nonlinearity", "unit"), "write K"),
    ],
)  # fmt: skip
def test_difference_must_be_stated_as_a_difference(results, key, words):
    """A parameter of 293.15 K would be 293.15 °C: only the fit knows that it is a difference."""
    of = "in.level" if "dBm" in str(results) else "room.air"
    units = UNITS | {"in.level": "dBm"}
    settings = {"of": of, "over": "meter.current", "fit": LINE, "results": results}
    if key == ("statistic",):
        settings["statistic"] = "rms"
    (objection,) = load_registry().objections("curve", settings, units)
    assert objection[0] in {("results", *key), key}
    assert words in " ".join(objection[1:3])


WEIGHTED = {"polynomial": {"degree": 1, "weighted": True}}


def noisy(torques, phase="calibration", *, way="", seed=1):
    """Return recordings of 2 V/(N·m) whose noise is 5 % of the value, and u of their means."""
    rng = np.random.default_rng(seed)
    recordings = []
    for i, torque in enumerate(torques):
        values = 2 * torque + 0.05 * torque * rng.normal(size=40)
        at = f"2026-01-05T{10 + seed}:{i:02d}:00+00:00"
        recordings.append(
            Recording(f"r{seed} {i}", 100.0, at, {"lever.torque": float(torque)},
                      {"cell.signal": values}, UNITS, coordinates={"phase": phase, "way": way})
        )  # fmt: skip
    return recordings


def recorded_points(recordings):
    """Return x, y, and the standard uncertainty of y in the fit."""
    results = {"parameters": {"c1": {"name": "b", "unit": "V/(N·m)"}}}
    source = next(sources_of(run_of((), recordings=recordings), results))
    return source.values.x[:, 0], source.values.y, source.values.u_y


def sources_of(run, results):
    settings = {"of": "cell.signal", "over": "lever.torque", "fit": WEIGHTED, "results": results}
    return sources(run, CurveSettings.model_validate(settings))


def weighted_line(x, y, u):
    """Return c0 and c1, s of weight 1/u² and the covariance (Draper and Smith, 9.2)."""
    columns = np.column_stack([np.ones_like(x), x]) / u[:, None]
    inverse = np.linalg.inv(columns.T @ columns)
    coefficients = inverse @ columns.T @ (y / u)
    s = sqrt(float(np.sum((y / u - columns @ coefficients) ** 2)) / (len(x) - 2))
    return coefficients, s, s**2 * inverse


@pytest.mark.parametrize("i", [1, 6])
def test_x_at_of_a_weighted_curve_scatters_as_nearby_points(i):
    """u²(x) = (u²(curve) + s² u²(y))/c1²: the noise at 2 N·m is not that at 64 N·m."""
    torques = 2.0 ** np.arange(8)
    calibration = noisy(torques)
    unknown = noisy(torques[i : i + 1], "unknown", seed=2)
    results = {
        "x_at": {"name": "x", "unit": "N·m", "where": {"phase": "unknown"}},
        "parameters": {"c0": {"name": "a", "unit": "V"}, "c1": {"name": "b", "unit": "V/(N·m)"}},
    }
    run = run_of((), EXACT, recordings=calibration + unknown)
    got = results_of(run, results, WEIGHTED, where={"phase": "calibration"})
    x, y, u = recorded_points(calibration)
    (c0, c1), s, covariance = weighted_line(x, y, u)
    assert got["b"].estimate.value == pytest.approx(c1, rel=1e-9)
    assert got["a"].components[0].u == pytest.approx(sqrt(covariance[0, 0]), rel=1e-9)
    assert got["b"].components[0].u == pytest.approx(sqrt(covariance[1, 1]), rel=1e-9)
    assert got["b"].components[0].dof == len(x) - 2
    at = (recorded_points(unknown)[1][0] - c0) / c1
    row = np.array([1.0, at])
    u_near = np.interp(at, x, u)
    assert got["x"].estimate.value == pytest.approx(at, rel=1e-9)
    u_x = sqrt(row @ covariance @ row + (s * u_near) ** 2) / c1
    assert got["x"].components[0].u == pytest.approx(u_x, rel=1e-6)


def test_deviations_of_a_weighted_curve_scatter_as_their_points():
    """Against 4000 trials of u(y), at the places of the greatest deviations."""
    torques = 2.0 ** np.arange(8)
    recordings = noisy(torques, way="up") + noisy(torques, way="down", seed=2)
    between = {"way": ["up", "down"]}
    results = {
        "nonlinearity": {"name": "n", "unit": "V"},
        "hysteresis": {"name": "h", "unit": "V", "between": between},
        "zero_return": {"name": "z", "unit": "V", "between": between},
    }
    run = run_of((), EXACT, recordings=recordings)
    got = results_of(run, results, WEIGHTED)
    x, y, u = recorded_points(recordings)
    _, s, _ = weighted_line(x, y, u)
    rng = np.random.default_rng(3)
    sigma = s * u
    trials = y + sigma * rng.normal(size=(4000, len(y)))
    line = np.polynomial.polynomial.polyfit(x, trials.T, 1)
    off = trials - (line[0][:, None] + line[1][:, None] * x)
    worst = np.argmax(
        np.abs(np.mean((y - np.polyval(np.polyfit(x, y, 1), x)).reshape(2, 8), axis=0))
    )
    deviation = off.reshape(-1, 2, 8).mean(axis=1)[:, worst]
    assert got["n"].components[0].u == pytest.approx(deviation.std(), rel=0.1)
    changes = np.diff(trials.reshape(-1, 2, 8), axis=1)[:, 0]
    s_of_ways = [weighted_line(x[way], y[way], u[way])[1] for way in (slice(0, 8), slice(8, 16))]
    pooled = sqrt(np.mean(np.square(s_of_ways))) / s
    assert got["z"].components[0].u == pytest.approx(pooled * changes[:, 0].std(), rel=0.1)
    biggest = np.argmax(np.abs(np.diff(y.reshape(2, 8), axis=0)))
    assert got["h"].components[0].u == pytest.approx(pooled * changes[:, biggest].std(), rel=0.1)


def test_repeated_values_of_a_weighted_curve_scatter_as_at_their_x():
    """At 1 N·m the noise of a mean of 40 is 0.05/sqrt(40) V, at 128 N·m it is 128 times that."""
    torques = 2.0 ** np.arange(8)
    seeds = ((1, "up"), (2, "up"), (3, "down"), (4, "down"))
    recordings = [r for seed, way in seeds for r in noisy(torques, way=way, seed=seed)]
    results = {"zero_return": {"name": "z", "unit": "V", "between": {"way": ["up", "down"]}}}
    got = results_of(run_of((), EXACT, recordings=recordings), results, WEIGHTED)
    assert got["z"].components[0].dof == 16
    # Two of each: u = s sqrt(1/2 + 1/2); with 16 degrees of freedom s is known to 18 %.
    assert got["z"].components[0].u == pytest.approx(0.05 / sqrt(40), rel=0.4)
