"""Houf and Berman, IEEE Trans. Comp. Hybrids Manuf. Technol. 11 (1988) 516-524: thermal impedance.

10 parts, 3 operators, 3 readings, with a significant interaction. Data and numbers as printed by
Montgomery, Design and Analysis of Experiments, 7th edition, example 13.2 (data also by Vidakovic,
Statistics for Bioengineering Sciences (2011), example 11.14).
"""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner_fleet.trends.gauge_rr import gauge_rr

READINGS = np.array([
    [[37, 38, 37], [41, 41, 40], [41, 42, 41]],
    [[42, 41, 43], [42, 42, 42], [43, 42, 43]],
    [[30, 31, 31], [31, 31, 31], [29, 30, 28]],
    [[42, 43, 42], [43, 43, 43], [42, 42, 42]],
    [[28, 30, 29], [29, 30, 29], [31, 29, 29]],
    [[42, 42, 43], [45, 45, 45], [44, 46, 45]],
    [[25, 26, 27], [28, 28, 30], [29, 27, 27]],
    [[40, 40, 40], [43, 42, 42], [43, 43, 41]],
    [[25, 25, 25], [27, 29, 28], [26, 26, 26]],
    [[35, 34, 34], [35, 35, 34], [35, 34, 35]],
])  # fmt: skip


@pytest.mark.parametrize(
    ("source", "dof", "sum_of_squares", "mean_square", "f"),
    [
        ("part", 9, 3935.96, 437.33, 162.27),
        ("operator", 2, 39.27, 19.63, 7.28),
        ("part x operator", 18, 48.51, 2.70, 5.27),
        ("repeatability", 60, 30.67, 0.51, None),
    ],
)
def test_table_equals_printed_one(source, dof, sum_of_squares, mean_square, f):
    (row,) = [row for row in gauge_rr(READINGS).table if row.source == source]
    assert row.degrees_of_freedom == dof
    assert row.sum_of_squares == pytest.approx(sum_of_squares, abs=5.1e-3)
    assert row.mean_square == pytest.approx(mean_square, abs=5.1e-3)
    assert row.f is None if f is None else row.f == pytest.approx(f, abs=5.1e-3)


def test_components_equal_printed_ones():
    study = gauge_rr(READINGS)
    assert not study.pooled
    sigma = study.components
    sigmas = (sigma.part, sigma.operator, sigma.interaction, sigma.repeatability)
    assert [value**2 for value in sigmas] == pytest.approx([48.29, 0.56, 0.73, 0.51], abs=5.1e-3)
