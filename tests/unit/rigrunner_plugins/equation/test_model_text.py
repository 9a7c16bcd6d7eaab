"""A model is parsed into its equations, or refused with the position in its text."""

from __future__ import annotations

import re
import time

import pytest
from pydantic import ValidationError

from rigrunner_plugins.analyses.equation.settings import EquationSettings

MODEL = "R = U / I * (1 + alpha * (t - t0))"
TOLD = {
    "result": {"name": "resistance", "symbol": "R", "unit": "Ω"},
    "model": MODEL,
    "inputs": {"U": "meter.voltage", "I": "meter.current", "t": "chamber.temperature"},
    "constants": {"alpha": {"value": "0.00393 1/K", "limits": "±0.00002 1/K"}, "t0": "20 °C"},
}
UNITS = {"meter.voltage": "V", "meter.current": "A", "chamber.temperature": "K"}


def settings_of(**changes):
    return EquationSettings.model_validate({**TOLD, **changes})


def refusal(**changes):
    with pytest.raises(ValidationError) as raised:
        settings_of(**changes)
    (error,) = raised.value.errors()
    return error


@pytest.mark.parametrize(
    "model",
    [
        MODEL,
        "U/I*(1 + alpha*(t - t0))",
        "resistance_cold = U/I\nR = resistance_cold*(1 + alpha*(t - t0))",
        "R = U/I\n  * (1 + alpha*(t - number(20, °C)))\n  + 0*number(1, Ω/K)*(t0 - t0)",
        "R = (U^2)^0.5 / sqrt(I^2) * exp(alpha*(t - t0))",
        "R = max(U, -U)/abs(I) + mean(U/I, U/I)*alpha*(min(t, t0) - t0)",
    ],
)
def test_valid_models_are_accepted(model):
    assert not list(settings_of(model=model).objections(UNITS))


HOSTILE = [
    (MODEL + ".real", 35, "FULL STOP"),
    ("().__class__", 3, "FULL STOP"),
    ("__import__('os').system('true')", 1, "LOW LINE"),
    ("eval(U)", 1, "'eval' is not a function"),
    ("open(U)", 1, "'open' is not a function"),
    ("R = U / I\nx = getattr(U, t)", 15, "'getattr' is not a function"),
    ("lambda: U", 1, "'lambda' is a reserved word"),
    ("(x := U)", 4, "COLON"),
    ("f'{U}'", 2, "APOSTROPHE"),
    ("U if t else I", 3, "'if' is a reserved word"),
    ("[U for U in I]", 1, "'\\['"),
    ("U ** 1000000", 6, "is a power out of range"),
    ("U ^ 1000000", 5, "is a power out of range"),
    ("9 ^ 9 ^ 9 ^ 9", 9, "is a power of numbers within a power"),
    ("U**9**9**9**9", 10, "is a power of numbers within a power"),
    ("U + nan", 5, "'nan' is not known"),
    ("U * inf", 5, "'inf' is not known"),
    ("1e999 * U", 1, "is too large a number"),
    ("9" * 400, 1, "is too large a number"),
    ("+".join(["U"] * 10**5), 2001, "the model has 199999 characters"),
    ("-" * 1900 + "U", 102, "nested too deeply"),
    ("(" * 900 + "U" + ")" * 900, 1, "nested too deeply"),
    ("sin(" * 390 + "U" + ")" * 390, 1, "nested too deeply"),
    ("+".join(["U"] * 500), 1, "nested too deeply"),
    ("U / \u0406", 5, "CYRILLIC CAPITAL LETTER BYELORUSSIAN-UKRAINIAN I"),
    ("\uff35 / I", 1, "FULLWIDTH LATIN CAPITAL LETTER U"),
    ("U\u200b / I", 2, "ZERO WIDTH SPACE"),
    ("U / I\u202e", 6, "RIGHT-TO-LEFT OVERRIDE"),
    ("R = U = I", 7, "EQUALS SIGN"),
    ("U == I", 3, "EQUALS SIGN"),
    ("U; I", 2, "SEMICOLON"),
    ("U \\\n I", 3, "REVERSE SOLIDUS"),
    ("number(3, foo) * U", 1, "unknown unit 'foo'"),
    ("number(3,5, V)", 1, "'3 5, V' has more than one number"),
    ("U = I", 1, "'U' is there already"),
    ("U   = I", 1, "'U' is there already"),
    ("R = U\nU\t = I", 7, "'U' is there already"),
    ("sin = U", 1, "'sin' is a name of the language"),
    ("U / I\nR = U", 1, "a formula without a name"),
    ("Q = U / I", 1, "it gives no 'R'"),
    ("\n".join(f"q{n} = U" for n in range(100)), 1, "it has 100 equations"),
    ("", 1, "at least 1 character"),
]


@pytest.mark.parametrize(("model", "column", "message"), HOSTILE)
def test_hostile_models_are_refused_with_their_column_within_a_second(model, column, message):
    start_s = time.process_time()
    error = refusal(model=model)
    assert time.process_time() - start_s < 1
    assert error["loc"] == ("model",)
    assert re.search(message, error["msg"])
    assert getattr(error.get("ctx", {}).get("error"), "column", 1) == column


@pytest.mark.parametrize(
    ("model", "column", "message"),
    [
        ("R = U / I + U", 13, "'U', a voltage, is added to 'U / I', a resistance"),
        ("R = (U - I) / I", 10, "'I', a current, is subtracted from 'U', a voltage"),
        ("R = U / I * (1 + alpha * t)", 26, "'t' is a temperature on a scale"),
        ("R = U / I * exp(alpha)", 17, "'alpha' is a temperature coefficient; exp takes a number"),
        ("R = U / I * sin(t - t0)", 17, "'t - t0' is a difference of temperatures"),
        ("R = U / I ^ alpha", 13, "the power 'alpha' is a temperature coefficient"),
        ("R = I ^ (U/U) * U", 5, "has a power that is not written as a number"),
        ("R = U / I + t + t0", 13, "'t', a temperature, is added to"),
        ("x = t + t0\nR = U/I", 9, "both are temperatures"),
        ("R = U/I*max(t, I)", 16, "'I', a current, is in max"),
        ("R = U/I*atan2(U, I)", 18, "'I', a current, is in atan2"),
        ("R = U/I + number(2, Ω^2)^0.5 + number(1, V)", 32, "'number_2', a voltage"),
        ("R = -t/t0*U/I", 6, "'t' is a temperature on a scale"),
    ],
)
def test_mismatched_kinds_are_reported_at_the_first_column(model, column, message):
    used = "\nunused = U*I*alpha*(t - t0)"
    (objection,) = settings_of(model=model + used).objections(UNITS)
    assert objection[0] == ("model",)
    assert message in objection[1]
    assert objection[3] == column


@pytest.mark.parametrize(
    ("unit", "model", "message"),
    [
        ("V", MODEL, "got 'V', a voltage; the model gives a resistance"),
        ("°C", "R = t - t0 + 0*U/U*I/I*(t - t0)*alpha*(t - t0)", "the model gives a difference"),
        ("Ω", "R = U*I*alpha*(t - t0)", "the model gives a power"),
    ],
)
def test_unit_of_the_result_must_be_that_of_the_model(unit, model, message):
    (objection,) = settings_of(
        result={"name": "r", "symbol": "R", "unit": unit}, model=model
    ).objections(UNITS)
    assert objection[0] == ("result", "unit")
    assert message in objection[1]


@pytest.mark.parametrize(
    ("unit", "model"),
    [
        ("K", "R = t - t0"),
        ("K", "R = (t - t0) + (t - t0)"),
        ("°C", "R = t0 + (t - t0)*U/U"),
        ("°C", "R = number(0, °C) + (t - t0)"),
        ("K", "R = t"),
        ("°F", "R = mean(t, t0)"),
        ("W", "R = U*I"),
        ("N·m", "R = U*I*number(1, s)"),
        ("J", "R = U*I*number(1, s)"),
        ("deg", "R = atan(U/(I*number(1, Ω)))"),
        ("1", "R = U/(I*number(1, Ω))*pi"),
        ("rad/s", "R = 2*pi*number(50, Hz)"),
        ("Hz", "R = number(50, rad/s)/(2*pi)"),
        ("m/s", "R = number(50, rad/s)*number(2, m)"),
        ("V·s^2", "R = U*number(1, s)^2"),
    ],
)
def test_kinds_are_derived_through_the_model(unit, model):
    used = "\nunused = U*I*alpha*(t - t0)"
    settings = settings_of(result={"name": "r", "symbol": "R", "unit": unit}, model=model + used)
    assert not list(settings.objections(UNITS))


@pytest.mark.parametrize(("unit", "model"), [("Hz", "R = number(50, rad/s)"),
                                             ("rad/s", "R = number(50, Hz)")])  # fmt: skip
def test_frequency_is_no_angular_velocity(unit, model):
    used = "\nunused = U*I*alpha*(t - t0)"
    settings_ = settings_of(result={"name": "r", "symbol": "R", "unit": unit}, model=model + used)
    (objection,) = settings_.objections(UNITS)
    assert objection[2] == "between 1/s and rad/s is 2*pi"


def test_ambiguous_temperature_in_kelvin_is_refused():
    (objection,) = settings_of(
        constants={"alpha": "0.1 1/K", "t0": "273.15 K"}, model="R = U/I*alpha*(t - t0)/alpha/t0"
    ).objections(UNITS)
    assert objection[0] == ("constants", "t0")
    assert objection[2] == "write the temperature in °C: 0 °C"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"constants": {"alpha": "1 1/K", "t0": "20 °C", "I": "1 A"}}, "an input and a constant"),
        ({"constants": {"alpha": "1 1/K", "t0": "20 °C", "q": "1 A"}}, "does not use 'q'"),
        ({"inputs": {**TOLD["inputs"], "exp": "a.b"}}, "'exp' is a name of the language"),
        ({"results": [TOLD["result"]]}, "one of 'result' and 'results' is needed"),
        ({"constants": {"alpha": "1 1/K", "t0": {"value": "20 °C", "limits": "1 °C"}}},
         "is a temperature, not a difference"),
        ({"constants": {"alpha": {"value": "1 1/K", "u": "1 K"}, "t0": "20 °C"}},
         "u: '1 K' is a temperature, and the value a temperature coefficient"),
        ({"constants": {"alpha": {"value": "1 1/K", "U": "1 1/K"}, "t0": "20 °C"}},
         "'U' and 'k' belong together"),
        ({"constants": {"alpha": {"value": "1 1/K", "u": "-1 1/K"}, "t0": "20 °C"}},
         "expected more than 0"),
        ({"constants": {"alpha": {"value": "1 1/K", "u": "1 1/K", "limits": "1 1/K"},
                        "t0": "20 °C"}}, "one of limits and u is enough"),
        ({"correlations": [{"between": ["alpha", "U"], "r": 0.5}]}, "an input and a constant"),
        ({"correlations": [{"between": ["alpha", "q"], "r": 0.5}]}, "there is no 'q'"),
        ({"correlations": [{"between": ["alpha", "t0"], "r": 0.5}]}, "exact constant cannot"),
        ({"correlations": [{"between": ["U", "I"], "r": 1.5}]}, "less than or equal to 1"),
    ],
)  # fmt: skip
def test_contradictory_settings_are_refused(changes, message):
    assert message in refusal(**changes)["msg"]
