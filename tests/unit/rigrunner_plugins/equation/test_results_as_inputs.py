"""Equations of results of other analyses: value, u and correlation, against GTC."""

from __future__ import annotations

from functools import cache
from math import sqrt

import GTC
import numpy as np
import pytest

from rigrunner.analysis.named import findings_of
from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.analysis.verdict.limited_values import mean_of
from rigrunner.api.errors import DataError
from rigrunner.procedure import AnalysisRef
from rigrunner.registry import load_registry
from unit.rigrunner_plugins.equation.helpers_equation import instrument, run_of

UNITS = {"meter.voltage": "V", "meter.current": "A"}
VOLT = np.array([5.007, 4.994, 5.005, 4.990, 2.504, 2.497, 2.501, 2.506])
AMPERE = np.array([19.66, 19.64, 19.64, 19.68, 9.81, 9.83, 9.84, 9.80]) / 1000
PLACES = [2.0] * 4 + [1.0] * 4
METERS = (
    instrument("meter.voltage", "voltage", {"gain": "0.1 %", "offset": "2 mV"}),
    instrument("meter.current", "current", {"gain": "0.2 %"}),
)
registry = cache(load_registry)


def readings(name, at, of="meter.voltage", unit="V"):
    where = {"where": {"load.current": f"{at} A"}} if at else {"per": ["load.current"]}
    return ("readings", {"of": of, "result": {"name": name, "unit": unit}, **where})


def equation(name, unit, model, inputs, **more):
    return ("equation", {"result": {"name": name, "unit": unit}, "model": model,
                         "inputs": inputs, **more})  # fmt: skip


def results_of(*analyses, meters=METERS, places=PLACES):
    columns = {"meter.voltage": VOLT, "meter.current": AMPERE}
    run = run_of(columns, UNITS, meters, places)
    references = [AnalysisRef.model_validate({name: settings}) for name, settings in analyses]
    findings_ = findings_of(run, references, Scrutiny(registry()))
    assert not [missing for findings in findings_ for missing in findings.missing]
    return [result for findings in findings_ for result in findings.results]


def mean(values):
    return GTC.ureal(values.mean(), values.std(ddof=1) / sqrt(len(values)), len(values) - 1)


def read(values, gain, offset=0.0):
    return mean(values) * (1 + gain) + offset


def test_ratio_of_two_results_of_one_meter_has_its_gain_once():
    """The gain cancels; the offset acts by its difference; the scatters are independent."""
    high, low, ratio = results_of(
        readings("high", 2), readings("low", 1),
        equation("ratio", "1", "a / b", {"a": "high", "b": "low"}),
    )  # fmt: skip
    gain, offset = GTC.ureal(0, 0.001 / sqrt(3)), GTC.ureal(0, 0.002 / sqrt(3))
    expected = read(VOLT[:4], gain, offset) / read(VOLT[4:], gain, offset)
    assert ratio.estimate.value == pytest.approx(expected.x, rel=1e-12)
    assert ratio.estimate.u == pytest.approx(expected.u, rel=1e-6)
    assert ratio.estimate.dof == pytest.approx(expected.df, rel=1e-4)
    lines = {line.name: line.u for line in ratio.components}
    assert lines["gain of meter.voltage"] == pytest.approx(0, abs=1e-9)
    independent = ratio.estimate.value * sqrt(
        sum((result.estimate.u / result.estimate.value) ** 2 for result in (high, low))
    )
    assert ratio.estimate.u < independent * 0.9


def test_error_in_one_figure_may_differ_at_each_reading():
    """A difference of two readings has it twice: their common part is not stated."""
    meters = (instrument("meter.voltage", "voltage", "2 mV"),)
    *_, off = results_of(
        readings("high", 2), readings("low", 1),
        equation("off", "V", "a - b", {"a": "high", "b": "low"}), meters=meters,
    )  # fmt: skip
    voltages = GTC.ureal(0, 0.002 / sqrt(3)), GTC.ureal(0, 0.002 / sqrt(3))
    expected = read(VOLT[:4], 0, voltages[0]) - read(VOLT[4:], 0, voltages[1])
    assert off.estimate.u == pytest.approx(expected.u, rel=1e-9)


def test_equation_of_an_equation_and_a_channel_of_the_same_meter():
    """R = U / I first, then P = R I^2: the current's gain acts by its whole slope."""
    *_, power = results_of(
        equation("power", "W", "R * I^2 * c", {"R": "resistance", "I": "meter.current"},
                 constants={"c": {"value": 1.0, "limits": 0.001}}, per=["load.current"]),
        readings("first", 2),
        equation("resistance", "Ω", "U / I / c",
                 {"U": "meter.voltage", "I": "meter.current"},
                 constants={"c": {"value": 2.0, "limits": 0.001}}, per=["load.current"]),
    )[:2][1:]  # fmt: skip
    gain, offset = GTC.ureal(0, 0.001 / sqrt(3)), GTC.ureal(0, 0.002 / sqrt(3))
    of_current, c = GTC.ureal(0, 0.002 / sqrt(3)), GTC.ureal(1, 0.001 / sqrt(3))
    other_c = GTC.ureal(2, 0.001 / sqrt(3))  # a different constant of the same name
    volt, ampere = (
        GTC.multiple_ureal(
            [VOLT[4:].mean(), AMPERE[4:].mean()],
            [VOLT[4:].std(ddof=1) / 2, AMPERE[4:].std(ddof=1) / 2], 3,
        )
    )  # fmt: skip
    GTC.set_correlation(np.corrcoef(VOLT[4:], AMPERE[4:])[0, 1], volt, ampere)
    resistance = (volt * (1 + gain) + offset) / (ampere * (1 + of_current)) / other_c
    again = read(AMPERE[4:], of_current)  # its scatter counts as independent
    expected = resistance * again**2 * c
    assert power.estimate.value == pytest.approx(expected.x, rel=1e-12)
    assert power.estimate.u == pytest.approx(expected.u, rel=1e-6)
    assert power.place == "load.current = 1 A"


def test_value_of_a_curve_enters_with_its_budget():
    curve = ("curve", {
        "of": "meter.voltage", "over": "load.current", "fit": {"polynomial": {"degree": 1}},
        "results": {"value": {"name": "at_one", "at": "1.5 A", "unit": "mV"}},
    })  # fmt: skip
    single, double = results_of(
        curve, equation("twice", "V", "2 * a", {"a": "at_one"}),
        places=[2.0, 1.9, 2.1, 2.0, 1.0, 1.1, 0.9, 1.0],
    )  # fmt: skip
    assert double.estimate.value == pytest.approx(2 * single.estimate.value / 1000)
    assert double.estimate.u == pytest.approx(2 * single.estimate.u / 1000)
    assert double.estimate.dof == pytest.approx(single.estimate.dof, rel=1e-6)


def test_result_at_each_place_is_paired_with_that_of_the_same_place():
    *_, two, one = results_of(
        readings("voltage", None), equation("half", "V", "a / 2", {"a": "voltage"},
                                            per=["load.current"]),
    )  # fmt: skip
    assert [result.place for result in (two, one)] == ["load.current = 2 A", "load.current = 1 A"]
    assert one.estimate.value == pytest.approx(VOLT[4:].mean() / 2)


def test_equation_of_a_missing_result_is_missing_at_that_place():
    """R = U / I has no value at 0 A; U + U, in the same model as power, has one."""
    columns = {"meter.voltage": VOLT[:2], "meter.current": np.array([0.0, 0.02])}
    of = {"inputs": {"U": "meter.voltage", "I": "meter.current"}, "per": ["load.current"]}
    analyses = [
        equation("R", "Ω", "U / I", **of),
        equation("twice", "Ω", "2 * R", {"R": "R"}, per=["load.current"]),
        ("equation", {
            "results": [{"name": "power", "unit": "W"}, {"name": "double", "unit": "V"}],
            "model": "power = R * I^2\ndouble = U + U",
            "inputs": {"R": "R", **of["inputs"]}, "per": ["load.current"],
        }),
    ]  # fmt: skip
    references = [AnalysisRef.model_validate({name: settings}) for name, settings in analyses]
    findings_ = findings_of(
        run_of(columns, UNITS, METERS, [0.0, 1.0]), references, Scrutiny(registry())
    )
    assert [gap.sentence for findings in findings_ for gap in findings.missing] == [
        "There is no value of R at load.current = 0 A: 'U / I' gives no finite number.",
        "There is no value of twice at load.current = 0 A: there is none of R.",
        "There is no value of power at load.current = 0 A: there is none of R.",
    ]
    assert [(result.name, result.place) for part in findings_ for result in part.results] == [
        ("R", "load.current = 1 A"), ("twice", "load.current = 1 A"),
        ("power", "load.current = 1 A"),
        ("double", "load.current = 0 A"), ("double", "load.current = 1 A"),
    ]  # fmt: skip
    assert findings_[2].results[1].estimate.value == pytest.approx(2 * VOLT[0])


def test_shared_constant_is_one_error_for_any_symbols():
    """R_N cancels in a ratio of two currents, even if that ratio is called R_N."""
    of = {"constants": {"R_N": {"value": "10 Ω", "u": "0.1 Ω"}}}
    volt = {"U": "meter.voltage"}
    *_, ratio = results_of(
        equation("one", "A", "U / R_N", volt, where={"load.current": "1 A"}, **of),
        equation("two", "A", "U / R_N", volt, where={"load.current": "2 A"}, **of),
        ("equation", {
            "result": {"name": "ratio", "symbol": "R_N", "unit": "1"}, "model": "R_N = a / b",
            "inputs": {"a": "one", "b": "two"},
        }),
    )  # fmt: skip
    (line,) = (line for line in ratio.components if line.name.startswith("R_N"))
    assert line.u == pytest.approx(0, abs=1e-12)


def test_results_with_the_same_correlated_constants_are_not_combined():
    """u(A + B) is twice u(A); from the budget lines it would be sqrt(2) u(A)."""
    of = {
        "constants": {name: {"value": "1 V", "u": "0.1 V"} for name in "ab"},
        "correlations": [{"between": ["a", "b"], "r": 0.5}],
        "where": {"load.current": "1 A"},
    }
    analyses = [
        equation("one", "V", "U + a + b", {"U": "meter.voltage"}, **of),
        equation("two", "V", "U + a + b", {"U": "meter.voltage"}, **of),
        equation("sum", "V", "A + B", {"A": "one", "B": "two"}),
        equation("with_own", "V", "A + a + b", {"A": "one"},
                 constants=of["constants"], correlations=of["correlations"]),
    ]  # fmt: skip
    references = [AnalysisRef.model_validate({name: settings}) for name, settings in analyses]
    columns = {"meter.voltage": VOLT, "meter.current": AMPERE}
    findings_ = findings_of(
        run_of(columns, UNITS, METERS, PLACES), references, Scrutiny(registry())
    )
    assert [result.name for findings in findings_ for result in findings.results] == ["one", "two"]
    assert [
        gap.why.partition(", and what")[0] for findings in findings_ for gap in findings.missing
    ] == [
        "'a and b, correlated' is a line of one and of two",
        "'a and b, correlated' is a line of one and of the model",
    ]


def test_circular_results_are_refused():
    with pytest.raises(DataError, match="of each other"):
        results_of(equation("one", "V", "b", {"b": "two"}), equation("two", "V", "a", {"a": "one"}))


def test_scatter_of_a_result_in_two_equations_is_one_error():
    """a = 2 z and b = 3 z, for one zero z of four readings: a + b = 5 z, and b - 1.5 a is exact."""
    zero, *_, total, none = results_of(
        readings("zero", 1),
        equation("a", "V", "2 * z", {"z": "zero"}), equation("b", "V", "3 * z", {"z": "zero"}),
        equation("total", "V", "a + b", {"a": "a", "b": "b"}),
        equation("none", "V", "b - 1.5 * a", {"a": "a", "b": "b"}),
    )  # fmt: skip
    assert total.estimate.u == pytest.approx(5 * zero.estimate.u, rel=1e-9)
    assert total.estimate.dof == pytest.approx(zero.estimate.dof, rel=1e-6)
    assert none.estimate.u == pytest.approx(0, abs=1e-12)


def test_two_equations_share_the_error_of_a_result_at_each_place():
    at = {"per": ["load.current"]}
    meters = (instrument("meter.voltage", "voltage", "2 mV"),)
    *_, total, _ = results_of(
        readings("v", None),
        equation("two", "V", "2 * v", {"v": "v"}, **at),
        equation("three", "V", "3 * v", {"v": "v"}, **at),
        equation("total", "V", "a + b", {"a": "two", "b": "three"}, **at), meters=meters,
    )  # fmt: skip
    error = GTC.ureal(0, 0.002 / sqrt(3))
    assert total.place == "load.current = 2 A"
    expected = 5 * read(VOLT[:4], 0, error)
    assert total.estimate.u == pytest.approx(expected.u, rel=1e-9)
    assert total.estimate.dof == pytest.approx(expected.df, rel=1e-4)


def test_errors_in_one_figure_of_results_that_add_up_count_as_equal():
    """V + 2 V of one reading is 3 V: as independent errors its u was sqrt(5), not 3, times 2 mV."""
    meters = (instrument("meter.voltage", "voltage", "2 mV"),)
    volt = {"V": "meter.voltage"}
    at = {"where": {"load.current": "1 A"}}
    one, two, total, difference = results_of(
        equation("one", "V", "V", volt, **at), equation("two", "V", "2 * V", volt, **at),
        equation("both", "V", "a + b", {"a": "one", "b": "two"}),
        equation("less", "V", "b - a", {"a": "one", "b": "two"}), meters=meters,
    )  # fmt: skip
    u = 0.002 / sqrt(3)
    lines = {line.name: line for line in total.components}
    (line,) = (line for name, line in lines.items() if name.startswith("reading of"))
    assert line.u == pytest.approx(3 * u, rel=1e-9)
    assert not line.shared
    of_difference = [line.u for line in difference.components if line.name.startswith("reading of")]
    assert np.linalg.norm(of_difference) == pytest.approx(sqrt(5) * u, rel=1e-9)
    assert one.estimate.value + two.estimate.value == pytest.approx(total.estimate.value)


def test_mean_over_places_keeps_the_scatter_of_a_common_result():
    """y = V - zero at two places, zero of four readings: the mean has all of its scatter."""
    zero, *net = results_of(
        readings("zero", 1),
        equation("net", "V", "V - z", {"V": "meter.voltage", "z": "zero"}, per=["load.current"]),
    )  # fmt: skip
    gain = 0.001 / sqrt(3)
    scatter = [volts.std(ddof=1) / 2 for volts in (VOLT[:4], VOLT[4:])]
    mean_net = sum(result.estimate.value for result in net) / 2
    expected = sqrt(
        (scatter[0] ** 2 + scatter[1] ** 2) / 4 + scatter[1] ** 2 + (gain * mean_net) ** 2
    )
    assert mean_of(net).u == pytest.approx(expected, rel=1e-6)
    assert zero.estimate.u > 0


@pytest.mark.parametrize("inputs", [("a", "zero"), ("zero", "a"), ("zero", "zero")])
@pytest.mark.parametrize("per", [{}, {"per": ["load.current"]}])
def test_result_beside_an_equation_of_it_is_one_error(inputs, per):
    """With a = 2 z, a + z is 3 z and z + z is 2 z."""
    meters = (instrument("meter.voltage", "voltage", "2 mV"),)
    zero, *_, total = results_of(
        readings("zero", None if per else 1),
        equation("a", "V", "2 * z", {"z": "zero"}, **per),
        equation("total", "V", "x + y", dict(zip("xy", inputs, strict=True)), **per), meters=meters,
    )  # fmt: skip
    times = sum(2 if name == "a" else 1 for name in inputs)
    expected = times * read(VOLT[4:], 0, GTC.ureal(0, 0.002 / sqrt(3)))
    assert total.estimate.u == pytest.approx(expected.u, rel=1e-9)
    assert total.estimate.dof == pytest.approx(expected.df, rel=1e-6)
    assert zero.estimate.u > 0


def test_offset_relative_to_the_reading_adds_up_in_a_sum():
    """0.1 % of 5 V and of 2.5 V, of one meter: as independent errors 3.2 mV for 4.3 mV."""
    meters = (instrument("meter.voltage", "voltage", {"offset": "0.1 % reading"}),)
    *_, total, off = results_of(
        readings("high", 2), readings("low", 1),
        equation("total", "V", "a + b", {"a": "high", "b": "low"}),
        equation("off", "V", "a - b", {"a": "high", "b": "low"}), meters=meters,
    )  # fmt: skip
    limits = 0.001 * np.array([VOLT[:4].max(), VOLT[4:].max()]) / sqrt(3)
    for result, expected in ((total, limits.sum()), (off, np.linalg.norm(limits))):
        lines = [line.u for line in result.components if line.name.startswith("offset")]
        assert np.linalg.norm(lines) == pytest.approx(expected, rel=1e-6)
