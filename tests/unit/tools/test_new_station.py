"""All problems of a new station are reported at once, whatever their kind."""

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
  - channel: {second}.torque
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
CORRECT = {
    "eccentric": "2 mm",
    "tester": "seed: 1",
    "room": "swing_tester_sim",
    "full_scale": "10 N·m",
    "low_pass": "    low_pass: {type: butterworth, order: 2, corner: 1 kHz}\n",
    "second": "room",
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
    "second": ("tester", "'tester.torque' is registered twice"),
    "accuracy": ("", "the key 'accuracy' is missing, or calibration 'points'"),
    "due": ("2025-05-01", "calibrated (2026-05-01) must not be after due (2025-05-01)"),
    "serial": ("serail", "unknown key 'serail'"),
    "reach": ("3 N·m", "got '3 N·m', a torque, expected a force"),
    "drive": ("frequncy", "has no drive 'frequncy'"),
    "limit": ("2 Hz", "got '2 Hz', a frequency; tester.load takes a force"),
}


def check(folder, **parts):
    station = folder / "new.yaml"
    station.write_text(STATION.format(**{**CORRECT, **parts}), encoding="utf-8")
    procedure = folder / "try.yaml"
    text = PROCEDURE.replace(", bench: rotation_tester", "").replace(
        "  - record: {channels: [tester.angle, bench.torque], duration: 1 s}\n", ""
    )
    procedure.write_text(text, encoding="utf-8")
    return call("check", procedure, "--station", station)


def test_correct_station_passes(tmp_path):
    result = check(tmp_path)
    assert result.code == 0, result.err


@pytest.mark.parametrize("mistake", MISTAKES)
def test_each_mistake_is_reported_as_one_problem(mistake, tmp_path):
    wrong, words = MISTAKES[mistake]
    result = check(tmp_path, **{mistake: wrong})
    errors = [line for line in result.err.splitlines() if "error:" in line]
    assert result.code == 3
    assert len(errors) == 1 + (mistake == "serial"), result.err  # it lacks its serial number, too
    assert words in result.err


def mistakes_without(*names):
    return {name: wrong for name, (wrong, _) in MISTAKES.items() if name not in names}


def test_all_kinds_of_mistakes_are_reported_at_once(tmp_path):
    """Except those that are found in devices which could not be made.

    If a channel is registered twice, it is not clear which entry applies. What an analysis
    requires of the register is reported once the plan can be made (decision 63).
    """
    result = check(tmp_path, **mistakes_without("tester", "second"))
    missing = {
        name: words
        for name, (_, words) in MISTAKES.items()
        if name not in {"tester", "second", "low_pass"} and words not in result.err
    }
    assert missing == {}, result.err


def test_consequences_of_a_failed_device_are_not_reported(tmp_path):
    result = check(tmp_path, **mistakes_without("drive", "limit"))
    assert "unknown key 'sede'" in result.err
    assert "has no drive" not in result.err
    assert "no device in the role 'tester'" not in result.err


def test_loading_a_station_reports_all_problems_of_the_file(tmp_path):
    station = tmp_path / "new.yaml"
    parts = {**CORRECT, **mistakes_without()}
    station.write_text(STATION.format(**parts), encoding="utf-8")
    with pytest.raises(InvalidFileError) as caught:
        load_station(station)
    text = str(caught.value)
    file_mistakes = ("full_scale", "second", "accuracy", "due", "serial", "reach")
    assert [name for name in file_mistakes if MISTAKES[name][1] not in text] == []
