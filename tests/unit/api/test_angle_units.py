"""Units of angle, and units with two fraction bars."""

from __future__ import annotations

from math import pi

import pytest

from rigrunner.api.units import QuantityError, unit


def test_arcminutes_and_arcseconds_of_a_full_turn():
    """A full turn is 21600' and 1296000\" (SI brochure, table 8)."""
    assert 21600 * unit("arcmin").factor == pytest.approx(2 * pi, rel=1e-15)
    assert 1296000 * unit("arcsec").factor == pytest.approx(2 * pi, rel=1e-15)


@pytest.mark.parametrize(
    ("written", "hint"), [("mV/V/kN", "mV/(V·kN)"), ("W/m²/K", "W/(m²·K)"), ("m/s/s", "m/(s·s)")]
)
def test_two_fraction_bars_suggest_the_unit_with_one(written, hint):
    """Two are ambiguous (SI brochure, 5.2); an earlier version suggested 'mV/V'."""
    with pytest.raises(QuantityError) as error:
        unit(written)
    assert error.value.hint == f"did you mean '{hint}'?"
    assert unit(hint)
