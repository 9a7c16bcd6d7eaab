"""Procedures of `equation`, `curve` and `readings` against numpy, from the rows to the verdict.

No code of the project computes the expected values: sensitivities are differences of the formulas
written here, and fits are normal equations (JCGM 100:2008, 5.1 to 5.2, G.4 and H.3).
"""

from __future__ import annotations

import json
from math import sqrt

import numpy as np
import pytest
from scipy import stats

from helpers_cli import call

STATION = """\
rigrunner: station/1
id: bench
title: bench
devices:
  bench:
    type: a_bench
    plugin: tabulated
    settings:
      title: written down
      set_points: [{set_points}]
      rows:
{rows}
instruments:
{instruments}
"""
HEAD = """\
rigrunner: procedure/2
id: BY-HAND
revision: "A"
title: by hand
uses: {bench: a_bench}
main:
"""
FLAT = sqrt(3)
"""Half-width of a rectangle divided by its u."""
TINY = 1e-6
"""Step of numerical derivatives."""


def document_of(folder, rows, set_points, instruments, text):
    """Return the result of a run of a procedure on a bench with these rows."""
    folder.joinpath("station.yaml").write_text(
        STATION.format(
            set_points=", ".join(set_points),
            rows="\n".join(f"        - {{{row}}}" for row in rows),
            instruments="\n".join(
                f"  - {{channel: bench.{instrument}, serial: S-1, calibration: recorded}}"
                for instrument in instruments
            ),
        ),
        encoding="utf-8",
    )
    folder.joinpath("procedure.yaml").write_text(HEAD + text, encoding="utf-8")
    output = call("run", folder / "procedure.yaml", "--station", folder / "station.yaml",
                  "--unattended", "--runs", folder / "runs")  # fmt: skip
    assert output.code in {0, 1, 10}, output.err
    (run,) = (folder / "runs").iterdir()
    return json.loads((run / "result.json").read_text("utf-8"))


def estimates(document, name):
    return [result["estimate"] for result in document["results"] if result["name"] == name]


def verdicts(document):
    return {part["of"]: part["verdict"] for part in document["decision"]["parts"]}


def assert_is(estimate, value, u, dof=None):
    assert estimate["value"] == pytest.approx(value, rel=1e-9)
    assert estimate["standard_uncertainty"] == pytest.approx(u, rel=1e-5)
    if dof is not None:
        assert estimate["degrees_of_freedom"] == pytest.approx(dof, rel=1e-4)


def slopes(function, at):
    """Return the change of a function with each of its arguments."""
    at = np.array(at, float)
    steps = TINY * np.eye(len(at))
    return np.array([(function(at + s) - function(at - s)) / (2 * TINY) for s in steps])


def line(x, y):
    """Return constant and slope of the least-squares line, s about it and sum (x - mean)²."""
    from_mean = x - x.mean()
    slope = from_mean @ y / (from_mean @ from_mean)
    residuals = y - y.mean() - slope * from_mean
    return (
        y.mean() - slope * x.mean(),
        slope,
        sqrt(residuals @ residuals / (len(x) - 2)),
        from_mean @ from_mean,
    )


def steps(pairs, channels):
    """Return steps that set each pair of values and measure there, as text."""
    names = ", ".join(f"bench.{channel}" for channel in channels)
    return "".join(
        f"      - set: {{{pair}}}\n      - measure: {{channels: [{names}]}}\n" for pair in pairs
    )


def test_two_results_with_shared_inputs(tmp_path):
    """R = U/I and P = R I² of five pairs of readings: u with correlation, dof, r(R, P), k."""
    volt = np.array([4.9990, 4.9961, 5.0052, 4.9948, 5.0005])
    ampere = np.array([19.663, 19.639, 19.640, 19.685, 19.678]) / 1000
    rows = [f"n: {n} s, u: {u} V, i: {1000 * i:.3f} mA"
            for n, (u, i) in enumerate(zip(volt, ampere, strict=True))]  # fmt: skip
    document = document_of(
        tmp_path, rows, ["n"],
        ["u, measures: voltage, accuracy: {gain: 0.1 %, offset: 2 mV}",
         "i, measures: current, accuracy: 0.2 % reading"],
        """\
  - sweep:
      set: bench.n
      over: [0 s, 1 s, 2 s, 3 s, 4 s]
      steps: [{measure: {channels: [bench.u, bench.i]}}]
analysis:
  - equation:
      results: [{name: resistance, symbol: R, unit: kΩ}, {name: power, symbol: P, unit: µW}]
      model: |
        R = U / I
        P = R * I^2
      inputs: {U: bench.u, I: bench.i}
acceptance:
  rule: non_binary
  limits:
    - {of: resistance, min: 250 Ω, max: 254.5 Ω, source: the margin is a third of U}
    - {of: power, max: 0.1 W, source: in another unit}
""",
    )  # fmt: skip
    means = [volt.mean(), ampere.mean()]
    u = np.array([volt.std(ddof=1) / sqrt(5), ampere.std(ddof=1) / sqrt(5),
                  0.001 / FLAT, 0.002 / FLAT, 0.002 * ampere.max() / FLAT])  # fmt: skip
    r = np.eye(5)
    r[0, 1] = r[1, 0] = np.corrcoef(volt, ampere)[0, 1]
    equations = {
        "resistance": lambda x: (x[0] * (1 + x[2]) + x[3]) / (x[1] + x[4]) / 1e3,
        "power": lambda x: (x[0] * (1 + x[2]) + x[3]) * (x[1] + x[4]) * 1e6,
    }
    parts = {}
    for name, function in equations.items():
        point = [*means, 0, 0, 0]
        parts[name] = slopes(function, point) * u
        type_a = parts[name][:2] @ r[:2, :2] @ parts[name][:2]
        variance = parts[name] @ r @ parts[name]
        (estimate,) = estimates(document, name)
        assert_is(estimate, function(point), sqrt(variance), variance**2 / (type_a**2 / 4))
    correlation = parts["resistance"] @ r @ parts["power"]
    correlation /= sqrt(np.prod([part @ r @ part for part in parts.values()]))
    (table,) = (t for t in document["tables"] if t["title"] == "Correlation of the results")
    assert table["rows"][0][-1] == pytest.approx(correlation, rel=1e-4)
    assert verdicts(document) == {"resistance": "conditional pass", "power": "pass"}


def test_slope_and_reading_of_the_same_instrument(tmp_path):
    """V = S f: a gain error of f cancels, as it makes S too low and f too high."""
    force = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    volt = np.array([2.001, 4.0005, 5.999, 8.001, 9.9995])
    rows = [f"n: {n} s, f: {f} N, u: {u} V"
            for n, (f, u) in enumerate(zip([*force, 3.3], [*volt, 6.61], strict=True))]  # fmt: skip
    document = document_of(
        tmp_path, rows, ["n"],
        ["f, measures: force, accuracy: {gain: 1 %}",
         "u, measures: voltage, accuracy: {offset: 10 mV}"],
        """\
  - sweep:
      label: {phase: calibration}
      set: bench.n
      over: [0 s, 1 s, 2 s, 3 s, 4 s]
      steps: [{measure: {channels: [bench.f, bench.u]}}]
  - group:
      label: {phase: use}
      steps: [{set: {bench.n: 5 s}}, {measure: {channels: [bench.f, bench.u]}}]
analysis:
  - curve:
      of: bench.u
      over: bench.f
      where: {phase: calibration}
      fit: {polynomial: {degree: 1}}
      results: {slope: {name: sensitivity, unit: mV/N}}
  - equation:
      result: {name: predicted, symbol: V, unit: V}
      model: V = S * f
      inputs: {S: sensitivity, f: bench.f}
      where: {phase: use}
      second_order: no
acceptance: {rule: guard_band_u, limits: [{of: predicted, min: 6.59 V, max: 6610 mV, source: a}]}
""",
    )  # fmt: skip
    _, slope, s, square = line(force, volt)
    scatter = s / sqrt(square)
    (sensitivity,) = estimates(document, "sensitivity")
    assert_is(sensitivity, 1e3 * slope, 1e3 * sqrt(scatter**2 + (slope * 0.01 / FLAT) ** 2))
    (predicted,) = estimates(document, "predicted")
    assert_is(predicted, 3.3 * slope, 3.3 * scatter, 3)
    assert predicted["coverage_factor_95"] == pytest.approx(stats.t.ppf(0.975, 3), rel=1e-6)
    assert verdicts(document) == {"predicted": "pass"}  # by 9.2 mV; U is 3.1 mV, not 240 mV


def test_inverse_of_falling_calibration_line(tmp_path):
    """t at R = 7.4 kΩ by a line R(t) that falls: errors of both instruments; limits in K and °C."""
    t = np.array([10.0, 20.0, 30.0, 40.0, 50.0])
    ohm = np.array([9010.0, 8020.0, 6990.0, 6000.0, 5010.0])
    rows = [f"n: {n} s, t: {a} °C, r: {b} Ω"
            for n, (a, b) in enumerate(zip([*t, 0.0], [*ohm, 7400.0], strict=True))]  # fmt: skip
    document = document_of(
        tmp_path, rows, ["n"],
        ["t, measures: temperature, accuracy: {offset: 0.1 K, resolution: 0.1 K}",
         "r, measures: resistance, accuracy: {gain: 1 %, resolution: 10 Ω}"],
        """\
  - sweep:
      label: {phase: calibration}
      set: bench.n
      over: [0 s, 1 s, 2 s, 3 s, 4 s]
      steps: [{measure: {channels: [bench.t, bench.r]}}]
  - group:
      label: {phase: use}
      steps: [{set: {bench.n: 5 s}}, {measure: {channels: [bench.t, bench.r]}}]
analysis:
  - curve:
      of: bench.r
      over: bench.t
      where: {phase: calibration}
      fit: {polynomial: {degree: 1}}
      results:
        x_at: {name: temperature, unit: °C, where: {phase: use}}
        slope: {name: slope, unit: kΩ/K}
acceptance:
  rule: non_binary
  limits:
    - {of: temperature, min: 299.3 K, max: 27 °C, source: outside by a fifth of U}
    - {of: slope, max: -98 Ω/K, source: within by more than U}
""",
    )  # fmt: skip

    def inverse_line(x, y, y_0):
        constant, slope, *_ = line(x, y)
        return (y_0 - constant) / slope

    _, slope, s, square = line(t, ohm)
    expected = inverse_line(t, ohm, 7400.0)
    scatter = s / abs(slope) * sqrt(1 + 1 / 5 + (expected - t.mean()) ** 2 / square)
    by_ohm, by_t = (
        slopes(lambda y: inverse_line(t, y, 7400.0), ohm),
        slopes(lambda x: inverse_line(x, ohm, 7400.0), t),
    )
    gain = slopes(lambda g: inverse_line(t, ohm * (1 + g[0]), 7400.0 * (1 + g[0])), [0.0])[0]
    u = np.array([
        scatter,
        (np.abs(by_ohm).sum() + 1 / abs(slope)) * 5 / FLAT,  # each reading by half a step
        np.abs(by_t).sum() * 0.05 / FLAT,
        gain * 0.01 / FLAT,  # cancels: one meter reads both
        0.1 / FLAT,
    ])  # fmt: skip
    assert abs(u[3]) < 1e-6
    (estimate,) = estimates(document, "temperature")
    assert_is(estimate, expected, sqrt(u @ u), (u @ u) ** 2 / (scatter**4 / 3))
    (estimate,) = estimates(document, "slope")
    by_ohm, by_t = slopes(lambda y: line(t, y)[1], ohm), slopes(lambda x: line(x, ohm)[1], t)
    u = np.array([s / sqrt(square), np.abs(by_ohm).sum() * 5 / FLAT,
                  np.abs(by_t).sum() * 0.05 / FLAT, slope * 0.01 / FLAT])  # fmt: skip
    assert_is(estimate, slope / 1e3, sqrt(u @ u) / 1e3, (u @ u) ** 2 / (u[0] ** 4 / 3))
    assert verdicts(document) == {"temperature": "conditional fail", "slope": "pass"}


def test_hysteresis_and_nonlinearity_of_transducer(tmp_path):
    """Two rising and two falling series: type A of repeated values, and of residuals of means."""
    force = np.array([0.0, 2.0, 4.0, 6.0, 8.0, 10.0])
    rising = np.array([[0.0001, 0.4003, 0.8008, 1.2007, 1.6005, 2.0001],
                       [0.0000, 0.4001, 0.8007, 1.2009, 1.6004, 2.0003]])  # fmt: skip
    falling = np.array([[0.0004, 0.4012, 0.8019, 1.2016, 1.6010, 2.0001],
                        [0.0005, 0.4013, 0.8016, 1.2017, 1.6011, 2.0003]])  # fmt: skip
    rows, main = [], ""
    for series in range(2):
        for way, values, order in (("up", rising, range(6)), ("down", falling, range(5, -1, -1))):
            pairs = []
            for i in order:
                n = len(rows)
                rows.append(f"f: {force[i]} kN, n: {n} s, u: {values[series][i]} mV")
                pairs.append(f"bench.f: {force[i]} kN, bench.n: {n} s")
            main += f"  - group:\n      label: {{way: {way}}}\n      steps:\n"
            main += "".join(f"  {step}\n" for step in steps(pairs, ["u"]).splitlines())
    document = document_of(
        tmp_path, rows, ["f", "n"],
        ["u, measures: voltage, accuracy: {gain: 0.05 %, resolution: 0.1 µV}",
         "f, measures: force, accuracy: {gain: 0.1 %}"],
        main + """\
analysis:
  - curve:
      of: bench.u
      over: bench.f
      fit: {polynomial: {degree: 1}}
      results:
        slope: {name: sensitivity, unit: mV/kN}
        hysteresis:
          - {name: hysteresis, unit: µV, between: {way: [up, down]}}
          - {name: share, unit: "%", of_span: yes, between: {way: [up, down]}}
        nonlinearity: {name: nonlinearity, unit: nV}
acceptance:
  rule: {guard_band_fraction: {fraction: 0.5}}
  limits:
    - {of: hysteresis, max: 0.00119 mV, source: within by more than U/2}
    - {of: share, max: 0.0585 %, source: within by less than U/2}
""",
    )  # fmt: skip
    x = np.tile(force, 4)
    y = np.concatenate([*rising, *falling])  # in mV
    constant, slope, s, square = line(x, y)
    half_step, gain = 0.05e-3 / FLAT, 0.0005 / FLAT
    differences = falling.mean(axis=0) - rising.mean(axis=0)
    greatest = differences[np.argmax(np.abs(differences))]
    pooled = sqrt(np.mean(np.concatenate([rising, falling], axis=1).var(axis=0, ddof=1)))
    u = np.array([pooled, half_step, half_step, greatest * gain])  # s sqrt(1/2 + 1/2)
    (estimate,) = estimates(document, "hysteresis")
    assert_is(estimate, 1e3 * greatest, 1e3 * sqrt(u @ u), (u @ u) ** 2 / (pooled**4 / 12))
    (estimate,) = estimates(document, "share")
    assert estimate["value"] == pytest.approx(100 * greatest / (10 * slope), rel=1e-9)
    error = np.array([y[x == f].mean() for f in force]) - constant - slope * force
    at = int(np.argmax(np.abs(error)))
    weights = (x == force[at]) / 4 - 1 / 24 - (force[at] - x.mean()) * (x - x.mean()) / square
    u = np.array([s * np.linalg.norm(weights), np.abs(weights).sum() * half_step, error[at] * gain])
    (estimate,) = estimates(document, "nonlinearity")
    assert_is(estimate, 1e6 * abs(error[at]), 1e6 * sqrt(u @ u), (u @ u) ** 2 / (u[0] ** 4 / 22))
    weights = np.abs(x - x.mean()) / square
    u = np.array([s / sqrt(square), weights.sum() * half_step, slope * gain, slope * 0.001 / FLAT])
    (estimate,) = estimates(document, "sensitivity")
    assert_is(estimate, slope, sqrt(u @ u))
    assert verdicts(document) == {"hysteresis": "pass", "share": "fail"}


def test_results_at_two_coordinates_and_from_other_results(tmp_path):
    """R at currents of both signs and two temperatures, its coefficient, and limits of means."""
    volts = {(i, t): 1.0 * i * (1 + 0.004 * (t - 20)) + np.array([-0.002, 0.0, 0.003]) * abs(i)
             for i in (-1, 1, 2) for t in (20, 40)}  # fmt: skip
    rows = [f"i: {i} A, t: {t} °C, n: {n} s, v: {v!r} V"
            for (i, t), values in volts.items() for n, v in enumerate(values.tolist())]  # fmt: skip
    cold_or_hot = "".join(
        f"""\
  - equation:
      result: {{name: {name}, unit: Ω}}
      model: v / i
      inputs: {{v: bench.v, i: bench.i}}
      where: {{bench.t: {t} °C}}
      per: bench.i
"""
        for name, t in (("cold", 20), ("hot", 40))
    )
    document = document_of(
        tmp_path, rows, ["i", "t", "n"],
        ["v, measures: voltage, accuracy: {gain: 0.1 %, resolution: 1 mV}"],
        """\
  - sweep:
      set: bench.i
      over: [-1 A, 1 A, 2 A]
      steps:
        - sweep:
            set: bench.t
            over: [20 °C, 40 °C]
            steps:
              - sweep:
                  set: bench.n
                  over: [0 s, 1 s, 2 s]
                  steps: [{measure: {channels: [bench.v]}}]
analysis:
""" + cold_or_hot + """\
  - equation:
      result: {name: R, unit: Ω}
      model: v / i
      inputs: {v: bench.v, i: bench.i}
      per: [bench.i, bench.t]
  - equation:
      result: {name: alpha, unit: 1/K}
      model: (hot / cold - 1) / (t_hot - t_cold)
      inputs: {hot: hot, cold: cold}
      constants: {t_hot: 40 °C, t_cold: 20 °C}
      per: bench.i
  - readings: {of: bench.v, where: {bench.t: 20 °C}, per: bench.i, result: {name: U, unit: mV}}
acceptance:
  rule: guard_band_u
  limits:
    - {of: R, each: bench.t, where: {bench.i: 1 A}, source: a table, min: 950 mΩ,
       max: {over: bench.t, points: [[0 °C, 1 Ω], [40 °C, 1.082 Ω]]}}
    - {of: alpha, mean: yes, source: a, max: 0.0043 1/K}
    - {of: U, mean: yes, source: a, min: 0.66 V, max: 0.68 V}
""",
    )  # fmt: skip
    gain, step = 0.001 / FLAT, 0.0005 / FLAT
    scatter = {at: values.std(ddof=1) / sqrt(3) for at, values in volts.items()}
    mean = {at: values.mean() for at, values in volts.items()}
    resistances = [result for result in document["results"] if result["name"] == "R"]
    assert len(resistances) == len(volts)
    for result in resistances:
        at = tuple(round(result["coordinates"][f"bench.{name}"]["value"]) for name in "it")
        u = np.array([scatter[at], gain * mean[at], step]) / at[0]
        assert_is(result["estimate"], mean[at] / at[0], sqrt(u @ u), (u @ u) ** 2 / (u[0] ** 4 / 2))
    variances = []
    for i, estimate in zip((-1, 1, 2), estimates(document, "alpha"), strict=True):
        hot, cold = mean[i, 40], mean[i, 20]  # the gain is one and cancels
        u = np.array([scatter[i, 40], step, scatter[i, 20] * hot / cold, step * hot / cold])
        variances.append((u @ u) / (20 * cold) ** 2)
        assert_is(estimate, (hot / cold - 1) / 20, sqrt(variances[-1]))
    parts = {part["of"]: part for part in document["decision"]["parts"]}
    # the resolution error of the display counts as one common error at all places
    u_of_mean = parts["mean U"]["result"]["standard_uncertainty"] / 1e3
    cold = [mean[i, 20] for i in (-1, 1, 2)]
    u_scatter = sqrt(sum(scatter[i, 20] ** 2 for i in (-1, 1, 2))) / 3
    assert parts["mean U"]["result"]["value"] == pytest.approx(1e3 * np.mean(cold), rel=1e-9)
    assert u_of_mean == pytest.approx(
        sqrt(u_scatter**2 + (gain * np.mean(cold)) ** 2 + step**2), rel=1e-5
    )
    assert {name: part["verdict"] for name, part in parts.items()} == {
        "R at bench.i = 1 A, bench.t = 20 °C": "pass",
        "R at bench.i = 1 A, bench.t = 40 °C": "fail",
        "mean alpha": "pass",
        "mean U": "pass",
    }
    assert parts["R at bench.i = 1 A, bench.t = 20 °C"]["upper_limit"]["value"] == pytest.approx(
        1.041
    )
