"""The errors of a reading, one by one, for an instrument of any quantity.

Half-widths become standard uncertainties by GUM 4.3.7, 4.3.9 and 4.4.6: over √3, √6 and √2.
"""

from __future__ import annotations

from math import inf, sqrt

import pytest
from pydantic import ValidationError

from rigrunner.api.instruments import STORED, Instrument

ENTRY = Instrument
METER = {
    "channel": "meter.resistance",
    "measures": "resistance",
    "serial": "R-1",
    "certificate": "C-17",
    "range": {"max": "200 Ω"},
    "accuracy": {
        "gain": "0.01 %",
        "offset": {"limit": "0.005 % FS", "distribution": "normal", "source": "data sheet"},
        "resolution": "1 mΩ",
        "drift": {"limit": "0.02 % reading", "distribution": "triangular"},
        "temperature": {"limit": "2 mΩ", "per": "1 K", "within": "5 K"},
    },
}


def errors_by_name(instrument, value, **options):
    return {error.name: error for error in instrument.reading_errors(value, **options)}


def test_each_error_has_its_distribution_and_source():
    errors = errors_by_name(ENTRY.model_validate(METER), 120.0)

    assert list(errors) == [
        *("gain of meter.resistance", "offset of meter.resistance"),
        *("drift of meter.resistance", "resolution of meter.resistance"),
        "temperature of meter.resistance",
    ]
    gain, offset, drift, resolution, temperature = errors.values()
    assert (gain.acts, offset.acts, drift.acts) == ("gain", "offset", "each")
    assert gain.u == pytest.approx(1e-4 / sqrt(3))
    assert gain.at(-120.0) == pytest.approx(120 * 1e-4 / sqrt(3))
    assert drift.at(7.0) == drift.u
    assert offset.u == pytest.approx(0.005e-2 * 200 / 2)
    assert (offset.distribution, offset.source) == ("normal", "data sheet")
    assert resolution.u == pytest.approx(1e-3 / 2 / sqrt(3))
    assert drift.u == pytest.approx(0.02e-2 * 120 / sqrt(6))
    assert temperature.u == pytest.approx(2e-3 * 5 / sqrt(3))
    assert {error.dof for error in errors.values()} == {inf}


def test_zeroing_removes_the_offset_error():
    errors = errors_by_name(ENTRY.model_validate(METER), 120.0, zeroed=True)

    assert "offset of meter.resistance" not in errors
    assert "gain of meter.resistance" in errors


def test_limit_of_error_is_the_sum_of_all_limits():
    limit = ENTRY.model_validate(METER).limit_of_error(-120.0)

    assert limit == pytest.approx(0.012 + 0.01 + 0.0005 + 0.024 + 0.01)


@pytest.mark.parametrize(
    ("changes", "u", "source"),
    [
        ({"accuracy": "0.1 % FS"}, 0.2 / sqrt(3), ""),
        ({"accuracy": "0.1 % reading"}, 0.12 / sqrt(3), ""),
        ({"accuracy": "50 mΩ"}, 0.05 / sqrt(3), ""),
        ({"accuracy": None, "points": [
            {"applied": "100 Ω", "indicated": "100.03 Ω", "U": "20 mΩ", "k": 2},
            {"applied": "200 Ω", "indicated": "199.99 Ω", "U": "20 mΩ", "k": 2},
        ]}, 0.05 / sqrt(3), "C-17"),
    ],
)  # fmt: skip
def test_overall_accuracy_or_points_give_one_error(changes, u, source):
    (error,) = ENTRY.model_validate(METER | changes).reading_errors(120.0)

    assert (error.name, error.acts) == ("reading of meter.resistance", "each")
    assert error.u == pytest.approx(u)
    assert (error.distribution, error.source) == ("rectangular", source)


def test_entry_without_accuracy_has_no_errors():
    entry = {key: METER[key] for key in ("channel", "measures", "serial")}
    assert ENTRY.model_validate(entry).reading_errors(1.0) == ()


@pytest.mark.parametrize(
    ("accuracy", "message"),
    [
        ({}, "got nothing, expected one of: overall, gain, offset"),
        ({"gain": "1 Ω"}, "gain: got '1 Ω', expected a share, such as '0.3 %'"),
        ({"offset": "1 V"}, "offset: got '1 V', a voltage, expected a resistance"),
        ({"drift": "0.1 %"}, "drift: got '0.1 %', which does not say of what"),
        ("0.5 %", "got '0.5 %', which does not say of what: write '% FS' or '% reading'"),
        ("300 ppm", "got '300 ppm', which does not say of what"),
        ("0.2 N", "got '0.2 N', a force, expected a resistance"),
    ],
)
def test_invalid_accuracy_is_refused(accuracy, message):
    with pytest.raises(ValidationError) as caught:
        ENTRY.model_validate(METER | {"accuracy": accuracy})
    assert message in str(caught.value)


def test_share_of_full_scale_needs_a_range():
    entry = {key: METER[key] for key in METER if key != "range"}
    with pytest.raises(ValidationError, match="'full_scale' and 'range' are missing"):
        ENTRY.model_validate(entry)


def test_share_of_a_temperature_is_refused():
    """0.1 % of 20 °C would be 0.29 K, because it is 293.15 K."""
    entry = {"channel": "room.air", "measures": "temperature", "serial": "T-1"}
    with pytest.raises(ValidationError, match="expected a difference in K"):
        Instrument.model_validate(entry | {"accuracy": {"gain": "0.1 %"}})
    instrument = Instrument.model_validate(entry | {"accuracy": {"offset": "0.2 K"}})
    assert instrument.reading_errors(293.15)[0].u == pytest.approx(0.2 / sqrt(3))


POWER_METER = {"channel": "in.level", "measures": "power level", "serial": "P-1"}


@pytest.mark.parametrize(
    "accuracy", ["5 % reading", "1 % FS", "0.2 dBm", {"gain": "5 %"}, {"offset": "0.2 dBm"}]
)
def test_error_of_a_power_level_must_be_in_decibels(accuracy):
    """5 % of -10 dBm would be 0.5 dB, and of 0 dBm zero; 5 % of the power is 0.21 dB."""
    with pytest.raises(ValidationError, match="in dB"):
        Instrument.model_validate(POWER_METER | {"accuracy": accuracy})
    Instrument.model_validate(POWER_METER | {"accuracy": accuracy}, context={STORED: True})
    for stated in ("0.2 dB", {"offset": "0.2 dB"}):
        instrument = Instrument.model_validate(POWER_METER | {"accuracy": stated})
        assert instrument.reading_errors(-10.0)[0].at(-10.0) == pytest.approx(0.2 / sqrt(3))


def test_points_of_a_power_meter_have_uncertainties_in_decibels():
    points = [{"applied": f"{level} dBm", "indicated": f"{level + 0.1} dBm", "U": "0.06 dB"}
              for level in (-30.0, -20.0, -10.0, 0.0)]  # fmt: skip
    meter = Instrument.model_validate(POWER_METER | {"points": points, "interpolation": "linear"})
    assert meter.points[0].standard_uncertainty == pytest.approx(0.03)


def test_torque_transducer_has_its_optional_errors():
    stated = {"source": "DKD-1"}
    torque = Instrument.model_validate(
        {
            "channel": "tester.torque",
            "serial": "4711",
            "full_scale": "10 N·m",
            "accuracy": {"gain": "0.3 %", "offset": "20 mN·m", "drift": "0 N·m",
                         "nonlinearity": "0.05 %",
                "hysteresis": {"limit": "0.03 % FS", "distribution": "arcsine", **stated},
                "resolution": {"limit": "1 mN·m", **stated},
                "creep": {"limit": "0.02 % reading", **stated},
                "temperature_sensitivity": {
                    "limit": "0.05 % reading", "per": "10 K", "within": "3 K", **stated},
            },
        }
    )  # fmt: skip
    errors = errors_by_name(torque, -5.0)

    assert errors["nonlinearity of tester.torque"].u == pytest.approx(0.005 / sqrt(3))
    assert errors["offset of tester.torque"].acts == "offset"
    assert "offset of tester.torque" not in errors_by_name(torque, -5.0, zeroed=True)
    assert errors["drift of tester.torque"].u == 0
    assert errors["hysteresis of tester.torque"].u == pytest.approx(0.003 / sqrt(2))
    assert errors["resolution of tester.torque"].u == pytest.approx(0.5e-3 / sqrt(3))
    assert errors["creep of tester.torque"].u == pytest.approx(0.02e-2 * 5 / sqrt(3))
    sensitivity = errors["temperature sensitivity of tester.torque"]
    assert (sensitivity.acts, sensitivity.source) == ("gain", "DKD-1")
    assert sensitivity.u == pytest.approx(0.05e-2 * 0.3 / sqrt(3))


def test_stored_run_keeps_the_former_meaning_of_a_bare_share():
    """Until 0.2 a voltmeter of 0.5 % counted as one of 5 mV; its runs must still be readable."""
    entry = METER | {"accuracy": "0.5 %"}
    instrument = ENTRY.model_validate(entry, context={STORED: True})
    assert instrument.limit_of_error(100.0) == 0.005
    with pytest.raises(ValidationError, match="which does not say of what"):
        ENTRY.model_validate(entry, context={STORED: False})


def test_bare_share_of_a_relative_humidity_is_absolute():
    entry = {"channel": "room.humidity", "measures": "ratio", "serial": "H-1"}
    assert ENTRY.model_validate(entry | {"accuracy": "2 %"}).limit_of_error(0.5) == 0.02


@pytest.mark.parametrize(
    ("accuracy", "limit"),
    [
        ({"gain": "1e-9 %"}, 1e-10),
        ({"gain": "0.05 ppm"}, 5e-7),
        ({"gain": "0.00001 % reading"}, 1e-6),
        ({"nonlinearity": "0.02 ppm"}, 4e-6),
        ("1e-5 % reading", 1e-6),
        ("0.1 ppm FS", 2e-5),
        ("40 ppb reading", 4e-7),
    ],
)
def test_small_shares_are_read_with_exponents_ppm_and_ppb(accuracy, limit):
    instrument = ENTRY.model_validate({**METER, "accuracy": accuracy})

    assert instrument.limit_of_error(10.0) == pytest.approx(limit, rel=1e-12)


@pytest.mark.parametrize("limit", ["-0.1 % FS", "1e400 % reading"])
def test_negative_or_infinite_share_is_refused(limit):
    with pytest.raises(ValidationError, match="accuracy"):
        ENTRY.model_validate({**METER, "accuracy": limit})
