"""Quantities that a station declares: units, scales and limits."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from rigrunner.api.unit_tables import UNITS
from rigrunner_plugins.devices.declared import DeclaredChannel, DeclaredDrive

FREQUENCY = {
    "unit": "rpm",
    "scale": 0.1,
    "min": "0 Hz",
    "max": "35 Hz",
    "safe": "0 Hz",
    "rate": "300 rpm/s",
    "settle": "3 s",
    "tolerance": "6 rpm",
    "sets_cycle_frequency": True,
}


def test_number_is_scaled_before_its_unit_is_converted():
    channel = DeclaredChannel(unit="mN·m", scale=2.0, offset=-1.0)
    assert channel.to_si(500.5) == pytest.approx(1.0)  # 500.5 * 2 - 1 = 1000 mN·m
    assert channel.si_unit == "N·m"


def test_temperatures_are_in_kelvin():
    assert DeclaredChannel(unit="°C").to_si(20.0) == pytest.approx(293.15)


@given(
    unit=st.sampled_from([u.symbol for u in UNITS]),
    scale=st.floats(1e-3, 1e3) | st.floats(-1e3, -1e-3),
    offset=st.floats(-1e3, 1e3),
    number=st.floats(-1e6, 1e6),
)
def test_from_si_inverts_to_si(unit, scale, offset, number):
    quantity = DeclaredChannel(unit=unit, scale=scale, offset=offset)
    restored = quantity.from_si(quantity.to_si(number))
    assert restored == pytest.approx(number, rel=1e-6, abs=1e-6 * (1 + abs(offset / scale)) * 1e3)


def test_drive_is_described_in_si():
    info = DeclaredDrive(**FREQUENCY).info("frequency")
    assert (info.unit, info.minimum, info.maximum) == ("Hz", 0.0, 35.0)
    assert info.rate_per_s == pytest.approx(5.0)
    assert info.tolerance == pytest.approx(0.1)
    assert info.longest_s == pytest.approx(10.0)
    assert info.sets_cycle_frequency


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scale": 0}, "scale is 0"),
        ({"max": "35 N"}, "a force; expected a frequency"),
        ({"rate": "5 N/s"}, "expected a frequency rate above 0"),
        ({"rate": "0 Hz/s"}, "above 0"),
        ({"safe": "40 Hz"}, "min <= safe <= max"),
        ({"min": "35 Hz", "safe": "35 Hz"}, "min <= safe <= max"),
        ({"unit": "rmp"}, "unknown unit 'rmp'"),
    ],
)
def test_settings_that_do_not_fit_are_refused(change, message):
    with pytest.raises(ValidationError, match=message):
        DeclaredDrive(**{**FREQUENCY, **change})
