"""Levels in a model: dBm is a point on a scale, and a difference of two is in dB (IEC 60027-3)."""

from __future__ import annotations

from math import log10, sqrt

import numpy as np
import pytest

from rigrunner.signal.coverage import expanded
from rigrunner_plugins.analyses.equation.settings import EquationSettings
from unit.rigrunner_plugins.equation.helpers_equation import findings, instrument, run_of

UNITS = {"in.level": "dBm", "out.level": "dBm", "pad.loss": "dB", "meter.power": "W"}
INPUTS = {"a": "in.level", "b": "out.level", "L": "pad.loss", "P": "meter.power"}


def objections(model: str, unit: str, **changes):
    used = "\nunused = (a - b)*L*P/number(1, dB)"
    result = {"name": "r", "symbol": "R", "unit": unit}
    settings = {"result": result, "inputs": INPUTS, "model": model + used} | changes
    return list(EquationSettings.model_validate(settings).objections(UNITS))


@pytest.mark.parametrize(
    ("model", "unit"),
    [
        ("R = b - a", "dB"),
        ("R = b - a + L", "dB"),
        ("R = (b - a)/L", "1"),
        ("R = 2*(b - a) + L/2", "dB"),
        ("R = a - L", "dBm"),
        ("R = L + a - number(3, dB)", "dBm"),
        ("R = mean(a, b)", "dBm"),
        ("R = max(a, b) - min(a, b)", "dB"),
        ("R = abs(a - b)", "dB"),
        ("R = number(1, mW)*10^((a - number(0, dBm))/10)", "W"),
        ("R = 10^((a - b)/10)", "%"),
        ("R = 10*log10(P/number(1, mW))", "dB"),
        ("R = number(0, dBm) + 10*log10(P/number(1, mW))", "dBm"),
        ("R = a - L + 10*log10(P/number(1, mW))", "dBm"),
        ("R = P*L/number(1, dB)", "W"),
    ],
)
def test_valid_models_of_levels_are_accepted(model: str, unit: str) -> None:
    assert not objections(model, unit)


@pytest.mark.parametrize(
    ("model", "column", "message", "hint"),
    [
        ("R = a + b", 9, "'b' is added to 'a', and both are power levels", "in dB"),
        ("R = 2*a", 7, "'a' is a power level on a scale", "(a - number(0, dBm)), which is in dB"),
        ("R = a/b", 5, "'a' is a power level on a scale", "number(1, mW) * 10^((a"),
        ("R = -a", 6, "'a' is a power level on a scale", "in dB"),
        ("R = sqrt(a)", 10, "'a' is a power level on a scale", "in dB"),
        ("R = a^2", 5, "'a' is a power level on a scale", "in dB"),
        ("R = 10^(a/10)", 9, "'a' is a power level on a scale", "the power is"),
        ("R = log10(a)", 11, "'a' is a power level on a scale", "in dB"),
        ("R = abs(a)", 9, "'a' is a power level on a scale", "in dB"),
        ("R = L - a", 9, "'a', a power level, is subtracted from 'L', a level", ""),
        ("R = a + P", 9, "'P', a power, is added to 'a', a power level", ""),
        ("R = max(a, L)", 12, "'L', a level, is in max(...) together with 'a', a power", ""),
    ],
)
def test_misuse_of_a_level_is_refused(model: str, column: int, message: str, hint: str) -> None:
    (objection,) = objections(model, "dBm")
    assert objection[0] == ("model",)
    assert message in objection[1]
    assert hint in objection[2]
    assert objection[3] == column


@pytest.mark.parametrize(
    ("model", "unit", "message", "hint"),
    [
        ("R = b - a", "dBm", "got 'dBm', and the model gives a difference", "write dB, or add"),
        ("R = a - L", "dB", "got 'dB', a level; the model gives a power level", ""),
        ("R = a", "W", "got 'W', a power; the model gives a power level", ""),
        ("R = b - a", "%", "got '%', a ratio; the model gives a level", "write dB"),
        ("R = L*2", "1", "got '1', a ratio; the model gives a level", "write dB"),
        ("R = 10*log10(P/number(1, mW))", "dBm", "the model gives a difference", "number(0, dBm)"),
    ],
)
def test_unit_of_levels_must_fit(model: str, unit: str, message: str, hint: str) -> None:
    (objection,) = objections(model, unit)
    assert objection[0] == ("result", "unit")
    assert message in objection[1]
    assert hint in objection[2]


@pytest.mark.parametrize("width", ["5 %", "0.2 dBm"])
def test_constant_in_dbm_has_its_uncertainty_in_db(width: str) -> None:
    constant = {"value": "10 dBm", "u": width}
    (objection,) = objections("R = a - c", "dB", constants={"c": constant})
    assert objection == (("constants", "c", "u"), f"'{width}' is no difference of two power levels",
                     "write it in dB")  # fmt: skip
    assert not objections("R = a - c", "dB", constants={"c": constant | {"u": "0.2 dB"}})


OF_A, OF_B = [-10.02, -9.97, -10.01, -10.04], [-13.11, -13.07, -13.10, -13.04]


def result_of(model: str, unit: str, of: str, constants=None):
    """Return the result of a model of two power meters of ±0.2 dB and ±0.1 dB."""
    run = run_of(
        {"in.level": OF_A, "out.level": OF_B},
        {name: UNITS[name] for name in ("in.level", "out.level")},
        [
            instrument("in.level", "power level", "0.2 dB"),
            instrument("out.level", "power level", {"offset": "0.1 dB"}),
        ],
    )
    settings = {
        "result": {"name": "r", "symbol": "R", "unit": unit},
        "inputs": {name: INPUTS[name] for name in of},
        "constants": constants or {},
        "model": model,
    }
    (result,) = findings(settings, run).results
    return result


def trials(of, *, seed: int = 1, n: int = 1_000_000):
    """Return R of trials of a, b and c: t with 3 degrees of freedom, and the meters' rectangles."""
    rng = np.random.default_rng(seed)
    readings = np.array([OF_A, OF_B])
    # Two means read together: a multivariate t of the covariance of the means (JCGM 101, 6.4.9).
    normal = rng.multivariate_normal([0, 0], np.cov(readings) / 4, n)
    scatter = normal * np.sqrt(3 / rng.chisquare(3, n))[:, None]
    a = np.mean(OF_A) + scatter[:, 0] + rng.uniform(-0.2, 0.2, n)
    b = np.mean(OF_B) + scatter[:, 1] + rng.uniform(-0.1, 0.1, n)
    c = 10 + rng.normal(0, 0.15, n)
    return of(a, b, c)


def test_loss_is_a_difference_of_levels() -> None:
    """-13.08 dBm less -10.01 dBm is -3.07 dB; u² = s²/4 of the differences + 0.2²/3 + 0.1²/3."""
    result = result_of("R = b - a", "dB", "ab")
    differences = np.subtract(OF_B, OF_A)
    assert result.estimate.unit == "dB"
    assert [line.unit for line in result.components[1:]] == ["dB", "dB"]
    assert result.estimate.value == pytest.approx(-3.07)
    u = sqrt(np.var(differences, ddof=1) / 4 + 0.05 / 3)
    assert result.estimate.u == pytest.approx(u, rel=1e-9)
    off = np.abs(trials(lambda a, b, _: b - a) - result.estimate.value)
    # In trials a t of 3 degrees of freedom has three times its u² (JCGM 101, 6.4.9).
    assert expanded(result.estimate) == pytest.approx(np.quantile(off, 0.95), rel=0.03)


def test_level_shifted_by_a_loss_is_a_level() -> None:
    constants = {"c": {"value": "10 dB", "U": "0.3 dB", "k": 2}}
    result = result_of("R = a + c", "dBm", "a", constants)
    assert result.estimate.value == pytest.approx(np.mean(OF_A) + 10)
    u = sqrt(np.var(OF_A, ddof=1) / 4 + 0.04 / 3 + 0.15**2)
    assert result.estimate.u == pytest.approx(u, rel=1e-9)
    off = np.abs(trials(lambda a, _, c: a + c) - result.estimate.value)
    assert expanded(result.estimate) == pytest.approx(np.quantile(off, 0.95), rel=0.02)


def test_power_of_a_level_has_its_relative_uncertainty() -> None:
    """-10.01 dBm is 99.77 µW, and 0.1 dB of it 2.3 %."""
    result = result_of("R = number(1, mW)*10^((a - number(0, dBm))/10)", "mW", "a")
    assert result.estimate.value == pytest.approx(10 ** (np.mean(OF_A) / 10))
    values = trials(lambda a, *_: 10 ** (a / 10))
    inside = np.abs(values - result.estimate.value) <= expanded(result.estimate)
    assert np.mean(inside) == pytest.approx(0.95, abs=0.01)
    scatter = np.var(OF_A, ddof=1) / 4 + 0.04 / 3
    u = result.estimate.value * np.log(10) / 10 * sqrt(scatter)
    assert result.estimate.u == pytest.approx(u, rel=1e-3)


def test_level_of_a_power_has_its_uncertainty_in_db() -> None:
    """2 mW ± 5 %: 3.0103 dBm, and u = 10/ln(10) 5 %/sqrt(3) = 0.125 dB."""
    run = run_of({"meter.power": [2e-3]}, {"meter.power": "W"},
                 [instrument("meter.power", "power", {"gain": "5 %"})])  # fmt: skip
    settings = {
        "result": {"name": "r", "symbol": "R", "unit": "dBm"},
        "inputs": {"P": "meter.power"},
        "model": "R = number(0, dBm) + 10*log10(P/number(1, mW))",
    }
    (result,) = findings(settings, run).results
    assert result.estimate.value == pytest.approx(10 * log10(2))
    assert result.estimate.u == pytest.approx(10 / np.log(10) * 0.05 / sqrt(3), rel=2e-3)
