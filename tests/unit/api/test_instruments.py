"""Register entries: accuracy by errors, as one figure or by points; ranges; any quantity."""

from __future__ import annotations

import re
from datetime import date
from math import inf, sqrt

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner.api.instruments import STORED, Instrument

ENTRY = Instrument
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


def test_entry_is_a_torque_transducer_by_default():
    torque = ENTRY.model_validate(TORQUE | {"accuracy": SPLIT})
    cell = ENTRY.model_validate(LOAD_CELL)

    assert (torque.quantity, cell.quantity) == ("torque", "force")
    assert (torque.name, cell.name) == ("T-1", "LC-3")
    assert cell.calibrated_range == (100.0, 5000.0)
    assert cell.due == date(2027, 1, 31)


def test_points_give_the_limit_of_error_without_accuracy():
    instrument = Instrument.model_validate(TORQUE | {"points": POINTS})

    assert instrument.half_width("overall") == pytest.approx(0.03 + 0.01, rel=1e-12)
    assert instrument.points[2].standard_uncertainty == pytest.approx(0.010, rel=1e-12)
    assert instrument.calibrated_range == (-10.0, 10.0)
    instrument = Instrument.model_validate(TORQUE | {"points": POINTS, "accuracy": SPLIT})
    assert instrument.half_width("gain") == pytest.approx(0.003)
    assert instrument.half_width("overall") == 0


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, (-20.0, 20.0)),
        ({"range": {"max": "8 N·m"}}, (-8.0, 8.0)),
        ({"range": {"min": "0 N·m", "max": "8 N·m"}}, (0.0, 8.0)),
        ({"points": POINTS[1:]}, (0.0, 10.0)),
    ],
)
def test_calibrated_range_of_a_torque_transducer(changes, expected):
    entry = TORQUE | {"accuracy": SPLIT} | changes

    assert Instrument.model_validate(entry).calibrated_range == expected


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"accuracy": "0.5 %"}, "'0.5 %', which does not say of what: write '% FS' or '% reading'"),
        ({"accuracy": "5 N"}, "got '5 N', a force, expected a torque"),
        ({"accuracy": None}, "'accuracy' is missing, or calibration 'points'"),
        ({"accuracy": "0.5 % FS", "range": {"max": "5 N"}}, "got '5 N', a force"),
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
def test_invalid_torque_transducer_is_refused(changes, words):
    with pytest.raises(ValidationError, match=words):
        ENTRY.model_validate(TORQUE | changes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"measures": "torqe"}, "'torqe' is not a quantity"),
        ({"measures": "temperature"}, "got '5 kN', a force, expected a temperature"),
        ({"accuracy": "0.2 °C"}, "is a temperature, not a difference of two"),
        ({"accuracy": "1.8 °F"}, "write it as '1 K'"),
        ({"accuracy": "exact"}, "is not a number with a unit"),
        ({"full_scale": "5 N·m"}, "got '5 N·m', a torque, expected a force"),
    ],
)
def test_invalid_load_cell_is_refused(changes, words):
    with pytest.raises(ValidationError, match=words):
        ENTRY.model_validate(LOAD_CELL | changes)


def test_uncertainty_of_a_thermometer_is_in_kelvin():
    point = {"applied": "20 °C", "indicated": "20.1 °C", "U": "0.2 K"}
    entry = {"channel": "room.temperature", "measures": "temperature", "serial": "9"}
    instrument = ENTRY.model_validate(entry | {"points": [point]})

    assert instrument.points[0].deviation == pytest.approx(0.1, abs=1e-9)
    assert instrument.points[0].standard_uncertainty == pytest.approx(0.1, abs=1e-12)
    with pytest.raises(ValidationError, match="not a difference"):
        ENTRY.model_validate(entry | {"points": [point | {"U": "0.2 °C"}]})


@pytest.mark.parametrize("interpolation", [{}, {"interpolation": "linear"}])
@pytest.mark.parametrize("k", [1, 1.65, 2, 3])
def test_small_coverage_factor_gives_no_smaller_uncertainty(k, interpolation):
    """U/k is the standard uncertainty (GUM 4.3.3); as a rectangle, U alone would be U/√3."""
    points = [{"applied": f"{v} V", "indicated": f"{v} V", "U": "0.1 V", "k": k} for v in (1, 10)]
    entry = {"channel": "meter.voltage", "measures": "voltage", "serial": "9", "points": points}
    (line,) = ENTRY.model_validate(entry | interpolation).reading_errors(5.0)

    assert line.u >= 0.1 / k * (1 - 1e-12)
    assert line.u <= 0.1 / min(k, sqrt(3)) * (1 + 1e-12)


@pytest.mark.parametrize(
    ("quantity", "low", "high", "U", "below"),
    [
        ("temperature", "10 °C", "40 °C", "0.1 K", 263.15),
        ("power level", "-30 dBm", "-10 dBm", "0.1 dB", -5.0),
    ],
)
def test_zero_of_an_offset_scale_is_not_in_the_calibrated_range(quantity, low, high, U, below):  # noqa: N803
    points = [{"applied": value, "indicated": value, "U": U} for value in (low, high)]
    entry = {"channel": "room.x", "measures": quantity, "serial": "9", "points": points}
    instrument = ENTRY.model_validate(entry)

    assert instrument.calibrated_range == tuple(point.applied.si for point in instrument.points)
    assert instrument.beyond_range(below, below, "") != ""
    voltage = [{"applied": "5 V", "indicated": "5 V", "U": "0.1 V"}]
    voltmeter = ENTRY.model_validate(entry | {"measures": "voltage", "points": voltage})
    assert voltmeter.calibrated_range == (0.0, 5.0)


def test_reading_below_the_range_names_its_lower_end():
    points = [{"applied": value, "indicated": value, "U": "0.1 K"} for value in ("10 °C", "40 °C")]
    instrument = ENTRY.model_validate(
        {"channel": "room.x", "measures": "temperature", "serial": "9", "points": points}
    )

    text = instrument.beyond_range(273.15, 300.0, "K")
    assert text == "273.1 K was recorded, the calibration holds from 283.1 K"


THERMOMETER = {
    "channel": "room.temperature",
    "measures": "temperature",
    "serial": "9",
    "interpolation": "linear",
    "points": [
        {"applied": "10 °C", "indicated": "10.2 °C", "U": "0.1 K"},
        {"applied": "20 °C", "indicated": "20.1 °C", "U": "0.1 K"},
        {"applied": "30 °C", "indicated": "30.4 °C", "U": "0.2 K"},
    ],
}
FALLEN = {"applied": "40 °C", "indicated": "19 °C", "U": "1 K"}


def test_readings_are_corrected_between_the_points():
    """A temperature is not mirrored: the deviation of the lowest point applies below it."""
    instrument = Instrument.model_validate(THERMOMETER)
    celsius = np.array([5.0, 10.2, 15.15, 20.1, 25.25, 40.0])
    expected = celsius - [0.2, 0.2, 0.15, 0.1, 0.25, 0.4]
    assert instrument.corrected(celsius + 273.15) - 273.15 == pytest.approx(expected, abs=1e-9)
    # the greatest U, and the middle point off the line from 0.2 K to 0.4 K over 20.2 K
    off = 0.2 + 0.2 * (20.1 - 10.2) / (30.4 - 10.2) - 0.1
    assert instrument.half_width("overall") == pytest.approx(0.2 + off, abs=1e-9)


def test_largest_uncertainty_of_the_points_holds_for_every_reading():
    """Stored runs were computed so; points above the range in use may be left out instead."""
    points = [
        {"applied": f"{newtons} N", "indicated": f"{newtons} N", "U": f"{newtons / 1000} N"}
        for newtons in (10, 100, 1000)
    ]
    cell = {"channel": "tester.load", "measures": "force", "serial": "9", "interpolation": "linear"}
    whole, lower = (Instrument.model_validate(cell | {"points": points[:n]}) for n in (3, 2))
    assert {whole.limit_of_error(value) for value in (5.0, 10.0, 50.0, 1000.0)} == {1.0}
    assert whole.reading_errors(5.0)[0].u == pytest.approx(1 / np.sqrt(3))
    assert (lower.limit_of_error(5.0), lower.calibrated_range) == (0.1, (0.0, 100.0))


@pytest.mark.parametrize(
    ("accuracy", "words"),
    [
        ({"offset": "0.05 K", "drift": "0.1 K"}, "accuracy.offset: the 'points'"),
        ({"nonlinearity": "0.05 K"}, "accuracy.nonlinearity: the 'points'"),
        ("0.15 K", "accuracy '0.15 K' is less than U at 30 °C"),
    ],
)
def test_accuracy_must_not_replace_the_uncertainty_of_correcting_points(accuracy, words):
    """Otherwise U of the points, 0.1 K to 0.2 K, would be missing in the budget of a reading."""
    with pytest.raises(ValidationError, match=re.escape(words)):
        Instrument.model_validate(THERMOMETER | {"accuracy": accuracy})
    Instrument.model_validate(THERMOMETER | {"accuracy": accuracy}, context={STORED: True})


def test_gain_must_not_replace_the_uncertainty_of_torque_points():
    entry = TORQUE | {"points": POINTS, "interpolation": "linear"}
    words = "accuracy.gain: the 'points' that correct the readings give what is left of it, with"
    with pytest.raises(ValidationError, match=words):
        Instrument.model_validate(entry | {"accuracy": {"gain": "0.1 %"}})


def test_correcting_points_allow_other_errors_and_a_greater_limit():
    drifts = Instrument.model_validate(THERMOMETER | {"accuracy": {"drift": "0.3 K"}})
    assert drifts.half_width("drift") == pytest.approx(0.3)
    assert drifts.half_width("overall") > 0.2
    assert Instrument.model_validate(THERMOMETER | {"accuracy": "0.2 K"}).half_width(
        "overall"
    ) == pytest.approx(0.2)


def test_zero_reading_is_corrected_as_well():
    points = [
        {"applied": "0 V", "indicated": "0.1 V", "U": "1 mV"},
        {"applied": "10 V", "indicated": "10.3 V", "U": "1 mV"},
    ]
    entry = {"channel": "m.u", "measures": "voltage", "serial": "1", "points": points}
    linear = Instrument.model_validate(entry | {"interpolation": "linear"})
    # 5.2 V indicated is 5 V, and a zero reading of 0.1 V is 0 V
    assert linear.corrected(np.array([5.2, 10.3]), 0.1) == pytest.approx([5.0, 10.0])
    # a zero reading of 0 V is -0.1 V, and 5 V is 5.1 V above it
    assert linear.corrected(np.array([0.0, 5.2]), 0.0) == pytest.approx([0.0, 5.1], abs=1e-9)
    assert linear.corrected(np.array([5.2])) == pytest.approx([5.0])
    assert Instrument.model_validate(entry).corrected(np.array([5.2]), 0.1) == pytest.approx(5.1)


def test_correction_of_a_force_is_mirrored_about_zero():
    points = [
        {"applied": "1 kN", "indicated": "1.01 kN", "U": "1 N"},
        {"applied": "2 kN", "indicated": "2.03 kN", "U": "1 N"},
    ]
    entry = {"channel": "m.f", "measures": "force", "serial": "1", "points": points}
    instrument = Instrument.model_validate(entry | {"interpolation": "linear"})
    indicated = np.array([-2030.0, -505.0, 0.0, 505.0])
    applied = [-2000.0, -500.0, 0.0, 500.0]
    assert instrument.corrected(indicated + 7.0, 7.0) == pytest.approx(applied)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"interpolation": "cubic"}, "a cubic goes through zero: for a temperature use 'linear'"),
        ({"points": THERMOMETER["points"][:1]}, "interpolation needs 2 points or more"),
        ({"points": [*THERMOMETER["points"], FALLEN]},
         "indicated must rise with applied"),
    ],
)  # fmt: skip
def test_points_unsuitable_for_interpolation_are_refused(changes, words):
    with pytest.raises(ValidationError, match=words):
        Instrument.model_validate(THERMOMETER | changes)


def test_share_of_full_scale_uses_the_full_scale_of_any_instrument():
    cell = {key: LOAD_CELL[key] for key in ("channel", "measures", "serial", "accuracy")}
    instrument = Instrument.model_validate(cell | {"full_scale": "5 kN"})
    assert instrument.half_width("overall") == pytest.approx(5.0)
    assert instrument.calibrated_range == (-inf, 5000.0)
    with pytest.raises(ValidationError, match="got '-5 kN', expected more than 0"):
        Instrument.model_validate(cell | {"full_scale": "-5 kN"})
    with pytest.raises(ValidationError, match="'full_scale' is missing, or a 'range'"):
        Instrument.model_validate({"channel": "a.b", "serial": "1", "accuracy": "0.1 % FS"})


def test_points_replace_the_errors_missing_in_the_accuracy():
    """A drift since the calibration is added to the points; a stated gain replaces them."""
    entry = TORQUE | {"points": POINTS}
    drifted = Instrument.model_validate(entry | {"accuracy": {"drift": "5 mN·m"}})
    assert drifted.half_width("overall") == pytest.approx(0.04)
    assert drifted.half_width("drift") == pytest.approx(0.005)
    stated = Instrument.model_validate(entry | {"accuracy": {"gain": "0.1 %"}})
    assert stated.half_width("overall") == 0


@pytest.mark.parametrize(
    ("stated", "share"), [("0.3 %", 0.003), ("3000 ppm", 0.003), ("0.003 1", 0.003)]
)
def test_bare_share_is_of_reading_for_gain_and_of_full_scale_for_nonlinearity(stated, share):
    parts = {"gain": stated, "nonlinearity": stated}
    instrument = Instrument.model_validate(TORQUE | {"accuracy": parts})
    assert instrument.half_width("gain") == pytest.approx(share, rel=1e-12)
    assert instrument.half_width("nonlinearity") == pytest.approx(20 * share, rel=1e-12)
