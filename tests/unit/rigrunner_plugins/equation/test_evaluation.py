"""Results of measurement models, against computations by hand."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan, sqrt

import numpy as np
import pytest

from rigrunner.api.data import Recording
from rigrunner.api.errors import DataError, PluginError
from rigrunner.registry import load_registry
from rigrunner.signal.coverage import factor
from unit.rigrunner_plugins.equation.helpers_equation import findings, instrument, run_of

UNITS = {"meter.voltage": "V", "meter.current": "A", "room.temperature": "K"}
VOLT = np.array([5.007, 4.994, 5.005, 4.990, 4.999])
AMPERE = np.array([19.663, 19.639, 19.640, 19.685, 19.678]) / 1000
METERS = (
    instrument("meter.voltage", "voltage", {"gain": "0.1 %", "offset": "2 mV"}),
    instrument("meter.current", "current", "0.05 mA"),
)


def settings_of(model="R = U / I", unit="Ω", inputs=None, **more):
    inputs = inputs or {"U": "meter.voltage", "I": "meter.current"}
    return {"result": {"name": "y", "symbol": "R", "unit": unit}, "model": model,
            "inputs": inputs, **more}  # fmt: skip


def result(settings, columns=None, instruments=METERS, places=None):
    columns = columns or {"meter.voltage": VOLT, "meter.current": AMPERE}
    return findings(settings, run_of(columns, UNITS, instruments, places))


def test_type_a_has_its_correlation_and_type_b_is_of_the_register():
    """GUM 5.2.2 with the covariance of the means, and each error of the register by its slope."""
    quotient = result(settings_of()).results[0]
    covariance = np.cov([VOLT, AMPERE]) / 5
    u, i = VOLT.mean(), AMPERE.mean()
    c = np.array([1 / i, -u / i**2])
    parts = {
        "scatter of U and I, read together": sqrt(c @ covariance @ c),
        "gain of meter.voltage": u / i * 0.001 / sqrt(3),
        "offset of meter.voltage": 0.002 / sqrt(3) / i,
        "reading of meter.current": 0.00005 / sqrt(3) * u / i**2,
    }
    assert {line.name: line.u for line in quotient.components} == pytest.approx(parts, rel=1e-9)
    assert quotient.estimate.value == pytest.approx(u / i, rel=1e-12)
    assert quotient.estimate.u == pytest.approx(sqrt(sum(x**2 for x in parts.values())), rel=1e-9)
    scatter = parts["scatter of U and I, read together"]
    assert quotient.estimate.dof == pytest.approx(
        4 * (quotient.estimate.u / scatter) ** 4, rel=1e-6
    )
    assert quotient.readings == 5


def covered_differences(parts, *, count=40):
    """Return for how many runs U covers 0 V, the mean of the difference of two recorded channels.

    Both have white noise of 1 V in common; `parts` returns what is specific to one channel.
    """
    rng, inside = np.random.default_rng(3), 0
    inputs = {name: {"of": f"meter.{name}", "instrument": False} for name in "ab"}
    difference = settings_of("y = a - b", "V", inputs)
    difference["result"]["symbol"] = "y"
    analysis = load_registry().make("analysis", "equation", difference)
    for _ in range(count):
        common = rng.normal(size=1000)
        channels = {name: common + parts(rng) for name in ("meter.a", "meter.b")}
        recordings = tuple(
            Recording(
                f"{at}", 100.0, f"2026-01-05T10:00:{10 * at:02d}+00:00", {},
                {name: samples[200 * at : 200 * (at + 1)] for name, samples in channels.items()},
                dict.fromkeys(channels, "V"),
            )
            for at in range(5)
        )  # fmt: skip
        run = replace(run_of({"meter.a": [0.0]}, {}), measurements=(), recordings=recordings)
        (result,) = analysis(run).results
        inside += abs(result.estimate.value) <= factor(result.estimate) * result.estimate.u
    return inside


def test_common_noise_does_not_hide_recording_levels_of_each_channel():
    """Levels of 0.3 V scatter each mean; the samples, correlated to 0.94, do not show it."""
    assert covered_differences(lambda rng: np.repeat(0.3 * rng.normal(size=5), 200)) >= 36  # 27


def test_without_levels_recorded_channels_correlate_as_their_samples():
    assert covered_differences(lambda rng: 0.3 * rng.normal(size=1000)) >= 36


def test_scatter_equals_that_of_the_result_computed_per_reading():
    """H.2.4: to first order both ways agree, as the correlation is the observed one."""
    quotient = result(settings_of(), instruments=()).results[0]
    scatter = next(line for line in quotient.components if line.name.startswith("scatter"))
    ratios = VOLT / AMPERE
    assert scatter.u == pytest.approx(ratios.std(ddof=1) / sqrt(5), rel=1e-3)
    assert np.isnan(quotient.estimate.u)  # the instruments are unknown


@pytest.mark.parametrize(
    ("limits", "k"),
    [
        ({"a": 1.0}, 0.95 * sqrt(3)),
        ({"a": 1.0, "b": 1.0}, sqrt(6) * (1 - sqrt(0.05))),  # the sum is a triangle
        ({"a": 1.0, "b": 0.05}, 0.95 * sqrt(3)),
    ],
)
def test_k_depends_on_the_shape_of_rectangular_inputs(limits, k):
    constants = {name: {"value": 1.0, "limits": width} for name, width in limits.items()}
    settings = settings_of(
        f"R = x + {' + '.join(limits)}", "1", {"x": {"of": "meter.ratio", "instrument": False}},
        constants=constants,
    )  # fmt: skip
    run = run_of({"meter.ratio": [1.0]}, {"meter.ratio": "1"})
    estimate = findings(settings, run).results[0].estimate
    assert estimate.u == pytest.approx(sqrt(sum(a**2 / 3 for a in limits.values())))
    assert factor(estimate) == pytest.approx(k, rel=0.01)


@pytest.mark.parametrize("r", [1.0, -1.0])
@pytest.mark.parametrize("limits", [(1.0, 0.5, 0.01), (1.0, 0.5, 1.0)])
@pytest.mark.parametrize("model", ["a + b + c", "a * b + c"])
def test_fully_correlated_rectangles_are_one_rectangle(model, limits, r):
    """k is compared with a million draws, in which b follows a."""
    constants = {
        name: {"value": value, "limits": limit}
        for name, value, limit in zip("abc", (70.0, 90.0, 1.0), limits, strict=True)
    }
    findings_ = of_constants(
        f"({model}) * x", constants, correlations=[{"between": ["a", "b"], "r": r}]
    )
    estimate = findings_.results[0].estimate
    a, b, c = limits
    one, other = np.random.default_rng(5).uniform(-1, 1, (2, 1_000_000))
    drawn = {"a": 70 + a * one, "b": 90 + r * b * one, "c": 1 + c * other}
    y = np.sort((drawn["a"] + drawn["b"] if "+ b" in model else drawn["a"] * drawn["b"])
                + drawn["c"])  # fmt: skip
    width = np.quantile(np.abs(y - estimate.value), 0.95)
    assert estimate.u == pytest.approx(y.std(), rel=2e-3)
    assert factor(estimate) * estimate.u == pytest.approx(width, rel=0.012)
    (table,) = (table for table in findings_.tables if table.title.startswith("GUM and"))
    low, high = (table.rows[0][table.columns.index(f"{bound} (Monte Carlo)")] for bound in
                 ("low", "high"))  # fmt: skip
    assert (high - low) / 2 == pytest.approx(width, rel=0.012)


def test_estimate_of_an_input_has_the_digits_of_its_u():
    """GUM 7.2.6, with one digit more: 10000001.2433 Hz with u = 0.353 Hz."""
    hertz = np.array([10000001.23, 10000001.31, 10000001.19])
    settings = settings_of("R = f / f_0", "1", {"f": {"of": "meter.frequency", "instrument": "no"}},
                           constants={"f_0": "10 MHz"})  # fmt: skip
    findings_ = findings(settings, run_of({"meter.frequency": hertz}, {"meter.frequency": "Hz"}))

    (table,) = (table for table in findings_.tables if table.title == "Inputs of the model")
    assert table.rows[0][:3] == ("f", 10000001.2433, 0.0353)


@pytest.mark.parametrize(
    ("r", "u"), [(1.0, 0.03), (-1.0, 0.01), (0.5, sqrt(0.0007)), (0.0, sqrt(0.0005))]
)
def test_correlated_pair_of_constants(r, u):
    """u² = 0.01² + 0.02² + 2 r 0.01 0.02 (GUM 5.2.2)."""
    settings = settings_of(
        "R = x + a + b", "1", {"x": {"of": "meter.ratio", "instrument": "no"}},
        constants={"a": {"value": 2.0, "u": 0.01}, "b": {"value": 3.0, "u": 0.02}},
        correlations=[{"between": ["a", "b"], "r": r}],
    )  # fmt: skip
    findings_ = findings(settings, run_of({"meter.ratio": [1.0]}, {"meter.ratio": "1"}))
    assert findings_.results[0].estimate.value == pytest.approx(6.0)
    assert findings_.results[0].estimate.u == pytest.approx(u, rel=1e-9)
    assert findings_.checks[0].ok


def test_fully_correlated_gains_cancel_in_a_quotient():
    """Gains from one reference instrument have r = 1."""
    meters = (instrument("meter.voltage", "voltage", {"gain": "1 %"}),
              instrument("meter.current", "current", {"gain": "1 %"}))  # fmt: skip
    columns = {"meter.voltage": [10.0], "meter.current": [2.0]}
    independent = result(settings_of(), columns, meters).results[0].estimate
    correlated = (
        result(settings_of(correlations=[{"between": ["U", "I"], "r": 1}]), columns, meters)
        .results[0]
        .estimate
    )
    assert independent.u == pytest.approx(5 * 0.01 / sqrt(3) * sqrt(2))
    assert correlated.u == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("of_current", "inputs"),
    [
        ("0.1 % reading", {"U": "meter.voltage", "I": "meter.current"}),
        ({"gain": "1 %"}, {"U": "meter.voltage", "I": {"of": "meter.current", "instrument": "no"}}),
        ({"gain": "1 %"}, {"U": "meter.voltage", "I": "meter.voltage"}),
    ],
    ids=["unlike", "without", "same"],
)
def test_correlation_without_a_common_error_leaves_no_result(of_current, inputs):
    """Otherwise u would silently be that of independent instruments."""
    meters = (instrument("meter.voltage", "voltage", {"gain": "1 %"}),
              instrument("meter.current", "current", of_current))  # fmt: skip
    unit = "1" if inputs["I"] == "meter.voltage" else "Ω"
    columns = {"meter.voltage": [10.0], "meter.current": [2.0]}
    correlations = [{"between": ["U", "I"], "r": 0.9}]
    findings_ = result(
        settings_of("U / I", unit, inputs, correlations=correlations), columns, meters
    )
    assert not findings_.results
    assert "U and I are to be correlated" in findings_.missing[0].why
    assert "gain of meter.voltage" in findings_.missing[0].why


def test_ambiguous_percentage_of_a_number_is_refused():
    """'10 %' of the number 3 counts as 0.1, as in stored runs; a person may mean 0.3."""
    inputs = {"q": {"of": "meter.ratio", "instrument": "no"}}

    def objections(**constant):
        settings = settings_of("c*q", "1", inputs, constants={"c": constant})
        return list(load_registry().objections("equation", settings, {"meter.ratio": "1"}))

    (objection,) = objections(value=3, limits="10 %")
    assert objection[0] == ("constants", "c", "limits")
    assert objection[1] == "'10 %' of the number 3: a share of it, or 0.1?"
    assert objection[2] == "write 0.3 or 0.1"
    for case in ({"value": 3, "u": 0.1}, {"value": "30 %", "u": "1 %"}, {"value": 1, "u": "1 %"}):
        assert not objections(**case)


def test_check_of_trials_names_the_places_where_it_failed():
    """1/x at 0.01 ± 0.01 has no valid interval from its slope; at 1 and 2 it has."""
    columns = {"meter.ratio": [1.0, 0.01, 2.0, 0.012]}
    meter = instrument("meter.ratio", "ratio", {"overall": "0.01 1"})
    run = run_of(columns, {"meter.ratio": "1"}, [meter], [1.0, 2.0, 3.0, 4.0])
    settings = settings_of("1 / x", "1", {"x": "meter.ratio"}, per=["load.current"])
    (check,) = findings(settings, run).checks
    assert not check.ok
    assert [(name, str(at["load.current"])) for name, at in check.of] == [
        ("y", "2 A"),
        ("y", "4 A"),
    ]
    assert check.text.endswith("; it fails too at load.current = 4 A")
    linear_run = run_of({"meter.ratio": [1.0]}, {"meter.ratio": "1"}, [meter])
    (passed,) = findings(settings, linear_run).checks
    assert passed.ok
    assert not passed.of


def test_failed_trial_among_too_many_places_is_about_all_of_them():
    """Trials are made at 30 of 31 places: if one fails, the remaining one may fail too."""
    places = [float(i) for i in range(1, 32)]
    meter = instrument("meter.ratio", "ratio", {"overall": "0.01 1"})
    run = run_of({"meter.ratio": [1.0] * 30 + [0.01]}, {"meter.ratio": "1"}, [meter], places)
    (check,) = findings(
        settings_of("1 / x", "1", {"x": "meter.ratio"}, per=["load.current"]), run
    ).checks
    assert not check.ok
    assert len(check.of) == 31


def test_channel_that_enters_twice_has_one_gain():
    columns = {"meter.voltage": [10.0], "meter.current": [2.0]}
    settings = settings_of("R = U/V + 0*I/number(1, A)", "1",
                    {"U": "meter.voltage", "V": "meter.voltage", "I": "meter.current"})  # fmt: skip
    assert result(settings, columns).results[0].estimate.u == pytest.approx(0.0, abs=1e-9)


def test_expanded_uncertainty_and_degrees_of_freedom_of_a_constant():
    settings = settings_of(
        "R = U / S", "A", {"U": {"of": "meter.voltage", "instrument": "no", "scatter": "2 mV",
                                 "degrees_of_freedom": 24}},
        constants={"S": {"value": "0.1 Ω", "U": "±1 %", "k": 2, "degrees_of_freedom": 8}},
    )  # fmt: skip
    quotient = result(settings, {"meter.voltage": VOLT}).results[0]
    y = VOLT.mean() / 0.1
    parts = y * 0.005, 0.002 / sqrt(5) / 0.1
    u = sqrt(parts[0] ** 2 + parts[1] ** 2)
    assert quotient.estimate.u == pytest.approx(u)
    assert quotient.estimate.dof == pytest.approx(u**4 / (parts[0] ** 4 / 8 + parts[1] ** 4 / 24))


def test_second_order_counts_in_a_curved_model_with_a_note():
    """y = x² at 0: to first order u is 0, and var(x²) = 2 u⁴ for a normal x."""
    constants = {"x0": {"value": "0 V", "u": "3 mV"}}
    settings = settings_of("R = (x0 + U - U)^2", "V^2", {"U": "meter.voltage"}, constants=constants)
    findings_ = result(settings, {"meter.voltage": [1.0]}, (instrument("meter.voltage", "voltage",
                                                                   "1 mV"),))  # fmt: skip
    assert findings_.results[0].estimate.u == pytest.approx(sqrt(2) * 9e-6, rel=1e-6)
    assert "the curvature of the model counts" in findings_.notes[0]
    without = result(settings | {"second_order": "no"}, {"meter.voltage": [1.0]}).results[0]
    assert without.estimate.u == 0


def test_second_order_of_rectangles_and_cubes():
    """Second order has over 90 % of var(x³) that first order lacks, x a rectangle about 2."""
    a, m = 0.3, 2.0
    constants = {"x": {"value": m, "limits": a}}
    inputs = {"q": {"of": "meter.ratio", "instrument": "no"}}
    settings = settings_of("R = x^3 + 0*q", "1", inputs, constants=constants, second_order="yes")
    result = findings(settings, run_of({"meter.ratio": [1.0]}, {"meter.ratio": "1"})).results[0]
    grid = np.linspace(m - a, m + a, 200_001)
    weights = np.full(len(grid), 1.0)
    weights[[0, -1]] = 0.5
    mean = np.average(grid**3, weights=weights)
    var = np.average((grid**3 - mean) ** 2, weights=weights)
    first_order = (3 * m**2 * a) ** 2 / 3
    assert abs(result.estimate.u**2 - var) < 0.1 * abs(first_order - var)


def test_interval_invalidated_by_curvature_gives_no_verdict():
    """y = 1/x with x = 1 +/- 0.3 of a normal distribution: heavy to one side."""
    constants = {"x": {"value": 1.0, "u": 0.25}}
    inputs = {"q": {"of": "meter.ratio", "instrument": "no"}}
    settings = settings_of("R = 1/x + 0*q", "1", inputs, constants=constants, second_order="no")
    findings_ = findings(settings, run_of({"meter.ratio": [1.0]}, {"meter.ratio": "1"}))
    (check,) = findings_.checks
    assert not check.ok
    assert check.decisive
    assert check.value > 0.02


def test_value_without_errors_has_u_of_zero():
    """One reading has no scatter, and an exact instrument has no error."""
    inputs = {"U": {"of": "meter.voltage", "instrument": "no"}}
    doubled = result(settings_of("R = 2 * U", "V", inputs), {"meter.voltage": [1.5]}).results[0]
    assert (doubled.estimate.value, doubled.estimate.u, doubled.components) == (3.0, 0.0, ())


def test_set_point_as_input_is_exact_without_a_register_entry():
    """If a drive, such as a chamber, is not read back, its set-point is the value."""
    settings = settings_of(inputs={"U": "meter.voltage", "I": "load.current"}, per="load.current")
    columns = {"meter.voltage": [2.0, 2.0, 6.0, 6.0]}
    volt = instrument("meter.voltage", "voltage", "0.1 V")
    for entry, accuracy in (((), 0.0), ((instrument("load.current", "current", "0.02 A"),), 0.02)):
        run = run_of(columns, {"meter.voltage": "V"}, (volt, *entry), [1.0, 1.0, 3.0, 3.0])
        findings_ = findings(settings, run)
        assert [result.estimate.value for result in findings_.results] == [2.0, 2.0]
        for result_, ampere in zip(findings_.results, (1.0, 3.0), strict=True):
            u = sqrt((0.1 / ampere) ** 2 + (2.0 / ampere * accuracy) ** 2) / sqrt(3)
            assert result_.estimate.u == pytest.approx(u, rel=1e-9)
        exact = "load.current counts as exact: the register has no entry for it."
        assert (exact in findings_.notes) == (not entry)


def test_several_results_and_places_share_their_inputs():
    settings = {
        "results": [{"name": "resistance", "symbol": "R", "unit": "Ω"},
                    {"name": "power", "symbol": "P", "unit": "mW"}],
        "model": "R = U / I\nP = R * I^2",
        "inputs": {"U": "meter.voltage", "I": "meter.current"}, "per": "load.current",
    }  # fmt: skip
    columns = {"meter.voltage": [1.0, 1.0, 4.0, 4.0], "meter.current": [0.5, 0.5, 0.5, 0.5]}
    findings_ = result(settings, columns, places=[1.0, 1.0, 2.0, 2.0])
    assert [(result.name, result.place) for result in findings_.results] == [
        ("resistance", "load.current = 1 A"), ("resistance", "load.current = 2 A"),
        ("power", "load.current = 1 A"), ("power", "load.current = 2 A"),
    ]  # fmt: skip
    values = [result.estimate.value for result in findings_.results]
    assert values == pytest.approx([2.0, 8.0, 500.0, 2000.0])


def test_temperatures_in_celsius_are_converted():
    """A difference of 10 K over one of 2 K; and a mean temperature, stated in °C."""
    room = (instrument("room.temperature", "temperature", "0.1 K"),)
    columns = {"room.temperature": [303.15]}
    ratio = settings_of("R = (t - t0)/d", "1", {"t": "room.temperature"},
                 constants={"t0": "20 °C", "d": "2 K"})  # fmt: skip
    assert result(ratio, columns, room).results[0].estimate.value == pytest.approx(5.0)
    mean = settings_of(
        "R = mean(t, t0)", "°C", {"t": "room.temperature"}, constants={"t0": "20 °C"}
    )
    estimate = result(mean, columns, room).results[0].estimate
    assert estimate.value == pytest.approx(25.0)
    assert estimate.u == pytest.approx(0.05 / sqrt(3))


@pytest.mark.parametrize(
    ("model", "columns", "message"),
    [
        ("R = U / I", {"meter.voltage": [1.0]}, "neither measured"),
        ("R = U / I", {"meter.voltage": [nan], "meter.current": [1.0]}, "not a finite number"),
    ],
)
def test_missing_or_nan_input_is_refused(model, columns, message):
    settings = settings_of(model)
    run = run_of(columns, UNITS, METERS)
    with pytest.raises(DataError, match=message):
        findings(settings, run)


PLACES = [0.0, 1.0, 2.0]


@pytest.mark.parametrize(
    ("model", "part"),
    [("R = U / I", "U / I"), ("R = U / (number(1, A) * exp(I / I))", "I / I"),
     ("R = U / number(1, A) * sqrt(I / number(1, A) - 0.5)", "sqrt(I / 1 A - 0.5)")],
    ids=["divisor", "within", "root"],
)  # fmt: skip
def test_undefined_model_at_one_place_keeps_results_of_other_places(model, part):
    columns = {"meter.voltage": [0.001, 5.0, 10.0], "meter.current": [0.0, 1.0, 2.0]}
    findings_ = result(settings_of(model, per="load.current"), columns, places=PLACES)
    assert [result.place for result in findings_.results] == [
        "load.current = 1 A",
        "load.current = 2 A",
    ]
    alone = {name: values[1:] for name, values in columns.items()}
    others = result(settings_of(model, per="load.current"), alone, places=PLACES[1:])
    assert [result.components for result in findings_.results] == [
        result.components for result in others.results
    ]
    (missing,) = findings_.missing
    assert missing.sentence == (
        f"There is no value of y at load.current = 0 A: '{part}' gives no finite number."
    )
    cells = [cell for table in findings_.tables for row in table.rows for cell in row]
    assert all(cell == cell for cell in cells)  # noqa: PLR0124  (no nan)


def test_one_result_of_a_model_can_be_missing():
    settings = settings_of() | {
        "results": [{"name": "R", "unit": "Ω"}, {"name": "P", "unit": "mW"}],
        "model": "R = U / I\nP = U * I",
    }
    del settings["result"]
    findings_ = result(settings, {"meter.voltage": [1.0], "meter.current": [0.0]})
    assert [result.name for result in findings_.results] == ["P"]
    (missing,) = findings_.missing
    assert missing.sentence == "There is no value of R: 'U / I' gives no finite number."


def test_trials_without_a_value_fail_the_check_and_show_no_nan():
    """The root has a value where |a| < 0.01, in 10 % of the trials."""
    constants = {"a": {"value": 0.0, "limits": 0.1}, "b": {"value": 1.0, "limits": 0.1}}
    findings_ = of_constants("(sqrt(0.0001 - a^2) + b) * x", constants)
    (check,) = findings_.checks
    assert check.decisive
    assert not check.ok
    assert not [table for table in findings_.tables if table.title.startswith("GUM and")]


def test_degrees_of_freedom_are_infinite_without_scatter():
    findings_ = result(settings_of(), {"meter.voltage": [10.0], "meter.current": [2.0]})
    assert findings_.results[0].estimate.dof == inf
    assert "shows no scatter" in findings_.notes[0]


OFF = {"x": {"of": "meter.ratio", "instrument": False}}


def of_constants(model, constants, **more):
    run = run_of({"meter.ratio": [1.0]}, {"meter.ratio": "1"})
    return findings(settings_of(model, "1", OFF, constants=constants, **more), run)


@pytest.mark.parametrize(
    ("model", "a"), [("sqrt(a) * x", 0.0), ("asin(a) * x", 1.0), ("(a - 1)^0.5 * x", 1.0)]
)
def test_model_without_a_slope_has_no_value_and_names_the_input(model, a):
    """The derivative of a root at 0 and of asin at 1 is infinite."""
    findings_ = of_constants(model, {"a": {"value": a, "limits": 0.1}})
    (missing,) = findings_.missing
    assert not findings_.results
    assert missing.sentence.startswith(
        "There is no value of y: the model has no slope over a, and so no uncertainty"
    )


@pytest.mark.parametrize(
    ("model", "a", "u"),
    [("abs(a) * x", 0.0, 0.1 / sqrt(12)), ("tan(a) * x", np.pi / 2, 1e9)],
    ids=["kink", "pole"],
)
def test_uncertainty_not_described_by_the_model_terms_decides_nothing(model, a, u):
    """|a| of a rectangle of ±0.1 is one from 0 to 0.1; a tangent at its pole has no uncertainty."""
    findings_ = of_constants(model, {"a": {"value": a, "limits": 0.1}})
    (check,) = findings_.checks
    assert check.decisive
    assert not check.ok
    assert findings_.results[0].estimate.u > 3 * u
    if a == 0.0:
        assert f"and {u:.2g} of the trials" in check.text


@pytest.mark.parametrize(
    "r", [(-0.9, -0.9, -0.9), (1.0, 0.5, -0.5), (1.0, 1.0, -1.0)], ids=["all", "pair", "signs"]
)
def test_impossible_correlations_are_refused(r):
    """Of three quantities these matrices have a negative eigenvalue."""
    matrix = np.array([[1, r[0], r[1]], [r[0], 1, r[2]], [r[1], r[2], 1]])
    assert np.linalg.eigvalsh(matrix)[0] < -0.1
    pairs = [["a", "b"], ["a", "c"], ["b", "c"]]
    constants = {name: {"value": 1.0, "limits": 0.1} for name in "abc"}
    correlations = [
        {"between": pair, "r": coefficient} for pair, coefficient in zip(pairs, r, strict=True)
    ]
    with pytest.raises(PluginError, match="cannot have these correlations together"):
        of_constants("a + b + c + x", constants, correlations=correlations)
