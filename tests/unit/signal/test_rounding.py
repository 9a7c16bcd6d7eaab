from __future__ import annotations

import pytest

from rigrunner.signal.rounding import places_of_margin, with_uncertainty


@pytest.mark.parametrize(
    ("value", "expanded", "text"),
    [
        (0.590935, 0.0920974, "0.591 ± 0.092"),
        (0.72619, 0.00996, "0.726 ± 0.010"),  # 0.00996 rounds up to two digits
        (0.72619, 0.0996, "0.73 ± 0.10"),
        (12.34, 3.21, "12.3 ± 3.2"),
        (1234.5, 123.0, "1230 ± 120"),  # as on a certificate
        (98765.4, 99600.0, "100000 ± 100000"),
        (5.2, 9.96, "5 ± 10"),
        (-0.001, 0.1, "0.00 ± 0.10"),  # no negative zero
        (-0.4, 96.0, "0 ± 96"),
        (0.72, float("inf"), "0.72 ± inf"),
        (0.72, 0.0, "0.72 ± 0"),
    ],
)
def test_value_and_uncertainty_have_the_same_decimals(value, expanded, text):
    assert with_uncertainty(value, expanded) == text


@pytest.mark.parametrize(
    ("decimals", "unit", "expected"),
    [(3, "N·m", 4), (5, "N·m", 4), (6, "N·m", 5), (-1, "N·m", 4), (3, "mN·m", 3), (1, "V", 1)],
)
def test_decimals_of_a_margin(decimals, unit, expected):
    """In N·m to 0.1 mN·m, as in 0.1.0, or to one digit of a smaller U."""
    assert places_of_margin(decimals, unit) == expected
