"""Values and derivatives of formulas, against closed forms and against the complex step."""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner.signal.expression.evaluation import evaluated
from rigrunner.signal.expression.syntax import FUNCTIONS, parse

X = np.array([0.1, 0.35, 0.8])


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name != "abs"])
def test_functions_and_their_derivatives(name):
    """Squire and Trapp, SIAM Review 40(1), 1998: f'(x) = Im f(x + ih)/h."""
    value, slopes = evaluated(parse(f"{name}(x)", {"x"}), {"x": X}, {"x"})
    assert value == pytest.approx(getattr(np, name)(X), rel=1e-15)
    assert slopes["x"] == pytest.approx(getattr(np, name)(X + 1e-30j).imag / 1e-30, rel=1e-13)


FORMULAS = {
    "a*x + b": lambda x, a, b: a * x + b,
    "a - b*x - -x": lambda x, a, b: a - b * x + x,
    "a/(b + x)": lambda x, a, b: a / (b + x),
    "x**a*b": lambda x, a, b: x**a * b,
    "a**x**b": lambda x, a, b: a ** (x**b),
    "(a + x)**-2*b": lambda x, a, b: b / (a + x) ** 2,
    "a*x**b*exp(-b*x)/sqrt(a + x)": lambda x, a, b: a * x**b * np.exp(-b * x) / np.sqrt(a + x),
    "sin(a*x)*cos(b*x) + arctan(x/a)*pi": lambda x, a, b: (
        np.sin(a * x) * np.cos(b * x) + np.arctan(x / a) * np.pi
    ),
}


@pytest.mark.parametrize("text", FORMULAS)
def test_formulas_and_their_derivatives(text):
    values, truth, h = {"x": X, "a": 1.3, "b": 0.7}, FORMULAS[text], 1e-30j
    value, slopes = evaluated(parse(text, values), values, {"a", "b"})
    assert value == pytest.approx(truth(**values), rel=1e-14)
    for name in ("a", "b"):
        stepped = truth(**(values | {name: values[name] + h}))
        expected = stepped.imag / h.imag if np.iscomplexobj(stepped) else np.zeros(3)
        assert np.broadcast_to(slopes.get(name, 0.0), 3) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize(
    ("text", "value", "slopes"),
    [
        ("abs(a)", 2.0, {"a": -1.0}),
        ("atan2(a, b)", -0.5880026035475675, {"a": 3 / 13, "b": 2 / 13}),
        ("min(a, b, 5)", -2.0, {"a": 1.0, "b": 0.0}),
        ("max(a, b, a*b)", 3.0, {"a": 0.0, "b": 1.0}),
        ("mean(a, b, b, 4)", 2.0, {"a": 0.25, "b": 0.5}),
        ("asin(a/4) - ln(b)", -0.5235987755982989 - 1.0986122886681098,
         {"a": 1 / (4 * 0.8660254037844386), "b": -1 / 3}),
    ],
)  # fmt: skip
def test_functions_of_several_numbers_and_those_with_a_corner(text, value, slopes):
    """Closed forms at a = -2, b = 3."""
    values = {"a": -2.0, "b": 3.0}
    result, by = evaluated(parse(text, values), values, values)
    assert result == pytest.approx(value, rel=1e-14)
    assert {name: float(by.get(name, 0.0)) for name in slopes} == pytest.approx(slopes, rel=1e-14)


def test_only_what_is_asked_for_is_differentiated():
    assert set(evaluated(parse("a*x", {"a", "x"}), {"a": 1.0, "x": X}, {"a"})[1]) == {"a"}
    assert evaluated(parse("2*3", ()), {})[0] == 6


def test_a_power_of_zero_has_a_slope():
    """x^b at x = 0 is 0 for every b > 0: its slope by b is 0, and by x it is b x^(b - 1) = 0."""
    values = {"x": np.array([0.0]), "b": 2.0}
    _, slopes = evaluated(parse("x**b", values), values, values)
    assert slopes["b"] == slopes["x"] == 0


def test_what_is_not_defined_is_no_number_and_no_warning():
    values = {"x": np.array([-1.0, 0.0])}
    for text in ("log(x)", "sqrt(x) - 1/x", "x**0.5/x"):
        assert not np.isfinite(evaluated(parse(text, values), values, values)[0]).all()
    assert np.isinf(evaluated(parse("exp(1e9) + 1/0", ()), {})[0])
    assert np.isinf(evaluated(parse("9**99*9**99*9**99*9**99*9**99", ()), {})[0])


def test_extended_precision_is_kept():
    third = np.longdouble(1) / 3
    value, slopes = evaluated(parse("exp(x)*x", {"x"}), {"x": third}, {"x"})
    assert value.dtype == np.longdouble
    assert value == np.exp(third) * third
    assert slopes["x"] == pytest.approx(np.exp(third) * (1 + third), rel=1e-18)
