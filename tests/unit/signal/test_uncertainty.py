from math import inf

import pytest

from rigrunner.api.analysis import Component
from rigrunner.signal.uncertainty import combine, coverage_factor


def component(u, dof=inf):
    return Component("a part", u, dof, "normal", common=False)


def test_gum_h1_end_gauge():
    """GUM (JCGM 100:2008) H.1, Table H.1 and H.1.6: 32 nm, 16 degrees of freedom, k99 = 2.92."""
    parts = [(25, 18), (5.8, 24), (3.9, 5), (6.7, 8), (2.9, 50), (16.6, 2)]
    u, dof = combine(component(*part) for part in parts)
    assert u == pytest.approx(32, abs=0.5)
    assert dof == pytest.approx(16.7, abs=0.1)
    assert coverage_factor(16, 0.99) == pytest.approx(2.92, abs=0.005)


@pytest.mark.parametrize(
    ("dof", "p", "expected"),
    [
        (1, 0.95, 12.706),
        (9, 0.95, 2.262157),
        (10, 0.9545, 2.28),
        (50, 0.99, 2.68),
        (inf, 0.95, 1.96),
    ],
)
def test_student_t(dof, p, expected):
    """GUM Table G.2; t95(9) to seven digits."""
    digits = 5e-7 if expected == 2.262157 else 0.005
    assert coverage_factor(dof, p) == pytest.approx(expected, abs=digits)


def test_parts_with_infinite_dof_give_infinite_dof():
    assert combine([component(3), component(4)]) == (5.0, inf)


def test_zero_part_does_not_reduce_the_dof():
    assert combine([component(0.0, 1), component(2.0, 7)]) == (2.0, pytest.approx(7))


def test_no_parts_give_no_uncertainty():
    assert combine([]) == (0.0, inf)
