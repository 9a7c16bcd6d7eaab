"""Readings of any quantity to be expected, against the full scale of their instruments."""

from __future__ import annotations

import pytest

from rigrunner.api.instruments import Instrument
from rigrunner.api.member import Member
from rigrunner.api.planned import ExpectedReading
from rigrunner.plan import predict
from unit.plan.test_making import plan_of


def reading(low, high):
    channel = Member("press", "x")
    return ExpectedReading(recording="001_2Hz", channel=channel, low=low, high=high, text="")


def predicted(expected, **entry):
    readings = [reading(low, high) for low, high in expected]
    instrument = Instrument.model_validate({"channel": "press.x", "serial": "1", **entry})
    return predict(plan_of(), readings, {instrument.channel: instrument})


@pytest.mark.parametrize(
    ("entry", "unit"),
    [
        ({"full_scale": "25 kN"}, "kN"),
        ({"range": {"min": "-25 kN", "max": "25 kN"}}, "kN"),
        ({"full_scale": "25000 N", "range": {"max": "30 kN"}}, "N"),
        ({"points": [{"applied": "25 kN", "indicated": "25 kN", "U": "0.1 kN"}]}, "kN"),
    ],
)
def test_a_force_in_the_unit_of_its_full_scale(entry, unit):
    (force,) = predicted([(-30e3, 10e3)], measures="force", **entry).readings

    scale = {"kN": 1, "N": 1000}[unit]
    assert (force.recording, force.channel, force.unit) == ("001_2Hz", "press.x", unit)
    assert (force.peak, force.full_scale) == pytest.approx((30 * scale, 25 * scale))
    assert force.share == pytest.approx(1.2)


def test_an_instrument_is_overloaded_above_its_full_scale():
    at_most, above = (-25e3, 0.0), (0.0, 25_001.0)
    prediction = predicted([at_most, above], measures="force", full_scale="25 kN")

    assert [overload.peak for overload in prediction.overloads] == [pytest.approx(25.001)]


@pytest.mark.parametrize(
    "entry",
    [
        {"measures": "force"},
        {"measures": "temperature", "full_scale": "180 °C"},
        {"measures": "length", "range": {"min": "-5 mm", "max": "0 mm"}},
    ],
)
def test_a_share_that_would_mean_nothing_is_left_out(entry):
    assert predicted([(0.0, 300.0)], **entry).readings == ()


def test_a_channel_without_an_instrument_is_left_out():
    assert predict(plan_of(), [reading(0.0, 1.0)], {}).readings == ()
