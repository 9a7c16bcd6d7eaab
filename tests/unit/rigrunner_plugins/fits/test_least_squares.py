from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigrunner.api.errors import DataError
from rigrunner_plugins.fits.least_squares import solve


def extended(values):
    return np.array(values, np.longdouble)


def test_a_line_through_three_points():
    """By hand: y = 1/3 + x/2 leaves -1/3... of (0,0), (1,1), (2,1): slope 1/2, intercept 1/6."""
    solution = solve(extended([[1, 0], [1, 1], [1, 2]]), extended([0, 1, 1]))
    assert solution.coefficients.astype(float) == pytest.approx([1 / 6, 1 / 2], abs=1e-17)
    assert solution.residuals.astype(float) == pytest.approx([-1 / 6, 1 / 3, -1 / 6], abs=1e-17)
    assert solution.dof == 1
    assert solution.residual_s == pytest.approx((1 / 6) ** 0.5)


def test_the_factor_is_a_root_of_the_inverse_normal_matrix():
    design = extended([[1, 0], [1, 1], [1, 3], [1, 4]])
    factor = solve(design, extended([0, 1, 1, 5])).factor
    # X'X = [[4, 8], [8, 26]], its inverse [[26, -8], [-8, 4]] / 40
    assert factor @ factor.T == pytest.approx(np.array([[0.65, -0.2], [-0.2, 0.1]]), abs=1e-15)


def test_columns_of_very_different_size_are_no_obstacle():
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


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_no_number_is_refused(bad):
    with pytest.raises(DataError, match="not a finite number"):
        solve(extended([[1, 0], [1, 1], [1, 2]]), extended([0, bad, 1]))


@settings(deadline=None, max_examples=50)
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
