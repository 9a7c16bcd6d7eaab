"""What must hold of the fit old_fit."""

from collections.abc import Callable

import numpy as np
import pytest
from rigrunner.api.data import Points

import rigrunner_old_fit as plugin


@pytest.mark.conformance("fit", "old_fit")
def test_it_keeps_to_what_every_fit_keeps_to(conformance: Callable[[], None]) -> None:
    """One test for each check of the conformance kit; what does not apply is skipped."""
    conformance()


def test_it_gives_the_known_answer() -> None:
    """Of 1, 3 and 8 at 0, 1 and 2 Hz, by hand: 0.5 + 3.5 f, residuals 0.5, -1 and 0.5."""
    curve = plugin.fit(Points(np.array([0.0, 1.0, 2.0]), np.array([1.0, 3.0, 8.0])))
    assert curve.coefficients == pytest.approx([0.5, 3.5])
    assert curve.residuals == pytest.approx([0.5, -1.0, 0.5])
    assert curve.residual_s == pytest.approx(1.5**0.5)
    assert curve.units == ("N·m", "N·m/Hz")
