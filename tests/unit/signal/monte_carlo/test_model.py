"""Inputs of a measurement model, drawn independently or jointly."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import pytest
from scipy import stats

from rigrunner.api.uncertainty import Distribution, Input, MeasurementModel
from rigrunner.signal.monte_carlo.model import output_of

N = 200_000


def drawn(inputs, equation, correlation=None):
    model = MeasurementModel(tuple(inputs), equation, correlation)
    return output_of(model)(np.random.default_rng(3), N)


def difference(x):
    return x["a"] - x["b"]


def test_independent_inputs():
    values = drawn([Input("a", 2.0, 0.3), Input("b", 1.0, 0.4)], difference)
    assert values.mean() == pytest.approx(1.0, abs=0.01)
    assert values.std() == pytest.approx(0.5, rel=0.01)


def test_correlation_reduces_the_scatter_of_a_difference():
    r = np.array([[1.0, 0.8], [0.8, 1.0]])
    values = drawn([Input("a", 2.0, 0.3), Input("b", 1.0, 0.4)], difference, r)
    assert values.std() == pytest.approx(sqrt(0.09 + 0.16 - 2 * 0.8 * 0.12), rel=0.01)


def test_inputs_of_one_ensemble_are_jointly_t():
    """Jointly t, though uncorrelated: the sum of squares over 2 is F of (2, dof)."""
    inputs = [Input(name, 0.0, 1.0, 5.0, ensemble="fit") for name in "ab"]
    values = drawn(inputs, lambda x: (x["a"] ** 2 + x["b"] ** 2) / 2, np.eye(2))[:20_000]
    assert stats.kstest(values, stats.f(2, 5).cdf).pvalue > 0.001


def test_inputs_correlated_through_a_third_are_drawn_jointly():
    r = np.array([[1.0, 0.0, 0.6], [0.0, 1.0, 0.6], [0.6, 0.6, 1.0]])
    inputs = [Input(name, 0.0, 1.0) for name in "abc"]
    values = drawn(inputs, lambda x: x["a"] + x["b"] - x["c"], r)
    assert values.var() == pytest.approx(3 - 4 * 0.6, rel=0.02)


def test_shapes_of_inputs_and_of_a_constant():
    values = drawn([Input("a", 0.0, 1.0, inf, Distribution.RECTANGULAR)], lambda x: x["a"])
    assert abs(values).max() <= sqrt(3)
    assert drawn([], lambda _: np.array(4.0)).tolist() == [4.0] * N
