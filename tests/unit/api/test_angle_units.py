"""Units of angle, and of quotients of a ratio of voltages."""

from __future__ import annotations

from math import pi

import pytest

from rigrunner.api.units import QuantityError, unit


def test_minutes_and_seconds_of_arc():
    """A full turn is 21600' and 1296000\" (SI brochure, table 8)."""
    assert 21600 * unit("arcmin").factor == pytest.approx(2 * pi, rel=1e-15)
    assert 1296000 * unit("arcsec").factor == pytest.approx(2 * pi, rel=1e-15)


@pytest.mark.parametrize(
    ("written", "meant"), [("mV/V/kN", "mV/(V·kN)"), ("W/m²/K", "W/(m²·K)"), ("m/s/s", "m/(s·s)")]
)
def test_of_two_fraction_bars_the_unit_with_one_is_named(written, meant):
    """Two would be ambiguous (SI brochure, 5.2); 'mV/V' was suggested."""
    with pytest.raises(QuantityError) as error:
        unit(written)
    assert error.value.hint == f"did you mean '{meant}'?"
    assert unit(meant)
