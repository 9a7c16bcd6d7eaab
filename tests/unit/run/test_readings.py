"""Texts, booleans and arrays: from an instrument to verdict, run file, `show` and report."""

from __future__ import annotations

import json

import h5py
import pytest

from helpers_cli import call
from helpers_language import edited
from rigrunner.api.events import LimitMissed, StepEnded
from rigrunner.api.readings import ReadingLimit
from rigrunner.runfile import codec, read

STATION = """\
rigrunner: station/1
id: bench
title: A bench
devices:
  box:
    type: switch_box
    plugin: serial_ascii
    settings:
      port: /dev/ttyUSB9
      simulated: yes
      termination: LF
      example: "FW2.1;CLOSED;1.5,2.5,3.5;23.5"
      channels: {temperature: {unit: °C, pattern: ';([0-9.]+)$'}}
      readings:
        firmware: {kind: text, pattern: '^([^;]*);'}
        door: {kind: boolean, pattern: '^[^;]*;([^;]*);', yes: CLOSED, no: OPEN}
        spectrum: {kind: array, unit: mV, pattern: ';([0-9.,]+);'}
"""
PROCEDURE = """\
rigrunner: procedure/2
id: BOX
revision: "A"
title: A box
uses: {box: switch_box}
main:
  - measure:
      channels: [box.temperature, box.firmware, box.door, box.spectrum]
      limits:
        box.temperature: {max: 30 °C}
        box.firmware: {one_of: [FW2.1, FW2.2]}
        box.door: {equals: yes}
      on_fail: continue
"""


def run_box(folder, *changes, code=0):
    """Run the procedure; return the result of the command, and the folder of the run."""
    (folder / "station.yaml").write_text(STATION, encoding="utf-8")
    (folder / "p.yaml").write_text(edited(PROCEDURE, *changes), encoding="utf-8")
    result = call(
        "run", folder / "p.yaml", "--station", folder / "station.yaml", "--unattended",
        "--runs", folder / "runs",
    )  # fmt: skip
    assert result.code == code, result.err
    return result, next((folder / "runs").iterdir()) if (folder / "runs").exists() else None


@pytest.fixture(scope="module")
def passed(tmp_path_factory):
    return run_box(tmp_path_factory.mktemp("passed"))[1]


@pytest.fixture(scope="module")
def failed(tmp_path_factory):
    change = ("{equals: yes}", "{equals: no}")
    return run_box(tmp_path_factory.mktemp("failed"), change, code=1)


def test_readings_are_stored_with_numbers(passed):
    (row,) = read(passed).measurements
    assert row.values == {"box.temperature": pytest.approx(296.65)}
    assert row.readings == {
        "box.firmware": "FW2.1",
        "box.door": True,
        "box.spectrum": pytest.approx((1.5e-3, 2.5e-3, 3.5e-3)),
    }
    assert row.units["box.spectrum"] == "V"
    assert row.expected == (
        ReadingLimit("box.firmware", ("FW2.1", "FW2.2")),
        ReadingLimit("box.door", (True,)),
    )
    assert [decision.passes for decision in row.decisions] == [True, True, True]


def test_readings_survive_the_journal(passed):
    (event,) = (event for event in read(passed).events if isinstance(event, StepEnded))
    unpacked = codec.event_unpacked(codec.event_record(event)[1])
    assert unpacked == event
    assert {type(reading) for reading in unpacked.readings.values()} == {str, bool, tuple}


def test_readings_are_columns_in_the_file(passed):
    with h5py.File(passed / "run.h5") as file:
        table = file["entry/measurements/measured"]
        assert list(table["readings/box_firmware"]) == [b"FW2.1"]
        assert list(table["readings/box_door"]) == [b"yes"]
        assert table["readings/box_spectrum"][0] == pytest.approx([1.5e-3, 2.5e-3, 3.5e-3])
        assert table["readings/box_spectrum"].attrs["units"] == "V"
        assert list(table["limits/box_door/passes"]) == [1]


def test_unexpected_reading_fails_the_run(failed):
    result, folder = failed
    assert "out of limits: box.door is yes, expected no" in result.err
    (missed,) = (event for event in read(folder).events if isinstance(event, LimitMissed))
    assert missed.text == "box.door is yes, expected no"
    document = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert document["verdict"]["verdict"] == "fail"
    by_name = {limit["of"]: limit for limit in document["limits"]["values"]}
    assert (by_name["box.door"]["shown"], by_name["box.door"]["allowed"]) == ("yes", "no")
    assert by_name["box.firmware"]["verdict"] == "pass"


def test_show_and_report_have_readings(failed):
    folder = failed[1]
    output = call("show", folder.name, "--runs", folder.parent).out
    assert "FW2.1" in output
    assert "0.0015, 0.0025, 0.0035" in output
    assert "box.firmware: limit FW2.1 or FW2.2" in output
    assert "FAIL: box.door" in output
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert "FW2.1 or FW2.2" in report
    assert "0.0015, 0.0025, 0.0035" in report


def test_digest_covers_readings(passed, tmp_path):
    station = STATION.replace("FW2.1;", "FW2.2;")
    (tmp_path / "station.yaml").write_text(station, encoding="utf-8")
    (tmp_path / "p.yaml").write_text(PROCEDURE, encoding="utf-8")
    options = ("--unattended", "--runs", tmp_path / "runs")
    call("run", tmp_path / "p.yaml", "--station", tmp_path / "station.yaml", *options)
    (second,) = (tmp_path / "runs").iterdir()
    assert read(second).measurements[0].readings["box.firmware"] == "FW2.2"
    assert read(second).digest != read(passed).digest


REFUSED = [
    ("{equals: yes}", "{max: 1 N}", "box.door is a boolean, which has 'equals' and 'one_of'"),
    ("{equals: yes}", "{equals: closed}", "box.door is a boolean: expected yes or no"),
    ("[FW2.1, FW2.2]", "[true]", "box.firmware is a text: expected a text; put it in quotes"),
    ("{max: 30 °C}", "{equals: 23.5 °C}", "box.temperature is a number, which has 'min' and 'max'"),
    ("{equals: yes}", "{equals: yes, min: 1 N}", "a number has min and max, a text equals or one"),
    ("box.door: {equals: yes}", "box.spectrum: {equals: x}", "box.spectrum is an array, which has"),
    ("box.spectrum]\n", "box.spectrum]\n      duration: 2 s\n", "what is not a number has no mean"),
    ("box.door, box.spectrum]", "box.door, box.door]", "a channel is listed twice"),
    ("  - measure:", "  - zero: {channel: box.door, within: 1 N}\n  - measure:",
     "box.door is not a number: boolean"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), REFUSED)
def test_limit_of_wrong_kind_is_refused_before_the_run(old, new, message, tmp_path):
    result, folder = run_box(tmp_path, (old, new), code=3)
    assert message in result.err
    assert "p.yaml:" in result.err
    assert folder is None
