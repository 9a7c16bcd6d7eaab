"""Coverage factors against JCGM 100:2008, Table G.2, and against more digits of t."""

from __future__ import annotations

from math import inf

import pytest

from rigrunner.signal.uncertainty import coverage_factor


@pytest.mark.parametrize(
    ("dof", "p", "k"),
    [
        (1, 0.95, 12.71),
        (2, 0.95, 4.30),
        (5, 0.95, 2.57),
        (10, 0.95, 2.23),
        (50, 0.95, 2.01),
        (inf, 0.95, 1.960),
        (1, 0.99, 63.66),
        (16, 0.99, 2.92),
        (inf, 0.99, 2.576),
    ],
)
def test_coverage_factors_of_table_g_2(dof, p, k):
    assert coverage_factor(dof, p) == pytest.approx(k, abs=0.006)


def test_coverage_factor_of_nine_degrees_of_freedom():
    assert coverage_factor(9) == pytest.approx(2.262157, abs=5e-7)
