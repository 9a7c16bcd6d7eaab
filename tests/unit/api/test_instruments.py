"""The register's entries: accuracy in parts, in one figure or by points; ranges; other channels."""

from __future__ import annotations

from datetime import date
from math import inf, sqrt

import pytest
from pydantic import TypeAdapter, ValidationError

from rigrunner.api.instruments import AnyInstrument, OtherInstrument, TorqueInstrument
from rigrunner.signal.sensor import reading_effects

ENTRY = TypeAdapter(AnyInstrument)
TORQUE = {"channel": "tester.torque", "serial": "T-1", "full_scale": "20 N·m"}
LOAD_CELL = {
    "channel": "tester.load",
    "measures": "force",
    "id": "LC-3",
    "serial": "77",
    "range": {"min": "100 N", "max": "5 kN"},
    "accuracy": "0.1 % FS",
    "due": "2027-01-31",
}
SPLIT = {"gain": "0.3 %", "offset": "0.02 N·m", "drift": "0 N·m", "nonlinearity": "0 %"}
POINTS = [
    {"applied": "-10 N·m", "indicated": "-10.01 N·m", "U": "10 mN·m", "k": 2},
    {"applied": "5 N·m", "indicated": "5.03 N·m", "U": "0.01 N·m"},
    {"applied": "10 N·m", "indicated": "10.02 N·m", "U": "0.015 N·m", "k": 1.5},
]


def test_an_entry_is_a_torque_transducer_unless_it_says_otherwise():
    torque = ENTRY.validate_python(TORQUE | {"accuracy": SPLIT})
    cell = ENTRY.validate_python(LOAD_CELL)

    assert isinstance(torque, TorqueInstrument)
    assert isinstance(cell, OtherInstrument)
    assert (torque.quantity, cell.quantity) == ("torque", "force")
    assert (torque.name, cell.name) == ("T-1", "LC-3")
    assert cell.calibrated_range == (100.0, 5000.0)
    assert cell.due == date(2027, 1, 31)


@pytest.mark.parametrize("text", ["0.5 % FS", "0.5%FS", " .5 % FS "])
def test_an_accuracy_in_one_figure_is_rectangular_over_full_scale(text):
    instrument = TorqueInstrument.model_validate(TORQUE | {"accuracy": text})
    told = {
        each.input.name: each.input
        for each in reading_effects(instrument, zeroed=True)
        if each.sensitivity * each.input.u
    }

    assert set(told) == {"sensor accuracy"}
    accuracy = told["sensor accuracy"]
    assert accuracy.u == pytest.approx(0.1 / sqrt(3), rel=1e-12)
    assert (accuracy.dof, accuracy.distribution) == (inf, "rectangular")


def test_points_give_the_limit_of_error_where_no_accuracy_is_stated():
    instrument = TorqueInstrument.model_validate(TORQUE | {"points": POINTS})

    assert instrument.accuracy.of_full_scale == pytest.approx((0.03 + 0.01) / 20, rel=1e-12)
    assert instrument.points[2].standard_uncertainty == pytest.approx(0.010, rel=1e-12)
    assert instrument.calibrated_range == (-10.0, 10.0)
    both = TorqueInstrument.model_validate(TORQUE | {"points": POINTS, "accuracy": SPLIT})
    assert both.accuracy.gain == pytest.approx(0.003)
    assert both.accuracy.of_full_scale == 0


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, (-20.0, 20.0)),
        ({"range": {"max": "8 N·m"}}, (-8.0, 8.0)),
        ({"range": {"min": "0 N·m", "max": "8 N·m"}}, (0.0, 8.0)),
        ({"points": POINTS[1:]}, (0.0, 10.0)),
    ],
)
def test_the_calibrated_range_of_a_torque_transducer(changes, expected):
    entry = TORQUE | {"accuracy": SPLIT} | changes

    assert TorqueInstrument.model_validate(entry).calibrated_range == expected


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"accuracy": "0.5 %"}, "'0.5 %' is not an accuracy"),
        ({"accuracy": "5 N·m"}, "'5 N·m' is not an accuracy"),
        ({"accuracy": None}, "'accuracy' is missing, or calibration 'points'"),
        ({"accuracy": "0.5 % FS", "range": {"max": "5 N"}}, "range has '5 N', a force"),
        ({"accuracy": "0.5 % FS", "due": "2026-01-01", "calibrated": "2026-01-02"}, "not be after"),
        ({"points": [POINTS[0] | {"U": "-1 N·m"}]}, "U = -1 N·m, expected 0 or more"),
        ({"points": [POINTS[0] | {"indicated": "1 N"}]}, "indicated is '1 N', a force"),
        ({"points": [POINTS[0] | {"k": 0}]}, "greater than 0"),
        ({"accuracy": "1 % FS", "range": {"min": "5 N·m", "max": "5 N·m"}}, "must be below max"),
        ({"accuracy": "1 % FS", "conditions": {"temperature": {"min": "25 °C", "max": "20 °C"}}},
         "min must be below max"),
        ({"accuracy": "1 % FS", "calibration": "none"}, "'simulated', 'recorded' or 'trial'"),
    ],
)  # fmt: skip
def test_an_impossible_torque_transducer_is_refused(changes, words):
    with pytest.raises(ValidationError, match=words):
        ENTRY.validate_python(TORQUE | changes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"measures": "torqe"}, "'torqe' is no quantity"),
        ({"measures": "temperature"}, "measured is a temperature"),
        ({"accuracy": "0.2 °C"}, "is a temperature, not a difference of two"),
        ({"accuracy": "exact"}, "is not a number with a unit"),
        ({"full_scale": "5 kN"}, "Extra inputs"),
    ],
)
def test_an_impossible_other_instrument_is_refused(changes, words):
    with pytest.raises(ValidationError, match=words):
        ENTRY.validate_python(LOAD_CELL | changes)


def test_a_thermometer_has_an_uncertainty_in_kelvin():
    point = {"applied": "20 °C", "indicated": "20.1 °C", "U": "0.2 K"}
    entry = {"channel": "room.temperature", "measures": "temperature", "serial": "9"}
    found = ENTRY.validate_python(entry | {"points": [point]})

    assert found.points[0].deviation == pytest.approx(0.1, abs=1e-9)
    assert found.points[0].standard_uncertainty == pytest.approx(0.1, abs=1e-12)
    with pytest.raises(ValidationError, match="not a difference"):
        ENTRY.validate_python(entry | {"points": [point | {"U": "0.2 °C"}]})
