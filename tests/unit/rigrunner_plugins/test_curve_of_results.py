"""The analysis `curve` of results of other analyses, against trials and computations by hand."""

from __future__ import annotations

from functools import cache
from math import isnan, sqrt

import numpy as np
import pytest
from scipy.special import stdtrit

from rigrunner.analysis.named import findings_of
from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.errors import DataError
from rigrunner.procedure import AnalysisRef
from rigrunner.registry import load_registry
from rigrunner.signal.coverage import expanded
from unit.rigrunner_plugins.equation.helpers_equation import instrument, run_of

TEN_MHZ = 1e7 + np.array([0, 0.2, 0.41, 0.59, 0.8, 1.0])
UNITS = {"rig.inlet": "Pa", "rig.outlet": "Pa", "rig.flow": "m³/s"}
VALVE = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]  # A: set by hand
FLOW = np.array([0.0, 2.0, 4.1, 5.9, 8.0, 10.0]) * 1e-4
RHO, G = 998.0, 9.81
HEAD = 12 - 2e3 * FLOW - 6e6 * FLOW**2  # m
INLET = np.linspace(98e3, 93e3, len(VALVE))
COLUMNS = {"rig.inlet": INLET, "rig.outlet": INLET + RHO * G * HEAD, "rig.flow": FLOW}
PARABOLA = {"polynomial": {"degree": 2}}
LINE = {"polynomial": {"degree": 1}}
METERS = (
    instrument("rig.inlet", "pressure", {"offset": "4 mbar"}),
    instrument("rig.outlet", "pressure", {"gain": "0.4 %", "offset": "6 mbar"}),
    instrument("rig.flow", "volume flow rate", {"gain": "0.8 %"}),
)
PRECISE = (instrument("rig.outlet", "pressure", {"offset": "0.0001 Pa"}),)
FLOW_RESULT = ("readings", {"of": "rig.flow", "per": ["load.current"],
                            "result": {"name": "flow", "unit": "L/min"}})  # fmt: skip
registry = cache(load_registry)


def head(model="(p2 - p1) / (rho * g)", limits="4 kg/m³", **more):
    return ("equation", {
        "result": {"name": "head", "symbol": "H", "unit": "m"}, "model": f"H = {model}",
        "inputs": {"p1": "rig.inlet", "p2": "rig.outlet"},
        "constants": {"rho": {"value": "998 kg/m³", "limits": limits}, "g": "9.81 m/s²"},
        "per": ["load.current"],
    } | more)  # fmt: skip


def curve(results, over="flow", of="head", fit=PARABOLA, **more):
    return ("curve", {"of": of, "over": over, "fit": fit, "results": results, **more})


def findings(*analyses, columns=COLUMNS, meters=METERS):
    run = run_of(columns, UNITS, meters, VALVE)
    references = [AnalysisRef.model_validate({name: settings}) for name, settings in analyses]
    return findings_of(run, references, Scrutiny(registry()))


def results_of(*analyses, **run):
    return {result.name: result for part in findings(*analyses, **run) for result in part.results}


RATED = {"value": {"name": "rated", "at": "30 L/min", "unit": "m"}}
AT = 30e-3 / 60


def test_errors_common_to_the_points_count_as_in_trials():
    """Offsets, gains and a constant, rectangular: u equals that of fits to points moved by them."""
    rated = results_of(FLOW_RESULT, head(), curve(RATED))["rated"]
    assert rated.estimate.value == pytest.approx(12 - 2e3 * AT - 6e6 * AT**2, rel=1e-9)
    rng, count = np.random.default_rng(20261129), 20_000
    p1, p2, gain, flow, rho = rng.uniform(-1, 1, (5, count)) * np.array(
        [[400.0], [600.0], [4e-3], [8e-3], [4.0]]
    )
    moved = (
        COLUMNS["rig.outlet"] * (1 + gain[:, None]) + p2[:, None] - INLET - p1[:, None]
    ) / ((RHO + rho[:, None]) * G)  # fmt: skip
    trials = [
        np.polyval(np.polyfit(1e4 * FLOW * (1 + q), y, 2), 1e4 * AT)
        for q, y in zip(flow, moved, strict=True)
    ]
    assert rated.estimate.u == pytest.approx(np.std(trials), rel=0.03)
    lines = {line.name: line.u for line in rated.components}
    assert lines["scatter about the curve"] == pytest.approx(0, abs=1e-9)
    height = rated.estimate.value
    assert lines["rho"] == pytest.approx(height * 4 / RHO / sqrt(3), rel=1e-4)
    slope = -2e3 - 2 * 6e6 * AT
    assert lines["gain of rig.flow"] == pytest.approx(-slope * AT * 8e-3 / sqrt(3), rel=1e-3)


@pytest.mark.parametrize("accuracy", [{"gain": "0.3 %", "offset": "3 mbar"}, "5 mbar"])
def test_readings_as_a_result_give_the_same_curve_as_the_channel(accuracy):
    outlet = COLUMNS["rig.outlet"] + np.array([30, -20, 5, 40, -35, 10.0])
    results = {
        "value": {"name": "value", "at": "2.5 A", "unit": "bar"},
        "slope": {"name": "slope", "unit": "mbar/A"},
        "nonlinearity": {"name": "nonlinearity", "unit": "mbar"},
        "x_at": {"name": "x_at", "y": "1.8 bar", "unit": "A"},
        "parameters": {"c1": {"name": "c1", "unit": "bar/A"}},
    }
    of = {"fit": PARABOLA, "over": "load.current", "results": results}
    run = {"columns": COLUMNS | {"rig.outlet": outlet},
           "meters": [instrument("rig.outlet", "pressure", accuracy)]}  # fmt: skip
    pressure = ("readings", {"of": "rig.outlet", "per": ["load.current"],
                             "result": {"name": "pressure", "unit": "mbar"}})  # fmt: skip
    direct = results_of(("curve", {"of": "rig.outlet", **of}), **run)
    got = results_of(pressure, ("curve", {"of": "pressure", **of}), **run)
    for name in direct:
        expected, value = direct[name].estimate, got[name].estimate
        assert value.value == pytest.approx(expected.value, rel=1e-8), name
        assert value.u == pytest.approx(expected.u, rel=1e-4), name
        assert value.dof == pytest.approx(expected.dof, rel=1e-3), name


def test_gain_common_to_y_and_x_cancels_in_the_slope():
    twice = ("equation", {"result": {"name": "twice", "unit": "mbar"}, "model": "2 * p",
                          "inputs": {"p": "rig.outlet"}, "per": ["load.current"]})  # fmt: skip
    once = ("readings", {"of": "rig.outlet", "per": ["load.current"],
                         "result": {"name": "once", "unit": "bar"}})  # fmt: skip
    results = {"slope": {"name": "slope", "unit": "1"}}
    slope = results_of(twice, once, curve(results, of="twice", over="once", fit=LINE))["slope"]
    assert slope.estimate.value == pytest.approx(2, rel=1e-9)
    (gain,) = [line.u for line in slope.components if line.name == "gain of rig.outlet"]
    assert gain == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("accuracy", [{"gain": "0.5 %"}, "20 mA"])
@pytest.mark.parametrize(("model", "slope"), [("x", 1.0), ("k - x", -1.0)])
def test_error_of_a_set_point_that_is_also_in_y_counts_once(accuracy, model, slope):
    """For any error of x, y = x or y = k - x."""
    results = {"slope": {"name": "slope", "unit": "1"},
            "value": {"name": "at", "at": "3 A", "unit": "A"}}  # fmt: skip
    of_itself = {"result": {"name": "itself", "unit": "mA"}, "model": model,
                 "inputs": {"x": "load.current"}, "per": ["load.current"],
                 "constants": {"k": "10 A"} if "k" in model else {}}  # fmt: skip
    got = results_of(
        ("equation", of_itself),
        curve(results, of="itself", over="load.current", fit=LINE),
        meters=[instrument("load.current", "current", accuracy)],
    )
    for name, value in (("slope", slope), ("at", 3.0 if slope > 0 else 7.0)):
        assert got[name].estimate.value == pytest.approx(value, rel=1e-9)
        assert got[name].estimate.u == pytest.approx(0, abs=1e-8)
        assert len(got[name].components) == 2


def test_common_error_of_correlated_instruments_counts_with_its_greatest_effect():
    """Its budget line has no sign, so it may act differently at each point."""
    results = {"value": {"name": "at", "at": "5 A", "unit": "m"}}
    meters = [instrument(f"rig.{name}", "pressure", {"offset": "4 mbar"})
              for name in ("inlet", "outlet")]  # fmt: skip
    correlated = head(correlations=[{"between": ["p1", "p2"], "r": 0.5}])
    at = results_of(correlated, curve(results, over="load.current", fit=LINE), meters=meters)["at"]
    (line,) = [line for line in at.components if "correlated" in line.name]
    weights = np.array([5.0, 1.0]) @ np.linalg.pinv(np.vander(VALVE, 2))
    u = 400 / sqrt(3) / (RHO * G)  # of a difference with r = 0.5: as that of one of them
    assert line.u == pytest.approx(u * np.abs(weights).sum(), rel=1e-4)


def test_scatter_of_each_result_is_its_weight():
    scatter = np.array([1.0, 1.0, 9.0, 1.0, 20.0, 1.0])
    outlet = np.array([0, 2e3, 3.9e3, 6.2e3, 7.7e3, 10.3e3])
    ten = {"rig.outlet": np.concatenate([outlet - scatter, outlet + scatter] * 5)}
    pressure = ("readings", {"of": "rig.outlet", "per": ["load.current"],
                             "result": {"name": "pressure", "unit": "Pa"}})  # fmt: skip
    results = {"value": {"name": "at", "at": "2 A", "unit": "Pa"}}
    weighted = {"polynomial": {"degree": 1, "weighted": True}}
    run = run_of(ten, UNITS, [instrument("rig.outlet", "pressure", {"offset": "0 Pa"})], VALVE * 10)
    references = [
        AnalysisRef.model_validate({name: settings})
        for name, settings in (pressure, curve(results, "load.current", "pressure", weighted))
    ]
    *_, findings_ = findings_of(run, references, Scrutiny(registry()))
    expected = np.polyval(np.polyfit(VALVE, outlet, 1, w=1 / scatter), 2)
    assert findings_.results[0].estimate.value == pytest.approx(expected, rel=1e-9)


def test_error_that_may_differ_at_each_point_counts_with_its_greatest_effect():
    meters = [instrument("rig.outlet", "pressure", "5 mbar")]
    results = {"value": {"name": "at", "at": "5 A", "unit": "bar"}}
    pressure = ("readings", {"of": "rig.outlet", "per": ["load.current"],
                             "result": {"name": "pressure", "unit": "bar"}})  # fmt: skip
    at = results_of(
        pressure, curve(results, of="pressure", over="load.current", fit=LINE), meters=meters
    )
    design = np.vander(VALVE, 2)
    weights = np.array([5.0, 1.0]) @ np.linalg.pinv(design)
    u = 500 / sqrt(3) * np.abs(weights).sum() / 1e5
    (line,) = [line for line in at["at"].components if "rig.outlet" in line.name]
    assert line.u == pytest.approx(u, rel=1e-6)
    assert not line.shared


def test_point_without_a_value_is_left_out_with_a_note():
    columns = COLUMNS | {"rig.outlet": np.where(np.arange(6) == 2, INLET, COLUMNS["rig.outlet"])}
    root = head("sqrt((p2 - p1) / (rho * g)) * number(1, m) / sqrt(number(1, m))")
    settings = curve({"value": {"name": "at", "at": "2.5 A", "unit": "m"}}, over="load.current")
    *_, findings_ = findings(root, settings, columns=columns)
    assert [result.readings for result in findings_.results] == [5]
    text = "head: there is no point at load.current = 2 A, where a value is missing."
    assert text in findings_.notes


def test_curve_without_values_names_the_results_that_lack_them():
    settings = curve(RATED, where={"load.current": "7 A"})
    with pytest.raises(DataError, match=r"no value of head and flow at load\.current = 7 A"):
        findings(FLOW_RESULT, head(), settings)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"statistic": "range"}, "'statistic' and 'table' belong to a channel; head is none"),
        ({"results": {"x_at": {"name": "a", "y": "3 m", "readings": 2, "unit": "L/min"}}},
         "'x_at' of a result, such as head, needs a fixed 'y' alone"),
        ({"of": "rig head"}, "got 'rig head', expected a channel, such as"),
    ],
)  # fmt: skip
def test_settings_that_belong_to_a_channel_are_refused(more, message):
    (name, settings) = curve(RATED)
    with pytest.raises(Exception, match="curve") as raised:
        registry().requires("analysis", name, settings | more)
    assert message in str(raised.value)


def test_without_register_entry_u_is_unknown():
    pressure = ("readings", {"of": "rig.outlet", "per": ["load.current"],
                             "result": {"name": "pressure", "unit": "bar"}})  # fmt: skip
    results = {"value": {"name": "at", "at": "5 A", "unit": "bar"}}
    at = results_of(
        pressure, curve(results, of="pressure", over="load.current", fit=LINE), meters=[]
    )["at"]
    assert isnan(at.estimate.u)
    assert at.estimate.value == pytest.approx(np.polyval(np.polyfit(
        VALVE, COLUMNS["rig.outlet"], 1), 5) / 1e5, rel=1e-9)  # fmt: skip


def test_scatter_of_a_result_used_by_all_points_moves_the_curve():
    """A zero of three readings adds s/sqrt(3) with dof 2 to the value, and nothing to the slope."""
    zero, load = np.array([100.0, 300.0, 500.0]), np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    off = np.array([1.0, -2.0, 1.5, -1.0, 1.2])
    columns = {"rig.outlet": np.concatenate([zero, 300 + 1e4 * load + off])}
    run = run_of(columns, UNITS, PRECISE, [0.0, 0.0, 0.0, *load])
    at_rest = ("readings", {"of": "rig.outlet", "where": {"load.current": "0 A"},
                            "result": {"name": "zero", "unit": "Pa"}})  # fmt: skip
    net = ("equation", {"result": {"name": "net", "unit": "Pa"}, "model": "p - z",
                        "inputs": {"p": "rig.outlet", "z": "zero"},
                        "per": ["load.current"]})  # fmt: skip
    results = {"value": {"name": "value", "at": "3 A", "unit": "Pa"},
               "slope": {"name": "slope", "unit": "Pa/A"}}  # fmt: skip
    fitted = curve(results, over="load.current", of="net", fit=LINE)
    references = [
        AnalysisRef.model_validate({name: settings}) for name, settings in (at_rest, net, fitted)
    ]
    findings_ = findings_of(run, references, Scrutiny(registry()))
    got = {result.name: result for part in findings_ for result in part.results}
    (of_zero,) = (line for line in got["value"].components if "of zero" in line.name)
    assert of_zero.u == pytest.approx(np.std(zero, ddof=1) / sqrt(3), rel=1e-6)
    assert of_zero.dof == pytest.approx(2)
    (of_slope,) = (line for line in got["slope"].components if "of zero" in line.name)
    assert of_slope.u == pytest.approx(0, abs=1e-6)


def test_error_in_one_figure_stays_independent_per_point_through_an_equation():
    """Twice the result of the readings and twice the readings have the same slope."""
    run = {"columns": COLUMNS, "meters": [instrument("rig.outlet", "pressure", "5 mbar")]}
    pressure = ("readings", {"of": "rig.outlet", "per": ["load.current"],
                             "result": {"name": "pressure", "unit": "mbar"}})  # fmt: skip
    results = {"slope": {"name": "slope", "unit": "mbar/A"}}

    def twice(of):
        return ("equation", {"result": {"name": "twice", "unit": "mbar"}, "model": "2 * p",
                             "inputs": {"p": of}, "per": ["load.current"]})  # fmt: skip

    fitted = curve(results, over="load.current", of="twice", fit=LINE)
    slope = results_of(pressure, twice("pressure"), fitted, **run)["slope"]
    (line,) = (line for line in slope.components if line.name.startswith("reading"))
    x = np.array(VALVE) - np.mean(VALVE)
    assert line.u == pytest.approx(2 * 5 / sqrt(3) * np.abs(x / (x @ x)).sum(), rel=1e-6)
    direct = results_of(twice("rig.outlet"), fitted, **run)["slope"]
    assert slope.estimate.u == pytest.approx(direct.estimate.u, rel=1e-6)


def test_constants_of_equal_name_and_value_in_two_units_are_two_errors():
    """A zero of y in mbar and a zero of x in A, both called z, are not one error."""
    y = ("equation", {"result": {"name": "y", "unit": "mbar"}, "model": "p - z",
                      "inputs": {"p": "rig.outlet"}, "per": ["load.current"],
                      "constants": {"z": {"value": "0 mbar", "u": "50 mbar"}}})  # fmt: skip
    x = ("equation", {"result": {"name": "x", "unit": "A"}, "model": "i - z",
                      "inputs": {"i": "load.current"}, "per": ["load.current"],
                      "constants": {"z": {"value": "0 A", "u": "0.2 A"}}})  # fmt: skip
    columns = {"rig.outlet": 1e5 + 1e4 * np.array(VALVE)}  # 100 mbar/A
    results = {"value": {"name": "value", "at": "2.5 A", "unit": "mbar"}}
    got = results_of(
        y, x, curve(results, of="y", over="x", fit=LINE), columns=columns, meters=PRECISE
    )["value"]
    assert got.estimate.u == pytest.approx(sqrt(50**2 + (100 * 0.2) ** 2), rel=1e-5)


def test_u_of_curve_parameters_in_an_equation_is_conservative():
    """x at y = 0 of a line: by the covariance 0.0568 A, as independent errors 0.0428 A."""
    off = np.array([6122.6, -7668.0, 1254.7, -1703.3, -1357.9, -646.6])
    columns = {"rig.outlet": 2e5 + 1e5 * np.array(VALVE) + off}
    results = {
        "parameters": {"c0": {"name": "c0", "unit": "Pa"}, "c1": {"name": "c1", "unit": "Pa/A"}}
    }
    line = curve(results, of="rig.outlet", over="load.current", fit=LINE)
    root = ("equation", {"result": {"name": "root", "unit": "A"}, "model": "-a / b",
                         "inputs": {"a": "c0", "b": "c1"}})  # fmt: skip
    got = results_of(line, root, columns=columns, meters=PRECISE)
    (c1, c0), covariance = np.polyfit(VALVE, columns["rig.outlet"], 1, cov="unscaled")
    residuals = columns["rig.outlet"] - c0 - c1 * np.array(VALVE)
    slopes = np.array([c0 / c1**2, -1 / c1])
    u = sqrt(slopes @ covariance @ slopes * (residuals @ residuals) / 4)
    u_parameters = sqrt((residuals @ residuals) / 4) * np.sqrt(np.diag(covariance))
    assert got["root"].estimate.value == pytest.approx(-c0 / c1)
    assert got["root"].estimate.u == pytest.approx(np.abs(slopes) @ u_parameters, rel=1e-6)
    assert got["root"].estimate.u >= u > np.linalg.norm(slopes * u_parameters)
    assert got["root"].estimate.dof == pytest.approx(4)
    twice = ("equation", {"result": {"name": "twice", "unit": "A"}, "model": "r + a / b",
                          "inputs": {"r": "root", "a": "c0", "b": "c1"}})  # fmt: skip
    again = results_of(line, root, twice, columns=columns, meters=PRECISE)["twice"]
    assert again.estimate.u == pytest.approx(2 * got["root"].estimate.u, rel=1e-6)  # the greatest


def test_scatter_of_three_readings_keeps_its_degrees_of_freedom_between_points():
    """An interpolation passes through a point, and has its U there, with k = 4.3."""
    outlet = np.array([0, 2e3, 3.9e3, 6.2e3, 7.7e3, 10.3e3])
    thrice = {"rig.outlet": np.concatenate([outlet - 30, outlet + 40, outlet - 10])}
    pressure = ("readings", {"of": "rig.outlet", "per": ["load.current"],
                             "result": {"name": "pressure", "unit": "Pa"}})  # fmt: skip
    results = {"value": {"name": "at", "at": "2 A", "unit": "Pa"}}
    run = run_of(thrice, UNITS, PRECISE, VALVE * 3)

    def findings_of_fit(fit):
        analyses = pressure, curve(results, over="load.current", of="pressure", fit=fit)
        references = [AnalysisRef.model_validate({name: settings}) for name, settings in analyses]
        return findings_of(run, references, Scrutiny(registry()))

    readings, at = findings_of_fit({"pchip": {}})
    (point,) = (result for result in readings.results if result.place == "load.current = 2 A")
    assert at.results[0].estimate.value == pytest.approx(point.estimate.value)
    u = np.std([-30, 40, -10], ddof=1) / sqrt(3)
    assert expanded(at.results[0].estimate) == pytest.approx(stdtrit(2, 0.975) * u, rel=1e-4)
    with pytest.raises(DataError, match="is from 3 readings, and needs 10"):
        findings_of_fit({"polynomial": {"degree": 1, "weighted": True}})


def test_per_point_errors_do_not_cancel_between_curve_values():
    """Each value has its greatest effect; in a difference they are independent, as in readings."""
    run = {
        "columns": {"rig.outlet": np.full(6, 1e5)},
        "meters": [instrument("rig.outlet", "pressure", "5 mbar")],
    }
    per = {"per": ["load.current"]}
    results = {"value": [{"name": f"at_{x}", "at": f"{x} A", "unit": "mbar"} for x in (2, 5)]}
    got = results_of(
        ("readings", {"of": "rig.outlet", "result": {"name": "pressure", "unit": "mbar"}, **per}),
        ("equation", {"result": {"name": "twice", "unit": "mbar"}, "model": "2 * p",
                      "inputs": {"p": "pressure"}, **per}),
        curve(results, over="load.current", of="twice", fit=LINE),
        ("equation", {"result": {"name": "rise", "unit": "mbar"}, "model": "b - a",
                      "inputs": {"a": "at_2", "b": "at_5"}}), **run,
    )  # fmt: skip
    hat = np.array([[2, 1], [5, 1]]) @ np.linalg.pinv(np.vander(VALVE, 2))
    of_value = 2 * 5 / sqrt(3) * np.abs(hat).sum(axis=1)
    lines = [line.u for line in got["rise"].components if line.name.startswith("reading")]
    assert np.linalg.norm(lines) == pytest.approx(np.linalg.norm(of_value), rel=1e-5)


@pytest.mark.parametrize("of", ["rig.outlet", "frequency"])
@pytest.mark.parametrize("error", ["offset", "drift"])
def test_errors_of_nearly_constant_y_are_not_lost_in_rounding(of, error):
    """10 MHz within 1 Hz: 0.5 Hz of y, 0.3 A and 2 % of x, against a fit of y - 10 MHz."""
    meters = (
        instrument("rig.outlet", "frequency", {error: "0.5 Hz"}),
        instrument("load.current", "current", {"offset": "0.3 A", "gain": "2 %"}),
    )
    run = run_of({"rig.outlet": TEN_MHZ}, {"rig.outlet": "Hz"}, meters, VALVE)
    results = {"value": {"name": "value", "at": "2.2 A", "unit": "Hz"}}
    analyses = [
        ("readings", {"of": "rig.outlet", "per": ["load.current"],
                      "result": {"name": "frequency", "unit": "Hz"}}),
        curve(results, over="load.current", of=of, fit=LINE),
    ]  # fmt: skip
    references = [AnalysisRef.model_validate({name: settings}) for name, settings in analyses]
    *_, findings_ = findings_of(run, references, Scrutiny(registry()))
    lines = {line.name: line.u for line in findings_.results[0].components}
    design = np.vander(VALVE, 2)
    hat, (slope, _) = (
        np.array([2.2, 1]) @ np.linalg.pinv(design),
        np.polyfit(VALVE, TEN_MHZ - 1e7, 1),
    )
    expected = {
        f"{error} of rig.outlet": 0.5
        * (abs(hat.sum()) if error == "offset" else np.abs(hat).sum()),
        "offset of load.current": 0.3 * slope,
        "gain of load.current": 0.02 * 2.2 * slope,
    }
    for name, u in expected.items():
        (line_u,) = (line_u for line, line_u in lines.items() if line.startswith(name))
        assert line_u == pytest.approx(u / sqrt(3), rel=2e-3), name


def test_interpolation_includes_the_scatter_of_x():
    """y = 200 x exactly, each x of ten readings: u of y is 200 u(x), and there are no residuals."""
    flow = np.concatenate([FLOW + off for off in np.tile([1e-6, -1e-6], 5)])
    outlet = np.tile(1e5 + 2e8 * FLOW, 10) + np.repeat(np.tile([1, -1], 5), len(FLOW))
    per = {"per": ["load.current"]}
    pressure = ("readings", {"of": "rig.outlet", "result": {"name": "p", "unit": "Pa"}, **per})
    results = {"value": {"name": "at", "at": f"{FLOW[2]} m³/s", "unit": "Pa"}}
    meters = [*PRECISE, instrument("rig.flow", "volume flow rate", {"offset": "0.000001 L/min"})]
    run = run_of({"rig.flow": flow, "rig.outlet": outlet}, UNITS, meters, VALVE * 10)
    analyses = [pressure, FLOW_RESULT, curve(results, of="p", fit={"pchip": {}})]
    references = [AnalysisRef.model_validate({name: settings}) for name, settings in analyses]
    *_, findings_ = findings_of(run, references, Scrutiny(registry()))
    of_mean = np.std([1, -1] * 5, ddof=1) / sqrt(10)
    expected = np.hypot(of_mean, 2e8 * 1e-6 * of_mean)
    assert findings_.results[0].estimate.u == pytest.approx(expected, rel=1e-3)
