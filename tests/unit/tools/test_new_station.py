"""All that is wrong in a new station is told at once, of whatever sort it is."""

from __future__ import annotations

import pytest

from helpers_cli import call
from rigrunner.api.errors import InvalidFileError
from rigrunner.station import load_station

PROCEDURE = """\
rigrunner: procedure/2
id: TRY
revision: "1"
title: Tries all of the station
measurand: {symbol: Td, name: torque}
uses: {tester: swing_tester, bench: rotation_tester}
main:
  - set: {tester.frequency: 5 Hz, tester.load: 100 N}
  - record: {channels: [tester.angle, tester.torque], cycles: 10}
  - record: {channels: [tester.angle, bench.torque], duration: 1 s}
analysis:
  - swing_torque:
      fits: [polynomial: {degree: 2}]
"""
STATION = """\
rigrunner: station/1
id: new-1
title: A new station
rig:
  mandrel: M-01
  eccentric: {eccentric}
  centre_distance: 45 mm
  inertia: 0.00233 kg·m²
  support_friction: 0.76 N·m
  support_damping: 0.31 N·m·s/rad
devices:
  tester: {{type: swing_tester, plugin: swing_tester_sim, settings: {{{tester}}}}}
  room: {{type: thermometer, plugin: {room}, settings: {{}}}}
instruments:
  - channel: tester.torque
    serial: T-1
    full_scale: {full_scale}
    accuracy: {{gain: 0.3 %, offset: 0.02 N·m, drift: 0.02 N·m, nonlinearity: 0.05 %}}
{low_pass}\
  - channel: tester.torque{second}
    serial: T-2
    full_scale: 10 N·m
    low_pass: {{type: butterworth, order: 2, corner: 1 kHz}}
{accuracy}\
    calibrated: 2026-05-01
    due: {due}
  - channel: tester.load
    {serial}: L-1
    measures: force
    accuracy: 0.5 % FS
    range: {{max: {reach}}}
safety:
  order: [tester.{drive}]
  drives: {{tester.load: {{max: {limit}}}}}
"""
RIGHT = {
    "eccentric": "2 mm",
    "tester": "seed: 1",
    "room": "swing_tester_sim",
    "full_scale": "10 N·m",
    "low_pass": "    low_pass: {type: butterworth, order: 2, corner: 1 kHz}\n",
    "second": "_of_the_press",
    "accuracy": "    accuracy: {gain: 0.3 %, offset: 0 N·m, drift: 0 N·m, nonlinearity: 0 %}\n",
    "due": "2027-05-01",
    "serial": "serial",
    "reach": "3 kN",
    "drive": "frequency",
    "limit": "2 kN",
}
MISTAKES = {
    "eccentric": ("2 N", "'2 N' is a force, not a length"),
    "tester": ("sede: 1", "unknown key 'sede'"),
    "room": ("room_thermometr", "there is no device 'room_thermometr'"),
    "full_scale": ("10 N", "got '10 N', a force, expected a torque"),
    "low_pass": ("", "the low_pass of the instrument for tester.torque is missing"),
    "second": ("", "'tester.torque' is registered twice"),
    "accuracy": ("", "the key 'accuracy' is missing, or calibration 'points'"),
    "due": ("2025-05-01", "calibrated (2026-05-01) must not be after due (2025-05-01)"),
    "serial": ("serail", "unknown key 'serail'"),
    "reach": ("3 N·m", "got '3 N·m', a torque, expected a force"),
    "drive": ("frequncy", "has no drive 'frequncy'"),
    "limit": ("2 Hz", "got '2 Hz', a frequency; tester.load takes a force"),
}


def checked(folder, **parts):
    station = folder / "new.yaml"
    station.write_text(STATION.format(**{**RIGHT, **parts}), encoding="utf-8")
    procedure = folder / "try.yaml"
    text = PROCEDURE.replace(", bench: rotation_tester", "").replace(
        "  - record: {channels: [tester.angle, bench.torque], duration: 1 s}\n", ""
    )
    procedure.write_text(text, encoding="utf-8")
    return call("check", procedure, "--station", station)


def test_nothing_is_wrong_with_the_right_one(tmp_path):
    called = checked(tmp_path)
    assert called.code == 0, called.err


@pytest.mark.parametrize("mistake", MISTAKES)
def test_each_mistake_alone_is_one_problem(mistake, tmp_path):
    wrong, words = MISTAKES[mistake]
    called = checked(tmp_path, **{mistake: wrong})
    errors = [line for line in called.err.splitlines() if "error:" in line]
    assert called.code == 3
    assert len(errors) == 1 + (mistake == "serial"), called.err  # it lacks its serial number, too
    assert words in called.err


def mistakes_without(*names):
    return {name: wrong for name, (wrong, _) in MISTAKES.items() if name not in names}


def test_all_sorts_of_mistakes_are_told_at_once(tmp_path):
    """But for what is looked at in the devices that could not be made.

    Of a channel that is registered twice it is not known which entry is meant. What an analysis
    asks of the register is told once the plan can be made (decision 63).
    """
    called = checked(tmp_path, **mistakes_without("tester", "second"))
    missing = {
        name: words
        for name, (_, words) in MISTAKES.items()
        if name not in {"tester", "second", "low_pass"} and words not in called.err
    }
    assert missing == {}, called.err


def test_what_follows_from_a_device_that_cannot_be_made_is_not_told(tmp_path):
    called = checked(tmp_path, **mistakes_without("drive", "limit"))
    assert "unknown key 'sede'" in called.err
    assert "has no drive" not in called.err
    assert "no device in the role 'tester'" not in called.err


def test_a_station_that_is_loaded_alone_is_refused_with_all_of_its_own(tmp_path):
    station = tmp_path / "new.yaml"
    parts = {**RIGHT, **mistakes_without()}
    station.write_text(STATION.format(**parts), encoding="utf-8")
    with pytest.raises(InvalidFileError) as caught:
        load_station(station)
    text = str(caught.value)
    of_the_file = ("full_scale", "second", "accuracy", "due", "serial", "reach")
    assert [name for name in of_the_file if MISTAKES[name][1] not in text] == []
