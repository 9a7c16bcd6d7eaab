from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from reference.helpers_exact import exact_least_squares
from rigrunner.api.errors import DataError
from rigrunner_plugins.fits.least_squares import solve


def extended(values):
    return np.array(values, np.longdouble)


def test_line_through_three_points_is_solved_exactly():
    """By hand for (0,0), (1,1), (2,1): slope 1/2, intercept 1/6."""
    solution = solve(extended([[1, 0], [1, 1], [1, 2]]), extended([0, 1, 1]))
    assert solution.coefficients.astype(float) == pytest.approx([1 / 6, 1 / 2], abs=1e-17)
    assert solution.residuals.astype(float) == pytest.approx([-1 / 6, 1 / 3, -1 / 6], abs=1e-17)
    assert solution.dof == 1
    assert solution.residual_s == pytest.approx((1 / 6) ** 0.5)


def test_factor_is_a_root_of_the_inverse_normal_matrix():
    design = extended([[1, 0], [1, 1], [1, 3], [1, 4]])
    factor = solve(design, extended([0, 1, 1, 5])).factor
    # X'X = [[4, 8], [8, 26]], its inverse [[26, -8], [-8, 4]] / 40
    assert factor @ factor.T == pytest.approx(np.array([[0.65, -0.2], [-0.2, 0.1]]), abs=1e-15)


def test_columns_of_very_different_size_are_solved():
    x = np.linspace(1, 2, 9).astype(np.longdouble)
    design = np.stack([np.ones_like(x), 1e-9 * x, 1e9 * x**2], axis=1)
    coefficients = solve(design, design @ extended([3, 2e9, 1e-9])).coefficients
    assert coefficients.astype(float) == pytest.approx([3, 2e9, 1e-9], rel=1e-12)


def test_as_many_coefficients_as_points_are_refused():
    with pytest.raises(DataError, match="2 points cannot give 2 coefficients"):
        solve(extended([[1, 0], [1, 1]]), extended([0, 1]))


@pytest.mark.parametrize("column", [[2, 2, 2], [0, 0, 0]])
def test_dependent_columns_are_refused(column):
    design = extended([[1, value] for value in column])
    with pytest.raises(DataError, match="do not determine all coefficients"):
        solve(design, extended([0, 1, 2]))


@pytest.mark.parametrize(("difference", "refused"), [(2.0**-44, True), (2.0**-33, False)])
def test_columns_that_differ_by_less_than_1e_12_are_refused(difference, refused):
    """Columns that differ by d in one of three values leave sqrt(2)/3 d orthogonal to the first."""
    design = extended([[1, 1], [1, 1], [1, 1 + difference]])
    if refused:
        with pytest.raises(DataError, match="do not determine all coefficients"):
            solve(design, extended([1, 2, 3]))
    else:
        coefficients = solve(design, extended([1, 2, 3])).coefficients.astype(float)
        slope = 1.5 / difference
        assert coefficients == pytest.approx([1.5 - slope, slope], rel=1e-8)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_nan_and_infinity_are_refused(value):
    with pytest.raises(DataError, match="not a finite number"):
        solve(extended([[1, 0], [1, 1], [1, 2]]), extended([0, value, 1]))


@settings(deadline=None, max_examples=examples(50))
@given(
    st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=12),
    st.floats(-100, 100),
)
def test_residuals_are_orthogonal_to_the_design(y, shift):
    x = np.arange(len(y), dtype=np.longdouble) + np.longdouble(shift)
    design = np.stack([np.ones_like(x), x], axis=1)
    residuals = solve(design, extended(y)).residuals
    scale = np.abs(design).sum(axis=0) * (np.abs(y).max() + 1)
    assert np.all(np.abs(design.T @ residuals) <= 1e-15 * scale)


EPS = float(np.finfo(np.longdouble).eps)
INTEGERS = st.integers(-(10**6), 10**6)


@st.composite
def powers_of_distant_numbers(draw):
    """Return powers 0..p-1 of integers far from zero: condition numbers up to 1e13."""
    p = draw(st.integers(2, 5))
    offset = draw(st.sampled_from([0, 10, 100, 1000]))
    steps = draw(st.sets(st.integers(0, 60), min_size=p + 1, max_size=14))
    return [[(offset + step) ** k for k in range(p)] for step in sorted(steps)]


@st.composite
def nearly_equal_columns(draw):
    """Return columns that differ by a few units in 10^k of them."""
    p = draw(st.integers(2, 5))
    size = 10 ** draw(st.integers(0, 12))
    few = st.integers(-5, 5)
    rows = st.tuples(st.integers(-99, 99), st.lists(few, min_size=p, max_size=p))
    return [
        [common * size + small for small in small_row]
        for common, small_row in draw(st.lists(rows, min_size=p + 1, max_size=14))
    ]


@settings(deadline=None, max_examples=examples(150))
@given(data=st.data(), design=st.one_of(powers_of_distant_numbers(), nearly_equal_columns()))
def test_ill_conditioned_designs_against_rational_arithmetic(data, design):
    """Errors stay below 2 k eps of the coefficients or, if larger, of their uncertainty.

    k is the condition number; coefficients are those of columns of unit length, in norm. Of 600
    random designs with k up to 3e12 the worst were 0.5 k eps, and 0.3 k eps for the variances.
    Refused designs have k of 1e12 or more.
    """
    y = data.draw(st.lists(INTEGERS, min_size=len(design), max_size=len(design)))
    if data.draw(st.booleans()):
        y = [sum(row) + value % 7 for row, value in zip(design, y, strict=True)]
    try:
        exact = exact_least_squares(design, y)
    except ZeroDivisionError:
        with pytest.raises(DataError, match="do not determine all coefficients"):
            solve(extended(design), extended(y))
        return
    k, dof = exact.condition, len(y) - len(design[0])
    try:
        solution = solve(extended(design), extended(y))
    except DataError:
        assert k >= 1e12
        return
    scale = np.array([float(row[i]) ** 0.5 for i, row in enumerate(exact.normal)])
    error = scale * errors(solution.coefficients, exact.coefficients)
    size = np.linalg.norm(scale * [float(value) for value in exact.coefficients])
    uncertainty = k * (float(exact.rss) / dof) ** 0.5
    assert np.linalg.norm(error) <= 2 * k * EPS * max(size, uncertainty)
    variances = np.sum(solution.factor**2, axis=1)
    relative = errors(variances, [row[i] for i, row in enumerate(exact.inverse)], relative=True)
    assert np.abs(relative).max() <= (2 * k + 100) * EPS


def errors(result, exact, *, relative=False):
    """Return result - exact without rounding either, as floats."""
    differences = [in_full(value) - expected for value, expected in zip(result, exact, strict=True)]
    if relative:
        differences = [error / value for error, value in zip(differences, exact, strict=True)]
    return np.array([float(difference) for difference in differences])


def in_full(value):
    """Return a long double as a fraction: its two halves are floats."""
    high = float(value)
    return Fraction(high) + Fraction(float(value - np.longdouble(high)))
