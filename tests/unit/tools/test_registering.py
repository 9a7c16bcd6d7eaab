"""The register entry that is made from a calibration run."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from helpers_any_quantity import written
from helpers_cli import call
from rigrunner.api import Component, Estimate, MeasurementResult, ResultDefinition
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.errors import DataError
from rigrunner.api.findings import MissingResult
from rigrunner.api.instruments import Instrument
from rigrunner.api.quantity import Quantity
from rigrunner.api.units import unit
from rigrunner.tools.registering import _points, entry_yaml
from rigrunner.yamlfile import parse


def result(name, value, at, unit="N·m"):
    """Return a result with one budget line of 1 mN·m at an applied torque."""
    line = Component("reading", 0.001, 9.0, "normal", common=True)
    of = ResultDefinition(name=name, unit=unit, per=("lever.torque",))
    place = {"lever.torque": at}
    estimate = Estimate(value, 0.001, 9.0, unit)
    return MeasurementResult(of=of, estimate=estimate, components=(line,), coordinates=place)


TEN, IN_MNM = CoordinateValue(10.0, "N·m"), CoordinateValue(10_000.0, "mN·m")


def register_point(*others, missing=()):
    deviation = result("deviation", 0.02, TEN)
    run = SimpleNamespace(results=(deviation, *others), missing=missing)
    (entry,) = _points(run, [deviation])
    return entry


def standard_uncertainty(entry):
    return float(entry["U"].split()[0]) / entry["k"]


@pytest.mark.parametrize("at", [TEN, IN_MNM], ids=["as the deviation", "in another unit"])
@pytest.mark.parametrize(("value", "unit"), [(0.020, "N·m"), (20.0, "mN·m")])
def test_reproducibility_is_converted_from_its_unit(value, unit, at):
    """20 mN·m between the extremes of a sine: half of it over √2, plus 1 mN·m of the reading."""
    entry = register_point(result("reproducibility", value, at, unit))
    assert standard_uncertainty(entry) == pytest.approx((0.010**2 / 2 + 0.001**2) ** 0.5, rel=6e-3)


def test_uncertainty_without_reproducibility_is_that_of_the_deviation():
    assert standard_uncertainty(register_point()) == pytest.approx(0.001, rel=2e-3)


@pytest.mark.parametrize(
    ("others", "missing", "message"),
    [
        ([result("reproducibility", 0.02, CoordinateValue(20.0, "N·m"))], (), "at lever.torque"),
        ([result("reproducibility", 2.0, TEN, "%")], (), "is in %, deviation in N·m"),
        ([], ["reproducibility"], "there is no reproducibility at lever.torque = 10 N·m"),
    ],
    ids=["elsewhere", "a ratio", "missing"],
)
def test_incompatible_or_missing_reproducibility_is_refused(others, missing, message):
    gaps = [MissingResult(of=ResultDefinition(name=n, unit="N·m"), why="-") for n in missing]
    with pytest.raises(DataError, match=message):
        register_point(*others, missing=gaps)


def test_indicated_value_has_the_digits_of_its_uncertainty():
    """A deviation of 1.2 µV at 10 V, U = 0.5 µV: seven digits, 10.00000 V, would lose it."""
    line = Component("reading", 0.25, math.inf, "normal", common=True)
    deviation = MeasurementResult(
        of=ResultDefinition(name="deviation", unit="µV", per=("source.voltage",)),
        estimate=Estimate(1.234567, 0.25, math.inf, "µV"),
        components=(line,),
        coordinates={"source.voltage": CoordinateValue(10.0, "V")},
    )
    (entry,) = _points(SimpleNamespace(results=(deviation,), missing=()), [deviation])
    assert entry["applied"] == "10 V"
    assert entry["indicated"] == "10.0000012346 V"
    assert entry["U"] == "0.49 µV"


def test_zero_adds_its_own_errors_and_cancels_shared_ones():
    """Indication minus zero: an offset cancels, resolution counts twice, gain by the difference."""

    def lines(gain, offset):
        return (
            Component("scatter of the readings", 0.003, 5.0, "t", common=False),
            Component("gain of cell", gain, math.inf, "rectangular", common=True, sensitivity=10.0),
            Component("offset of cell", offset, math.inf, "rectangular", common=True,
                      sensitivity=1.0),
            Component("resolution of cell", 0.004, math.inf, "rectangular", common=True,
                      sensitivity=1.0, shared=False),
        )  # fmt: skip

    deviations = [
        replace(result("deviation", value, CoordinateValue(at, "N·m")), components=lines(gain, 0.5))
        for value, at, gain in ((0.01, 0.0, 0.001), (0.03, 10.0, 0.007))
    ]
    (entry,) = _points(SimpleNamespace(results=deviations, missing=()), deviations)
    expected = math.sqrt(2 * 0.003**2 + (0.007 - 0.001) ** 2 + 2 * 0.004**2)
    assert standard_uncertainty(entry) == pytest.approx(expected, rel=6e-3)
    assert entry["indicated"].startswith("10.02")


@pytest.mark.parametrize(
    ("quantity", "symbol", "difference", "less_zero"),
    [
        ("temperature", "°C", "K", False),
        ("temperature", "°F", "K", False),
        ("voltage", "V", "mV", False),
        ("power level", "dBm", "dB", False),
        ("force", "N", "N", True),
    ],
)
def test_points_correct_the_indications(quantity, symbol, difference, less_zero):
    """0.3 too high at 0, 0.7 at 100; for a force, which is zeroed, 0.4 at 100."""
    per_unit = unit(symbol).factor / unit(difference).factor
    off = {0.0: 0.3, 50.0: 0.5, 100.0: 0.7}
    deviations = [
        result("deviation", shift * per_unit, CoordinateValue(at, symbol), difference)
        for at, shift in off.items()
    ]
    points = list(_points(SimpleNamespace(results=deviations, missing=()), deviations))
    entry = {"channel": "a.b", "measures": quantity, "serial": "1", "interpolation": "linear"}
    instrument = Instrument.model_validate(entry | {"points": points})
    zero = off[0.0] if less_zero else None
    shown = [Quantity(at + shift, unit(symbol)) for at, shift in off.items()]
    corrected = instrument.corrected(np.array([quantity.si for quantity in shown]), zero)
    expected = [Quantity(at, unit(symbol)).si for at in off]
    assert corrected == pytest.approx(expected, abs=1e-3 * unit(symbol).factor)


@pytest.mark.parametrize("serial", ["null", "True", "no", "SN 1", "a: b", "- x", "Größe"])
def test_serial_number_round_trips_as_text(serial):
    lines = entry_yaml({"channel": "a.b", "serial": serial, "points": [{"applied": "1 N"}]})
    (entry,) = parse(f"instruments:\n{lines}\n", "station.yaml").data["instruments"]
    assert entry == {"channel": "a.b", "serial": serial, "points": [{"applied": "1 N"}]}


STATION = """\
rigrunner: station/1
id: bench
title: A voltmeter beside a calibrator
devices:
  bench:
    type: bench
    plugin: tabulated
    settings:
      title: a voltmeter that shows 2 % too much
      set_points: [level]
      rows:
        - {level: 1 V, indicated: 1.02 V, applied: 1 V}
        - {level: 10 V, indicated: 10.2 V, applied: 10 V}
instruments:
  - {channel: bench.applied, measures: voltage, serial: C-1, calibration: recorded,
     interpolation: linear, points: [{applied: 0 V, indicated: 0 V, U: 1 mV},
                                     {applied: 20 V, indicated: 20 V, U: 1 mV}]}
  - {channel: bench.indicated, measures: voltage, serial: V-1, calibration: recorded,
     CORRECTED points: [{applied: 0 V, indicated: 0 V, U: 1 mV},
                        {applied: 20 V, indicated: 20.2 V, U: 1 mV}]}
"""
PROCEDURE = """\
rigrunner: procedure/2
id: CAL
revision: "A"
title: Calibration of a voltmeter
inputs: {specimen: {ask: Serial number, unattended: V-1}}
uses: {bench: bench}
main:
  - sweep:
      set: bench.level
      over: [1 V, 10 V]
      steps: [{measure: {channels: [bench.indicated, bench.applied]}}]
analysis:
  - readings: {of: bench.indicated, minus: bench.applied, per: bench.level,
               result: {name: deviation, unit: mV}}
"""


@pytest.mark.parametrize(
    ("corrected", "options"),
    [("", ()), ("interpolation: linear,", ()), ("interpolation: linear,", ("--serial", "V-2"))],
)
def test_deviation_of_corrected_readings_is_refused(tmp_path, corrected, options):
    """With its last correction of 1 %, a meter that shows 10.2 V at 10 V would read 10.1 V."""
    station = STATION.replace("CORRECTED", corrected)
    procedure, bench = written(tmp_path, procedure=PROCEDURE, station=station)
    runs = tmp_path / "runs"
    run = call("run", procedure, "--station", bench, "--unattended", "--runs", runs)
    assert run.code == 0, run.err
    (folder,) = runs.iterdir()
    arguments = ("--channel", "bench.indicated", "--due", "2099-01-01", *options)
    registered = call("register", "from", folder, *arguments)
    if corrected:
        assert registered.code != 0
        message = "bench.indicated was read with the correction of its earlier calibration"
        assert message in registered.err
    else:
        assert 'indicated: "10.2' in registered.out, registered.err


def test_deviation_with_the_wrong_sign_is_refused(tmp_path):
    swap = (
        "of: bench.indicated, minus: bench.applied",
        "of: bench.applied, minus: bench.indicated",
    )
    station = STATION.replace("CORRECTED", "")
    procedure, bench = written(tmp_path, swap, procedure=PROCEDURE, station=station)
    runs = tmp_path / "runs"
    run = call("run", procedure, "--station", bench, "--unattended", "--runs", runs)
    assert run.code == 0, run.err
    (folder,) = runs.iterdir()
    arguments = ("--channel", "bench.indicated", "--due", "2099-01-01")
    registered = call("register", "from", folder, *arguments)
    assert registered.code != 0
    message = "deviation is bench.applied less bench.indicated, which is the instrument V-1"
    assert message in registered.err


@pytest.mark.parametrize(
    ("standard", "is_trial"),
    [
        ("certificate: K-1, due: 2099-01-01", False),
        ("certificate: K-1, due: 2020-01-01", True),
        ("calibration: recorded", True),
    ],
)
def test_entry_is_a_trial_if_the_standard_was_not_calibrated(tmp_path, standard, is_trial):
    """The instrument itself need not be calibrated: that is the purpose of the run."""
    station = STATION.replace("CORRECTED", "").replace(
        "serial: C-1, calibration: recorded", f"serial: C-1, {standard}"
    )
    procedure, bench = written(tmp_path, procedure=PROCEDURE, station=station)
    runs = tmp_path / "runs"
    flags = ("--override", "overdue", "--by", "A", "--reason", "none") if "2020" in standard else ()
    run = call("run", procedure, "--station", bench, "--unattended", "--runs", runs, *flags)
    assert run.code == 0, run.err
    (folder,) = runs.iterdir()
    arguments = ("--channel", "bench.indicated", "--due", "2099-01-01")
    registered = call("register", "from", folder, *arguments)
    assert registered.code == 0, registered.err
    assert ("calibration: trial" in registered.out) is is_trial
