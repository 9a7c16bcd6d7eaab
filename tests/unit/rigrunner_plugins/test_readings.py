"""The analysis `readings`, against independent computations."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isnan, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy import signal, stats

from rigrunner.api.data import Measurement, Recording, RunData, ZeroReading
from rigrunner.api.errors import DataError
from rigrunner.api.instruments import Instrument
from rigrunner.registry import load_registry
from rigrunner.signal.coverage import expanded
from rigrunner_plugins.analyses.statistics import STATISTICS, Series, percentile

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner_plugins.analyses.statistics import Statistic

UNITS = {"meter.voltage": "V", "load.current": "A", "shunt.voltage": "V", "room.temperature": "K"}
START = "2026-01-05T10:00:00+00:00"


def row(second: int, current: float, table: str = "measured", **values: float) -> Measurement:
    return Measurement(
        table,
        f"2026-01-05T10:00:{second:02d}+00:00",
        {"load.current": current},
        {name.replace("__", "."): value for name, value in values.items()},
        UNITS,
    )


def meter(channel="meter.voltage", measures="voltage", accuracy="30 mV") -> Instrument:
    return Instrument.model_validate(
        {"channel": channel, "measures": measures, "serial": "M-1", "accuracy": accuracy}
    )


def run_of(*rows: Measurement, recordings=(), instruments=(), zeros=None) -> RunData:
    return RunData(
        run_id="r",
        procedure_id="P",
        procedure_revision="A",
        procedure_title="",
        station_id="s",
        started_utc=START,
        ended_utc=START,
        outcome="completed",
        inputs={},
        instruments={instrument.channel: instrument for instrument in instruments},
        zeros=zeros or {},
        recordings=tuple(recordings),
        measurements=rows,
    )


def record(values, channel="meter.voltage", *, current=1.0, rate_hz=100.0, second=0) -> Recording:
    return Recording(
        f"rec {second}",
        rate_hz,
        f"2026-01-05T10:00:{second:02d}+00:00",
        {"load.current": current},
        {channel: np.asarray(values, float)},
        UNITS,
    )


def analyse(run: RunData, unit="V", **settings):
    common = {"of": "meter.voltage", "result": {"name": "found", "unit": unit}}
    return load_registry().make("analysis", "readings", common | settings)(run)


def result_of(run: RunData, unit="V", **settings):
    (result,) = analyse(run, unit, **settings).results
    return result


VALUES = (12.01, 12.04, 11.98, 12.02, 12.00)
ROWS = tuple(row(at, 2.0, meter__voltage=value) for at, value in enumerate(VALUES))


def test_mean_of_independent_rows_has_s_over_root_n_and_the_instrument() -> None:
    result = result_of(run_of(*ROWS, instruments=[meter()]), "mV")
    mean, scatter, b = np.mean(VALUES), stats.sem(VALUES), 0.03 / sqrt(3)
    assert result.estimate.value == pytest.approx(1e3 * mean)
    assert result.estimate.unit == "mV"
    assert result.estimate.u == pytest.approx(1e3 * sqrt(scatter**2 + b**2))
    # Welch and Satterthwaite by hand: only the scatter has finite degrees of freedom
    assert result.estimate.dof == pytest.approx(4 * (scatter**2 + b**2) ** 2 / scatter**4)
    assert result.readings == 5
    assert [line.unit for line in result.components] == ["mV", "V"]


def test_equal_readings_have_no_scatter() -> None:
    rows = [row(at, 2.0, meter__voltage=5.732e-6) for at in range(3)]  # their mean is rounded
    result = result_of(run_of(*rows, instruments=[meter()]))
    assert result.components[0].u == 0.0


@pytest.mark.parametrize("value", [0.1, 3.3, 1e9 + 0.1])
@pytest.mark.parametrize("statistic", ["mean", "standard_deviation", "range", "slope"])
def test_equal_samples_have_no_scatter(value: float, statistic: str) -> None:
    run = run_of(recordings=[record(np.full(1000, value))], instruments=[meter(accuracy="0 V")])
    unit = "V/s" if statistic == "slope" else "V"
    (result,) = analyse(run, statistic=statistic, result={"name": "result", "unit": unit}).results
    assert result.estimate.u == 0
    if statistic != "mean":
        assert result.estimate.value == 0


@pytest.mark.parametrize("statistic", ["standard_deviation", "range", "slope"])
def test_gain_acts_on_a_small_change_of_a_large_value(statistic: str) -> None:
    """1 mV on 1 GV: the gain contributes 1 % of the statistic, against exact sums."""
    steps = np.array([0, 3, 1, 5, 2, 8, 4, 9, 7, 6])
    values = 1e9 + steps / 1024  # exact in binary
    run = run_of(
        recordings=[record(values)], instruments=[meter(accuracy={"gain": {"limit": "1 %"}})]
    )
    unit = "V/s" if statistic == "slope" else "V"
    (result,) = analyse(run, statistic=statistic, result={"name": "result", "unit": unit}).results
    times = np.arange(10)
    exact = {
        "standard_deviation": sqrt(sum((steps - 4.5) ** 2) / 9) / 1024,
        "range": 9 / 1024,
        "slope": sum((times - 4.5) * steps) / sum((times - 4.5) ** 2) / 1024 * 100.0,
    }[statistic]
    gain = result.components[-1]
    assert result.estimate.value == pytest.approx(exact, rel=1e-9)
    assert gain.u == pytest.approx(0.01 / sqrt(3) * abs(exact), rel=1e-9)


def test_single_reading_has_the_instrument_alone_with_a_note() -> None:
    findings = analyse(run_of(ROWS[0], instruments=[meter()]))
    assert findings.results[0].estimate.u == pytest.approx(0.03 / sqrt(3))
    assert findings.results[0].estimate.dof == inf
    assert "single reading" in findings.notes[0]


def test_unregistered_instrument_makes_u_unknown() -> None:
    result = result_of(run_of(*ROWS))
    assert result.estimate.value == pytest.approx(np.mean(VALUES))
    assert np.isnan(result.estimate.u)


def test_results_per_set_point_are_in_the_order_of_the_set_points() -> None:
    rows = [row(at, i, meter__voltage=12 - 0.01 * i) for at, i in enumerate((0, 1, 2, 1))]
    results = analyse(run_of(*rows, instruments=[meter()]), per=["load.current"]).results
    assert [result.place for result in results] == [f"load.current = {i} A" for i in (0, 1, 2)]
    assert [result.readings for result in results] == [1, 2, 1]
    assert [result.estimate.value for result in results] == pytest.approx([12.0, 11.99, 11.98])


def test_where_selects_one_place_in_any_unit() -> None:
    rows = [row(at, i, meter__voltage=12 - 0.01 * i) for at, i in enumerate((0, 1, 2))]
    result = result_of(run_of(*rows, instruments=[meter()]), where={"load.current": "2000 mA"})
    assert result.estimate.value == pytest.approx(11.98)


def test_unmeasured_place_is_refused() -> None:
    with pytest.raises(DataError, match=r"not measured at load\.current = 3 A"):
        result_of(run_of(*ROWS), where={"load.current": "3 A"})
    with pytest.raises(DataError, match="'phase' does not distinguish values"):
        result_of(run_of(*ROWS), per=["phase"])


def test_range_has_the_error_of_two_readings() -> None:
    result = result_of(run_of(*ROWS, instruments=[meter()]), "mV", statistic="range")
    assert result.estimate.value == pytest.approx(60.0)
    assert result.estimate.u == pytest.approx(30 / sqrt(3) * sqrt(2))
    triangle = 60 * (1 - sqrt(0.05))  # the difference of two rectangles: half of its 95 % interval
    assert expanded(result.estimate) == pytest.approx(triangle, rel=0.01)


def test_gain_and_offset_act_through_the_statistic() -> None:
    torque = Instrument.model_validate(
        {
            "channel": "meter.torque",
            "serial": "T",
            "full_scale": "10 N·m",
            "accuracy": {"gain": "1 %", "offset": "1 N·m", "drift": "0 N·m", "nonlinearity": "0 %"},
        }
    )
    rows = [
        Measurement("t", START, {}, {"meter.torque": v}, {"meter.torque": "N·m"})
        for v in (2.0, 5.0)
    ]
    run = run_of(*rows, instruments=[torque])
    spread = result_of(run, "N·m", of="meter.torque", statistic="range")
    assert spread.estimate.u == pytest.approx(0.01 * 3 / sqrt(3), rel=1e-6)  # the offset cancels
    highest = result_of(run, "N·m", of="meter.torque", statistic="maximum")
    assert highest.estimate.u == pytest.approx(sqrt((0.01 * 5) ** 2 + 1) / sqrt(3), rel=1e-6)
    zeroed = replace(run, zeros={"meter.torque": 0.5})
    again = result_of(zeroed, "N·m", of="meter.torque", statistic="maximum")
    assert again.estimate.value == 4.5
    assert again.estimate.u == pytest.approx(0.01 * 4.5 / sqrt(3), rel=1e-6)


def test_difference_is_taken_value_by_value() -> None:
    rng = np.random.default_rng(5)
    hum = rng.normal(0, 0.2, 20)  # in both channels: it cancels
    pairs = [(12 + h + e, 1 + h) for h, e in zip(hum, rng.normal(0, 0.001, 20), strict=True)]
    rows = [row(0, 1.0, meter__voltage=a, shunt__voltage=b) for a, b in pairs]
    meters = [meter(), meter("shunt.voltage", accuracy="40 mV")]
    result = result_of(run_of(*rows, instruments=meters), minus="shunt.voltage")
    differences = [a - b for a, b in pairs]
    assert result.estimate.value == pytest.approx(np.mean(differences))
    u = sqrt(stats.sem(differences) ** 2 + (0.03**2 + 0.04**2) / 3)
    assert result.estimate.u == pytest.approx(u, rel=1e-6)


def test_ratio_has_the_unit_of_the_quotient() -> None:
    rows = [
        Measurement("t", START, {}, {"meter.voltage": v, "load.current": i}, UNITS)
        for v, i in ((10.0, 2.0), (10.2, 2.0))
    ]
    meters = [meter(), meter("load.current", "current", "10 mA")]
    result = result_of(run_of(*rows, instruments=meters), "Ω", divided_by="load.current")
    assert result.estimate.value == pytest.approx(5.05)
    scatter = stats.sem([5.0, 5.1])
    a, b = 0.03 / sqrt(3) / 2, 0.01 / sqrt(3) * 10.1 / 4  # dR = dU/I, dR = mean U dI/I²
    assert result.estimate.u == pytest.approx(sqrt(scatter**2 + a**2 + b**2), rel=1e-4)


def test_error_in_one_figure_moves_a_mean_quotient_by_its_mean_effect() -> None:
    """10 V over 1 A and over 4 A: 2 mA change each quotient by at most U/I² times 2 mA."""
    rows = [row(0, 1.0, meter__voltage=10.0, load__shunt=shunt) for shunt in (1.0, 4.0)]
    rows = [replace(row_, units={**UNITS, "load.shunt": "A"}) for row_ in rows]
    meters = [meter(accuracy="0 V"), meter("load.shunt", "current", "2 mA")]
    result = result_of(run_of(*rows, instruments=meters), "Ω", divided_by="load.shunt")
    (line,) = (line for line in result.components if line.name == "reading of load.shunt")
    assert line.u == pytest.approx((10 + 10 / 16) / 2 * 0.002 / sqrt(3), rel=1e-4)


def test_divisor_of_0_makes_one_result_missing_and_keeps_the_others() -> None:
    pairs = ((0.0, 1.0, 0.0), (2.0, 10.0, 2.0))
    rows = [row(0, set_a, meter__voltage=u, load__shunt=i) for set_a, u, i in pairs]
    rows = [replace(row_, units={**UNITS, "load.shunt": "A"}) for row_ in rows]
    settings = {"per": "load.current", "unit": "Ω", "divided_by": "load.shunt"}
    findings_ = analyse(run_of(*rows), **settings)
    assert [result.estimate.value for result in findings_.results] == [5.0]
    (missing,) = findings_.missing
    why = "load.shunt is 0, and nothing can be divided by it"
    assert missing.sentence == f"There is no value of found at load.current = 0 A: {why}."


def test_temperatures_are_in_celsius_and_their_range_in_kelvin() -> None:
    rows = [
        Measurement("t", START, {}, {"room.temperature": t + 273.15}, UNITS) for t in (20.0, 23.0)
    ]
    meters = [meter("room.temperature", "temperature", "0.3 K")]
    mean = result_of(run_of(*rows, instruments=meters), "°C", of="room.temperature")
    assert mean.estimate.value == pytest.approx(21.5)
    spread = result_of(
        run_of(*rows, instruments=meters), "K", of="room.temperature", statistic="range"
    )
    assert spread.estimate.value == pytest.approx(3.0)


@pytest.mark.parametrize("statistic", ["range", "standard_deviation"])
def test_difference_of_power_levels_is_in_decibel(statistic: str) -> None:
    """13 dBm less 10 dBm, 20 mW over 10 mW, is 3 dB; 3 dBm would be 2 mW (IEC 60027-3)."""
    rows = [
        Measurement("t", START, {}, {"meter.level": level}, {"meter.level": "dBm"})
        for level in (10.0, 13.0)
    ]
    meters = [meter("meter.level", "power level", "0 dB")]
    settings = {"of": "meter.level", "statistic": statistic}
    spread = result_of(run_of(*rows, instruments=meters), "dB", **settings)
    assert spread.estimate.value == pytest.approx(3.0 if statistic == "range" else 3 / sqrt(2))
    registry, units = load_registry(), {"meter.level": "dBm"}
    for symbol, is_right in (("dB", True), ("dBm", False)):
        in_unit = settings | {"result": {"name": "found", "unit": symbol}}
        assert (not registry.objections("readings", in_unit, units)) is is_right
    mean = {"of": "meter.level", "result": {"name": "found", "unit": "dBm"}}
    assert not registry.objections("readings", mean, units)


def autoregressive(n: int, phi: float, rng: np.random.Generator):
    return signal.lfilter([1.0], [1.0, -phi], rng.normal(0, 1, n + 500))[500:]


@pytest.mark.parametrize("phi", [0.0, 0.9, 0.995])
def test_scatter_of_samples_includes_their_correlation(phi: float) -> None:
    """The known standard deviation of the mean of an AR(1) series: sigma/((1 - phi) sqrt(n))."""
    rng, n = np.random.default_rng(7), 40_000
    u = []
    for _ in range(20):
        result = result_of(run_of(recordings=[record(autoregressive(n, phi, rng))]))
        u.append(result.components[0].u)
    assert np.sqrt(np.mean(np.square(u))) == pytest.approx(1 / ((1 - phi) * sqrt(n)), rel=0.15)


def mean_of_recordings(levels, *, noise: float = 1.0, seed: int = 1):
    """Return the mean of recordings of 300 samples about each level, with its lines."""
    rng = np.random.default_rng(seed)
    recordings = [
        record(level + noise * rng.normal(size=300), second=10 * at)
        for at, level in enumerate(levels)
    ]
    return result_of(run_of(recordings=recordings, instruments=[meter(accuracy="0 V")]))


def test_differing_recordings_scatter_as_their_means() -> None:
    """Two at 1 V and 3 V: half the difference, with one degree of freedom (GUM 4.2.3, n = 2).

    Treated as one series of 600 samples they had 250 degrees of freedom and a third of u.
    """
    result = mean_of_recordings([1.0, 3.0], noise=0.001)
    assert result.estimate.u == pytest.approx(1.0, rel=1e-3)
    assert result.estimate.dof == 1.0


def test_agreeing_recordings_are_one_series() -> None:
    result = mean_of_recordings([2.0, 2.0, 2.0])
    assert result.estimate.u == pytest.approx(1 / sqrt(900), rel=0.1)
    assert result.estimate.dof > 400


def test_interval_of_a_mean_covers_if_each_recording_has_its_own_level() -> None:
    """Of 100 runs of four recordings nearly 95 % contain the level that all scatter about."""
    rng = np.random.default_rng(7)
    inside = 0
    for seed in range(100):
        estimate = mean_of_recordings(rng.normal(size=4), seed=seed).estimate
        inside += abs(estimate.value) <= expanded(estimate)
    assert inside >= 90  # as one series 60


def count_inside(of: Statistic, true: float, series: Iterable[Series]) -> tuple[int, int]:
    """Return how many intervals contain the true value, and how many series have no U."""
    inside = unknown = 0
    for sample in series:
        u, dof = of.scatter(sample) or (nan, nan)
        unknown += isnan(u)
        inside += abs(of.value(sample) - true) <= stats.t.ppf(0.975, dof) * u
    return inside, unknown


def of_levels(levels: float, recordings: int, runs: int = 100) -> Iterator[Series]:
    """Yield series of recordings of 2 s, 10 s apart, each about its own level.

    Their samples are an AR(1) series of numpy with a deviation of 1.
    """
    rng, phi, n = np.random.default_rng(11), 0.5, 200
    starts = tuple(n * at for at in range(1, recordings))
    times = np.concatenate([10 * at + np.arange(n) / 100 for at in range(recordings)])
    for _ in range(runs):
        blocks = [
            mean + autoregressive(n, phi, rng) * sqrt(1 - phi**2)
            for mean in levels * rng.normal(size=recordings)
        ]
        yield Series(np.concatenate(blocks), times, in_a_row=True, step_s=0.01, starts=starts)


@pytest.mark.parametrize(("levels", "recordings"), [(0.0, 4), (1.0, 4), (1.0, 8), (5.0, 8)])
def test_interval_of_a_standard_deviation_covers_if_recordings_differ(levels, recordings):
    deviation = STATISTICS["standard_deviation"]
    inside, unknown = count_inside(deviation, sqrt(1 + levels**2), of_levels(levels, recordings))
    assert inside >= 90  # as one series 70 to 85
    assert unknown == 0


@pytest.mark.parametrize(("levels", "recordings"), [(0.0, 4), (1.0, 6), (1.0, 10), (5.0, 6)])
def test_interval_of_a_slope_covers_if_recordings_differ(levels, recordings) -> None:
    inside, unknown = count_inside(STATISTICS["slope"], 0.0, of_levels(levels, recordings))
    assert inside >= 90  # as one series 60 to 80
    assert unknown == 0


def test_slope_through_two_recordings_has_an_unknown_uncertainty() -> None:
    """Nothing tells a drift from two levels: U of the samples alone covered 5 to 16 of 100."""
    assert count_inside(STATISTICS["slope"], 0.0, of_levels(1.0, 2)) == (0, 100)
    recordings = [record(np.arange(20.0) % 3, second=10 * at) for at in range(2)]
    findings_ = analyse(
        run_of(recordings=recordings, instruments=[meter()]),
        statistic="slope", result={"name": "drift", "unit": "V/s"},
    )  # fmt: skip
    assert isnan(findings_.results[0].estimate.u)
    (note,) = findings_.notes
    assert note == (
        "drift: there are too few readings, or recordings that agree, to know the uncertainty of a"
        " slope."
    )


def test_interval_of_a_percentile_covers_or_is_unknown_if_recordings_differ() -> None:
    inside, unknown = count_inside(percentile(0.5), 0.0, of_levels(1.0, 8))
    assert inside >= 90  # as one series 85
    assert unknown == 0
    true = stats.norm.ppf(0.9)
    inside, unknown = count_inside(percentile(0.9), true, of_levels(0.0, 4))
    assert inside + unknown >= 90
    assert unknown <= 20  # the F-test at 5 %, of means that vary little more than samples tell
    _, unknown = count_inside(percentile(0.9), true * sqrt(26), of_levels(5.0, 4))
    assert unknown >= 95


@pytest.mark.parametrize(
    ("percent", "n", "has_u"),
    [(50, 5, False), (50, 6, True), (90, 35, False), (90, 36, True), (95, 71, False),
     (95, 72, True), (5, 71, False), (5, 72, True)],
)  # fmt: skip
def test_interval_of_a_percentile_of_readings_is_that_of_order_statistics(percent, n, has_u):
    """All n are below a percentile by chance p^n: 0.9^36 = 2.25 %, 0.95^72 = 2.49 %.

    Half the distance from n p - sqrt(n p q) to n p + sqrt(n p q) covered 56 % for p = 95 %, n = 10.
    """
    rng = np.random.default_rng(5)
    recordings = (
        Series(rng.exponential(size=n), np.arange(float(n)), in_a_row=False) for _ in range(400)
    )
    true = stats.expon.ppf(percent / 100)
    inside, unknown = count_inside(percentile(percent / 100), true, recordings)
    assert unknown == (0 if has_u else 400)
    assert inside >= (372 if has_u else 0)


def test_very_many_samples_are_reduced_to_means_of_neighbours() -> None:
    rng, phi, n = np.random.default_rng(8), 0.99, 1 << 20
    result = result_of(run_of(recordings=[record(autoregressive(n, phi, rng), rate_hz=1e4)]))
    assert result.components[0].u == pytest.approx(1 / ((1 - phi) * sqrt(n)), rel=0.25)
    assert result.readings == n


def test_other_statistics_of_samples_equal_numpy_and_theory() -> None:
    values = np.random.default_rng(9).normal(3.0, 2.0, 5000)
    run = run_of(recordings=[record(values)], instruments=[meter(accuracy="1 uV")])
    rms = result_of(run, statistic="rms")
    assert rms.estimate.value == pytest.approx(np.sqrt(np.mean(values**2)))
    # of normal values var(x²) = 4 mu² sigma² + 2 sigma⁴
    assert rms.estimate.u == pytest.approx(
        sqrt(4 * 9 * 4 + 2 * 16) / sqrt(5000) / 2 / sqrt(13), rel=0.1
    )
    spread = result_of(run, statistic="standard_deviation")
    assert spread.estimate.value == pytest.approx(np.std(values, ddof=1))
    assert spread.estimate.u == pytest.approx(2.0 / sqrt(2 * 4999), rel=0.1)
    high = result_of(run, statistic="percentile", percent="90 %")
    assert high.estimate.value == pytest.approx(np.quantile(values, 0.9))
    density = stats.norm.pdf(stats.norm.ppf(0.9)) / 2.0
    assert high.estimate.u == pytest.approx(sqrt(0.9 * 0.1 / 5000) / density, rel=0.3)
    assert result_of(run, statistic="minimum").estimate.value == values.min()


def test_slope_of_rows_equals_a_straight_line_fit() -> None:
    values = [1.0, 1.2, 1.5, 1.55, 1.9]
    rows = [row(at, 1.0, meter__voltage=v) for at, v in enumerate(values)]
    result = result_of(
        run_of(*rows, instruments=[meter(accuracy="1 nV")]), "mV/s", statistic="slope"
    )
    line = stats.linregress(range(5), values)
    assert result.estimate.value == pytest.approx(1e3 * line.slope)
    assert result.estimate.u == pytest.approx(1e3 * line.stderr, rel=1e-6)
    assert result.estimate.dof == pytest.approx(3, rel=1e-6)


def test_integral_of_rows_is_that_of_the_lines_between_them() -> None:
    at, values = (0, 1, 3, 4, 7), [1.0, 1.2, 1.5, 1.55, 0.9]
    rows = [row(second, 1.0, meter__voltage=v) for second, v in zip(at, values, strict=True)]
    voltmeter = meter(accuracy={"overall": "30 mV", "gain": "0.3 %", "offset": "12 mV"})
    result = result_of(run_of(*rows, instruments=[voltmeter]), "mV·min", statistic="integral")
    area = float(np.trapezoid(values, at))
    assert result.estimate.value == pytest.approx(1e3 / 60 * area)
    scatter, reading, gain, offset = (1e-3 * 60 * line.u for line in result.components)
    # all in V·s; a reading may err one way at each row, as the offset does
    limits = (7 * 0.03, 0.003 * area, 7 * 0.012)
    assert (reading, gain, offset) == pytest.approx([limit / sqrt(3) for limit in limits])
    off = [1.2 - (2 * 1.0 + 1.5) / 3, 1.5 - (1.2 + 2 * 1.55) / 3, 1.55 - (3 * 1.5 + 0.9) / 4]
    squares = [1 + 4 / 9 + 1 / 9, 1 + 1 / 9 + 4 / 9, 1 + 9 / 16 + 1 / 16]
    s = sqrt(np.mean([d**2 / of for d, of in zip(off, squares, strict=True)]))
    assert scatter == pytest.approx(s * np.linalg.norm([0.5, 1.5, 1.5, 2.0, 1.5]))
    assert result.components[0].dof == pytest.approx(18 / 35 * 3)


def test_interval_of_an_integral_covers_while_the_value_changes() -> None:
    rng, times = np.random.default_rng(3), np.sort(np.random.default_rng(4).uniform(0, 10, 60))
    values = 5 * np.exp(-times / 4)
    true = float(np.trapezoid(values, times))
    noisy = (Series(values + rng.normal(0, 0.1, 60), times, in_a_row=False) for _ in range(400))
    inside, unknown = count_inside(STATISTICS["integral"], true, noisy)
    assert not unknown
    assert 368 <= inside <= 392


@pytest.mark.parametrize("seconds", [(0, 1, 2, 30, 31), (0, 1, 20), (0, 20, 21)])
def test_integral_with_a_gap_in_the_readings_is_missing(seconds) -> None:
    """A run that was interrupted, or the time between two recordings."""
    rows = [row(second, 1.0, meter__voltage=1.0) for second in seconds]
    (missing,) = analyse(run_of(*rows), "V·s", statistic="integral").missing
    assert "nothing was read for" in missing.why
    (single,) = analyse(run_of(rows[0]), "V·s", statistic="integral").missing
    assert single.why == "one value has no integral over time"


def test_increasing_intervals_between_readings_are_no_gap() -> None:
    rows = [row(second, 1.0, meter__voltage=1.0) for second in (0, 1, 3, 8, 20, 50)]
    result = result_of(run_of(*rows), "V·s", statistic="integral")
    assert result.estimate.value == pytest.approx(50.0)


def test_settling_time_equals_its_definition() -> None:
    times = np.arange(500) / 100.0
    run = run_of(recordings=[record(5 * (1 - np.exp(-times / 0.5)))])
    result = result_of(run, "ms", statistic="settling_time", within="50 mV")
    last = 5 * (1 - np.exp(-times[-1] / 0.5))
    due = next(t for t in times if abs(5 * (1 - np.exp(-t / 0.5)) - last) <= 0.05)
    assert result.estimate.value == pytest.approx(1e3 * due)
    assert result.components[0].u == pytest.approx(10 / sqrt(12))


def test_nan_is_refused() -> None:
    with pytest.raises(DataError, match="not a finite number"):
        result_of(run_of(row(0, 1.0, meter__voltage=nan)))


LEVEL = {"of": "in.level", "result": {"name": "x", "unit": "dBm"}}
SECONDS = {"name": "x", "unit": "s"}
REFUSED = [
    ({"result": {"name": "x", "unit": "A"}}, ("result", "unit"), "the mean is a voltage"),
    ({"minus": "load.current"}, ("minus",), "load.current is a"),
    ({"statistic": "slope"}, ("result", "unit"), "the slope is a"),
    (
        {"statistic": "settling_time", "within": "1 A", "result": {"name": "x", "unit": "s"}},
        ("within",),
        "expected a voltage",
    ),
    (
        {"of": "room.temperature", "statistic": "range", "result": {"name": "x", "unit": "°C"}},
        ("result", "unit"),
        "a difference of temperatures",
    ),
    (
        {"of": "room.temperature.peak_to_peak", "result": {"name": "x", "unit": "°C"}},
        ("result", "unit"),
        "a difference of temperatures",
    ),
    ({**LEVEL, "divided_by": "out.level"}, ("divided_by",), "in.level is a power level"),
    ({**LEVEL, "of": "shunt.voltage", "divided_by": "in.level"}, ("divided_by",), "a logarithm"),
    (
        {**LEVEL, "relative_to": {"procedure": "P"}},
        ("relative_to",),
        "in.level is a power level, a logarithm",
    ),
    ({"statistic": "integral"}, ("result", "unit"), "the integral is a magnetic flux"),
    (
        {"of": "room.temperature", "statistic": "integral", "result": {"name": "x", "unit": "K·s"}},
        ("statistic",),
        "the integral of a temperature depends on the zero of its scale",
    ),
    ({**LEVEL, "statistic": "rms"}, ("statistic",), "in.level is a power level, a logarithm"),
    ({**LEVEL, "of": "in.level.rms"}, ("of",), "in.level.rms is a power level, a logarithm"),
    ({**LEVEL, "minus": "out.level"}, ("result", "unit"), "the mean is a level"),
    (
        {**LEVEL, "statistic": "settling_time", "within": "1 dBm", "result": SECONDS},
        ("within",),
        "expected a level",
    ),
]


@pytest.mark.parametrize(("changes", "key", "words"), REFUSED)
def test_settings_that_do_not_fit_are_refused_before_a_run(changes, key, words) -> None:
    record = load_registry().find("analysis", "readings").record
    settings = record.settings_model.model_validate(
        {"of": "meter.voltage", "result": {"name": "x", "unit": "V"}} | changes
    )
    of_statistics = {"room.temperature.peak_to_peak": "K", "in.level.rms": "dBm"}
    levels = {"in.level": "dBm", "out.level": "dBm"}
    ((where, message, _),) = record.objections(settings, UNITS | of_statistics | levels)
    assert where == key
    assert words in message


def test_difference_of_two_meters_in_dbm_is_in_db() -> None:
    """-10 dBm less -13 dBm is 3 dB, with limits of 0.2 dB and 0.1 dB (GUM 4.3.7)."""
    units = {"in.level": "dBm", "out.level": "dBm"}
    measured = Measurement("t", START, {}, {"in.level": -10.0, "out.level": -13.0}, units)
    meters = [
        meter("in.level", "power level", "0.2 dB"),
        meter("out.level", "power level", {"offset": "0.1 dB"}),
    ]
    loss = result_of(run_of(measured, instruments=meters), "dB", of="in.level", minus="out.level")
    assert loss.estimate.value == pytest.approx(3.0)
    assert loss.estimate.u == pytest.approx(sqrt(0.04 / 3 + 0.01 / 3))
    assert {line.unit for line in loss.components} == {"dB"}
    settings = {"of": "in.level", "minus": "out.level", "result": {"name": "x", "unit": "dB"}}
    assert not load_registry().objections("readings", settings, units)


def test_peak_to_peak_value_of_a_temperature_is_a_difference() -> None:
    name = "room.temperature.peak_to_peak"
    rows = [Measurement("t", START, {}, {name: value}, {name: "K"}) for value in (0.5, 0.7)]
    meters = [meter("room.temperature", "temperature", "0.2 K")]
    result = result_of(run_of(*rows, instruments=meters), "°C", of=name)
    assert result.estimate.value == pytest.approx(0.6)  # not -272.55


@pytest.mark.parametrize("statistic", ["rms", "peak_to_peak"])
def test_u_of_a_stored_statistic_includes_the_uncorrected_deviation(
    statistic,
) -> None:
    """The meter shows 10 % too much: for a sine from 0 V to 10 V it stores a span of 11 V."""
    applied = 5 + 5 * np.sin(np.linspace(0, 2 * np.pi, 1000, endpoint=False))
    truth, stored = (
        {"rms": np.sqrt(np.mean(wave**2)), "peak_to_peak": np.ptp(wave)}[statistic]
        for wave in (applied, 1.1 * applied)
    )
    name = f"meter.voltage.{statistic}"
    points = [
        {"applied": f"{volts} V", "indicated": f"{1.1 * volts} V", "U": "10 mV"}
        for volts in (0, 5, 10)
    ]
    corrected = Instrument.model_validate(
        {"channel": "meter.voltage", "measures": "voltage", "serial": "M-1", "points": points,
         "interpolation": "linear"}
    )  # fmt: skip
    result = result_of(
        run_of(Measurement("t", START, {}, {name: stored}, {name: "V"}), instruments=[corrected]),
        of=name,
    )
    assert abs(result.estimate.value - truth) > 0.4
    assert abs(result.estimate.value - truth) < expanded(result.estimate)
    assert "deviation of meter.voltage, not corrected" in {line.name for line in result.components}


def test_row_is_corrected_by_the_zero_in_force_when_it_was_read() -> None:
    rows = [
        replace(row(at, 1.0, meter__voltage=value), zeros={"meter.voltage": ZeroReading(zero)})
        for at, (value, zero) in enumerate([(5.1, 0.1), (5.4, 0.4)])
    ]
    run = run_of(*rows, instruments=[meter()], zeros={"meter.voltage": 0.4})
    assert result_of(run).estimate.value == pytest.approx(5.0)


def labelled(means: Iterable[float], label: str = "specimen", times: int = 3) -> RunData:
    """Read each specimen three times, 10 mV apart, in changing order; `reading` counts them."""
    rows = [
        replace(
            row(index, 1.0, meter__voltage=mean + 0.01 * ((index + reading) % times - 1)),
            coordinates={label: f"S-{index}", "reading": reading},
        )
        for index, mean in enumerate(means)
        for reading in range(times)
    ]
    return run_of(*rows, instruments=[meter(accuracy="0 V")])


def test_readings_of_several_specimens_scatter_by_their_means() -> None:
    """Nine readings of three specimens are three values of their scatter (GUM H.5)."""
    means = (10.0, 12.0, 11.2)
    result = result_of(labelled(means)).estimate
    assert result.u == pytest.approx(np.std(means, ddof=1) / sqrt(3))
    assert result.dof == pytest.approx(2)
    alike = result_of(labelled((10.0, 10.0005, 9.9995))).estimate
    assert alike.dof == pytest.approx(8)
    per_specimen = analyse(labelled(means), per="specimen").results
    assert [result.estimate.u for result in per_specimen] == pytest.approx([0.01 / sqrt(3)] * 3)


def test_two_values_of_a_label_may_differ_on_purpose() -> None:
    """Rising and falling: two levels do not show how such levels scatter."""
    result = result_of(labelled((10.0, 12.0), "way")).estimate
    assert result.dof == pytest.approx(5)


@pytest.mark.parametrize(("between", "share"), [(1.0, 0.93), (0.0, 0.93)])
def test_interval_of_the_mean_of_specimens_covers(between: float, share: float) -> None:
    rng, count, inside = np.random.default_rng(29), 400, 0
    levels = tuple(np.repeat(np.arange(4), 3).tolist())
    for _ in range(count):
        values = np.repeat(between * rng.normal(size=4), 3) + 0.1 * rng.normal(size=12)
        series = Series(values, np.arange(12.0), in_a_row=False, labels=(levels,))
        u, dof = STATISTICS["mean"].scatter(series) or (nan, nan)
        inside += abs(values.mean()) <= stats.t.ppf(0.975, dof) * u
    assert inside / count >= share
