from __future__ import annotations

import pytest

from rigrunner.signal.rounding import with_uncertainty


@pytest.mark.parametrize(
    ("value", "expanded", "text"),
    [
        (0.590935, 0.0920974, "0.591 ± 0.092"),
        (0.72619, 0.00996, "0.726 ± 0.010"),  # 0.00996 rounds up to two digits
        (0.72619, 0.0996, "0.73 ± 0.10"),
        (12.34, 3.21, "12.3 ± 3.2"),
        (1234.5, 123.0, "1234 ± 123"),
        (0.72, float("inf"), "0.72 ± inf"),
        (0.72, 0.0, "0.72 ± 0"),
    ],
)
def test_value_and_uncertainty_end_at_the_same_place(value, expanded, text):
    assert with_uncertainty(value, expanded) == text
