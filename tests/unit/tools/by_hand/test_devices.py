"""The reports of a station's devices, one by one, despite failures of others."""

from __future__ import annotations

import dataclasses
import json
from datetime import UTC, date, datetime

import pytest

from helpers_cli import call
from helpers_devices import FakeTester
from helpers_workflow import station_file
from rigrunner.api.devices import Identity
from rigrunner.api.errors import DeviceLostError, DeviceTimeoutError, ExitCode
from rigrunner.clock import SimulatedClock
from rigrunner.tools.by_hand.devices import device_reports
from rigrunner.tools.by_hand.station import ready_station

TWO = (
    "devices:\n",
    "devices:\n  other: {type: swing_tester, plugin: swing_tester_sim, settings: {seed: 2}}\n",
)


def reports_of(folder, *changes, **devices):
    """Return the reports of the simulated station with changes, and with fakes in some roles."""
    ready = ready_station(station_file(folder, *changes))
    ready = dataclasses.replace(ready, devices={**ready.devices, **devices})
    return {report.role: report for report in device_reports(ready)}


def failing(call, error):
    def before(request):
        if request.startswith(call):
            raise error

    return before


def test_healthy_device_reports_identity_drives_and_readings(tmp_path):
    report = reports_of(tmp_path)["tester"]
    assert (report.state, report.connected, report.problems) == ("ok", True, ())
    assert report.who["tester"].serial == "SIM-0001"
    assert report.who["tester"].simulated
    assert [(drive.drive, drive.found, drive.safe) for drive in report.drives] == [
        ("frequency", 0.0, True), ("load", 0.0, True),
    ]  # fmt: skip
    assert report.values["tester.temperature"] == pytest.approx(296.15, abs=0.2)
    assert report.units["tester.temperature"] == "K"
    assert report.read_s > 0


def test_failed_device_does_not_hide_others(tmp_path):
    tester = FakeTester(before=failing("connect", DeviceTimeoutError("silent", hint="is it on?")))
    reports = reports_of(tmp_path, TWO, tester=tester)
    assert [(role, report.state) for role, report in reports.items()] == [
        ("other", "ok"), ("tester", "fail"),
    ]  # fmt: skip
    assert reports["tester"].problems == ("tester: silent",)
    assert reports["tester"].hint == "is it on?"
    assert not reports["tester"].connected


@pytest.mark.parametrize("where", ["read ", "read_back", "close"])
def test_device_is_made_safe_and_closed_after_any_failure(tmp_path, where):
    tester = FakeTester(before=failing(where, DeviceLostError("unplugged")))
    report = reports_of(tmp_path, tester=tester)["tester"]
    assert report.state == "fail"
    assert report.connected
    assert report.problems[0] == "tester: unplugged"
    assert tester.calls[-2:] == ["make_safe", "close"]


def test_plugin_bug_fails_only_its_own_device(tmp_path):
    tester = FakeTester(before=failing("read ", ZeroDivisionError("division by zero")))
    reports = reports_of(tmp_path, TWO, tester=tester)
    assert reports["other"].state == "ok"
    assert reports["tester"].problems == (
        "a bug of the plugin: ZeroDivisionError: division by zero",
    )
    assert tester.calls[-2:] == ["make_safe", "close"]


def test_drive_at_an_unsafe_value_is_reported_and_made_safe(tmp_path):
    tester = FakeTester()
    report = reports_of(tmp_path, tester=tester)["tester"]
    assert report.state == "warn"
    assert [(drive.drive, drive.found, drive.safe) for drive in report.drives] == [
        ("load", 7.0, True), ("frequency", 3.0, False),
    ]  # fmt: skip
    assert set(tester.drives_at.values()) == {0.0}


def test_drive_that_cannot_be_made_safe_is_a_failure(tmp_path):
    report = reports_of(tmp_path, tester=FakeTester(read_back_offset=5.0))["tester"]
    assert report.state == "fail"
    assert report.problems == ("NOT SAFE: frequency reads back 5 Hz, safe is 0 Hz",)


def test_ctrl_c_makes_the_device_safe(tmp_path):
    tester = FakeTester(before=failing("read ", KeyboardInterrupt()))
    with pytest.raises(KeyboardInterrupt):
        reports_of(tmp_path, tester=tester)
    assert tester.calls[-2:] == ["make_safe", "close"]


@pytest.mark.parametrize(
    ("entry", "state", "text"),
    [
        ("calibration: simulated", "ok", "not calibrated: simulated"),
        ("due: 2026-03-01", "ok", "calibrated until 2026-03-01"),
        ("due: 2026-02-28", "warn", "overdue since 2026-02-28"),
        ("maker: X", "warn", "no date of the next calibration is in the register"),
    ],
)
def test_report_has_the_calibration_status_of_the_register(tmp_path, entry, state, text):
    ready = ready_station(station_file(tmp_path))
    (torque,) = ready.station.model.instruments
    original = {"simulated": torque.calibration, "due": None}
    changes = {"calibration": None}
    if entry.startswith("due"):
        changes["due"] = date.fromisoformat(entry[5:])
    if entry.startswith("calibration"):
        changes = {"calibration": original["simulated"]}
    model = ready.station.model.model_copy(
        update={"instruments": (torque.model_copy(update=changes),)}
    )
    station = dataclasses.replace(ready.station, model=model)
    clock = SimulatedClock(datetime(2026, 3, 1, 12, tzinfo=UTC))
    (report,) = device_reports(dataclasses.replace(ready, station=station, clock=clock))
    (status,) = report.calibrated
    assert (status.channel, status.instrument) == ("tester.torque", "SIM-TQ-01")
    assert (status.state, status.text) == (state, text)
    assert report.state == state


def test_parts_of_a_composite_are_identified(tmp_path):
    class Parts(FakeTester):
        def connect(self, timeout_s):
            identity = super().connect(timeout_s)
            part = Identity("Fakes", "bridge", "7", "1.2")
            return dataclasses.replace(identity, parts={"bridge": part})

    report = reports_of(tmp_path, tester=Parts())["tester"]
    assert list(report.who) == ["tester", "tester/bridge"]
    assert report.who["tester/bridge"].firmware == "1.2"


def test_command_succeeds_if_all_devices_answer(tmp_path):
    result = call("devices", station_file(tmp_path))
    assert result.code == ExitCode.PASS
    assert "Rigrunner swing_tester_sim, serial SIM-0001 (simulated)" in result.out
    assert "frequency is at 0 Hz, which is safe" in result.out
    assert result.out.endswith("1 device: all answer and were made safe\n")


def test_command_fails_if_one_device_fails_and_shows_the_others(tmp_path):
    station = station_file(tmp_path, TWO, ("{seed: 1}", "{seed: 1, simulate: unplugged}"))
    result = call("devices", station)
    assert result.code == ExitCode.DEVICE
    assert "problem: tester: no swing_tester_sim answered within 10 s" in result.out
    assert "serial SIM-0002" in result.out
    assert result.out.endswith("2 devices, of which 1 failed: tester\n")
    document = json.loads(call("devices", station, "--json").out)
    assert [(report["role"], report["state"]) for report in document] == [
        ("other", "ok"), ("tester", "fail"),
    ]  # fmt: skip


def test_invalid_station_is_refused(tmp_path):
    station = station_file(
        tmp_path, ("swing_tester_sim", "swing_tester_smi"), ("tester.load]", "tester.laod]")
    )
    result = call("devices", station)
    assert result.code == ExitCode.INVALID
    assert "there is no device 'swing_tester_smi'" in result.err
    station = station_file(tmp_path, ("tester.load]", "tester.laod]"))
    result = call("devices", station)
    assert result.code == ExitCode.INVALID
    assert "has no drive 'laod'" in result.err


def test_reports_can_be_recorded_and_replayed(tmp_path):
    station = station_file(tmp_path, ("{seed: 1}", "{seed: 1, simulate: unplugged}"), TWO)
    first = call("devices", station, "--record", tmp_path / "tape", "--json")
    replayed = call("devices", station, "--replay", tmp_path / "tape", "--json")
    first_reports, replayed_reports = json.loads(first.out), json.loads(replayed.out)
    for report in (*first_reports, *replayed_reports):
        del report["read_s"]
    assert first_reports == replayed_reports
    assert replayed.code == first.code == ExitCode.DEVICE
    assert replayed.err == f"Replaying the tape {tmp_path}/tape: no instrument is used.\n"
