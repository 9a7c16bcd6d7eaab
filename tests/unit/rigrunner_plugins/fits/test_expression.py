"""Curves of a user's own formula: settings, refusals, several variables, nonlinear minima."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner_plugins.fits.expression import ExpressionFit
from rigrunner_plugins.fits.settings import ExpressionSettings, Start

GROWTH = {"model": "a*exp(b*f)", "start": {"a": "1 N·m", "b": 0.1}}
X = np.linspace(1.0, 10.0, 12)


def fit(points, **settings):
    return ExpressionFit(ExpressionSettings(**(GROWTH | settings)))(points)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"model": "a*exp(b*g)"}, "column 9: 'g' is not known"),
        ({"model": "a + f"}, "it does not have 'b'"),
        ({"model": "a*exp(b)"}, "it does not have 'f'"),
        ({"over": ["a"]}, "'a': a variable and a parameter"),
        ({"over": []}, "at least 1 item"),
        ({"over": ["f", "f"]}, "f is listed 2 times"),
        ({"start": {}}, "at least 1 item"),
        ({"start": {"a": "one", "b": 1}}, "'one' is not a number"),
        ({"start": {"a": True, "b": 1}}, "'True' is not a number"),
        ({"start": {"a": "1e999", "b": 1}}, "'1e999' is not a number"),
        ({"start": {"a": "1 N m", "b": 1}}, "'1 N m' is not a number, nor a number with its unit"),
        ({"start": [1, 2]}, "dictionary|mapping"),
    ],
)
def test_invalid_settings_are_refused(changes, message):
    with pytest.raises(ValidationError, match=message):
        ExpressionSettings(**(GROWTH | changes))


def test_start_values_have_units():
    start = ExpressionSettings(model="a*f + b", start={"a": "-5e-4 N·m/Hz", "b": 3}).start
    assert start == {"a": Start(-5e-4, "N·m/Hz"), "b": Start(3.0, "1")}
    curve = fit(Points(X, 2 * np.exp(0.3 * X)))
    assert tuple(curve.units) == ("N·m", "1")
    assert curve.coefficients == pytest.approx([2, 0.3], rel=1e-13)


def test_several_variables_are_in_the_order_of_the_points():
    x = np.random.default_rng(4).uniform(1, 2, (20, 2))
    y = 3 + 2 * x[:, 0] / x[:, 1] ** 2
    points = Points(x, y, regressors=("load", "speed"))
    settings = {"model": "c + k*load/speed**2", "start": {"c": 1, "k": 1}}
    curve = fit(points, over=["speed", "load"], **settings)
    assert curve.coefficients == pytest.approx([3, 2], rel=1e-13)
    value, u = curve.predict(np.array([[1.5, 1.2], [1.2, 1.5]]))
    assert value == pytest.approx([3 + 3 / 1.44, 3 + 2.4 / 2.25], rel=1e-13)
    assert u.shape == (2,)
    with pytest.raises(DataError, match=r"holds from 1\.\d+ to 1\.\d+ of speed, not at 2\.5"):
        curve.predict(np.array([[1.5, 2.5]]))
    with pytest.raises(DataError, match="the model is over f; the points have load, speed"):
        fit(points)
    with pytest.raises(DataError, match="the model is over load, speed; the points have one"):
        fit(Points(X, X), over=["load", "speed"], **settings)


def test_linear_formula_is_linear_least_squares():
    """Against the normal equations, from any start; the prediction's u as x (X'X)^-1 x' s²."""
    y = 1 + 0.5 * X + np.random.default_rng(7).normal(0, 0.1, len(X))
    design = np.column_stack([np.ones(len(X)), X])
    coefficients, rss, *_ = np.linalg.lstsq(design, y, rcond=None)
    inverse = np.linalg.inv(design.T @ design) * rss[0] / (len(X) - 2)
    curve = fit(Points(X, y), model="a + b*f", start={"a": -1e6, "b": 1e6})
    assert curve.coefficients == pytest.approx(coefficients, rel=1e-12)
    assert curve.covariance == pytest.approx(inverse, rel=1e-10)
    at = np.array([1.0, 5.5])
    rows = np.column_stack([np.ones(2), at])
    assert curve.predict(at)[1] == pytest.approx(
        np.sqrt(np.diag(rows @ inverse @ rows.T)), rel=1e-10
    )


@pytest.mark.parametrize(
    ("settings", "y", "message"),
    [
        ({"model": "a*log(f - b)", "start": {"a": 1, "b": 5}}, X, "not defined at its start"),
        ({"model": "a*b*f", "start": {"a": 1, "b": 1}}, X, "do not determine all coefficients"),
        ({"model": "a*exp(-f/b)", "start": {"a": 1, "b": 1}}, 1 + 0 * X, "converge|determine"),
    ],
)
def test_formula_that_cannot_be_fitted_is_refused(settings, y, message):
    with pytest.raises(DataError, match=message):
        fit(Points(X, y), **settings)


def test_repeated_points_do_not_count():
    with pytest.raises(DataError, match="need 3 different points, got 2"):
        fit(Points(np.repeat([1.0, 2.0], 5), np.ones(10)))
