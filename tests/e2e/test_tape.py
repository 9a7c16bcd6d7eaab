"""A run with loopback instruments, recorded on a tape, and replayed without instruments."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from e2e.helpers_loopback import patient_station
from e2e.helpers_terminal import PROGRAM
from helpers_cli import call
from helpers_workflow import quick_procedure
from rigrunner.api.errors import DeviceRejectedError, ExitCode
from rigrunner.engine import streams
from rigrunner.runfile import read
from rigrunner.tape import RecordedTape
from rigrunner_bearings.loopback.bench import running_bench
from rigrunner_testing import replayed

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the load cell needs a pty")
TWO = ("[8 Hz, 15 Hz, 20 Hz, 25 Hz, 35 Hz]", "[20 Hz, 25 Hz]")


@pytest.fixture(scope="module", autouse=True)
def patient_engine():
    """Let blocks come late, as a busy machine delivers them: none is missing by their count."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(streams, "LEAST_GAP_S", 20.0)
        yield


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run on SCPI, Modbus and a serial line, and a reading of the devices, both recorded."""
    folder = tmp_path_factory.mktemp("loopback")
    procedure = quick_procedure(folder, "no_load_inertia_sweep", TWO)
    station = folder / "station.yaml"
    with running_bench() as bench:
        text = patient_station(bench.station()).replace(
            "id: loopback", "id: loopback-taped"
        )  # a rig of its own
        station.write_text(text, encoding="utf-8")
        devices = call("devices", station, "--record", folder / "devices", "--json")
        run = call(
            "run", procedure, "--station", station, "--unattended",
            "--runs", folder / "runs", "--record", folder / "tape",
        )  # fmt: skip
    assert (devices.code, run.code) == (ExitCode.PASS, ExitCode.PASS), run.err + devices.out
    return SimpleNamespace(
        folder=folder, procedure=procedure, station=station, devices=devices, run=run
    )


def replay(recorded, station, runs, *more):
    return call(
        "run", recorded.procedure, "--station", station, "--runs", runs,
        "--replay", recorded.folder / "tape", *more,
    )  # fmt: skip


def test_each_instrument_has_its_own_tape_of_commands_and_answers(recorded):
    tapes = recorded.folder / "tape/devices"
    first = {}
    for path in sorted(tapes.iterdir()):
        lines = [json.loads(line) for line in path.read_text().splitlines()]
        first[path.stem] = [line["ask"] for line in lines if not line["ask"].startswith("clock")]
    assert {"tester.bridge", "tester.cell", "tester.inverter", "tester.press"} <= set(first)
    assert "query *IDN?" in first["tester.bridge"]
    assert "fetch TRAC:DATA? 1000" in first["tester.bridge"]
    assert "write 2000 to holding 1" in first["tester.inverter"]


def test_replay_without_instruments_is_identical_to_the_last_bit(recorded, tmp_path):
    replay_run = replay(recorded, recorded.station, tmp_path / "runs")
    assert replay_run.code == ExitCode.PASS, replay_run.err
    assert "note:" not in replay_run.err
    (original,), (copy,) = (
        list(each.iterdir()) for each in (recorded.folder / "runs", tmp_path / "runs")
    )
    assert read(copy).digest == read(original).digest
    results = [json.loads((folder / "result.json").read_text()) for folder in (original, copy)]
    ids = [result.pop("run")["id"] for result in results]
    assert ids == [original.name, f"{original.name}_replay"]
    assert results[0] == results[1]
    assert "replayed from" in call("show", copy).out
    certified = call("certify", copy, "--authorised-by", "A. Jones", "--letterhead", tmp_path)
    assert certified.code != ExitCode.PASS


def test_tape_without_watched_drives_is_replayed(tmp_path, monkeypatch):
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep", TWO)
    tape, words = tmp_path / "tape", ("--station", "simulated", "--runs", tmp_path / "runs")
    with monkeypatch.context() as before:
        before.setattr(RecordedTape, "watches_drives", False)
        assert call("run", procedure, *words, "--unattended", "--record", tape).code == 0
    manifest = json.loads((tape / "tape.json").read_text())
    assert manifest.pop("watches_drives") is False
    (tape / "tape.json").write_text(json.dumps(manifest))
    replay_run = call("run", procedure, *words, "--replay", tape)
    assert replay_run.code == ExitCode.PASS, replay_run.err
    assert "note:" not in replay_run.err


@pytest.mark.thorough
def test_one_changed_command_is_the_first_difference(recorded, tmp_path):
    station = tmp_path / "station.yaml"
    text = recorded.station.read_text(encoding="utf-8")
    assert "MEAS:TEMP?" in text
    station.write_text(text.replace("MEAS:TEMP?", "MEAS:TEMPER?"), encoding="utf-8")
    ended = replay(recorded, station, tmp_path / "runs")
    assert ended.code == ExitCode.DEVICE
    assert (
        "tester.bridge.jsonl:5 has 'query MEAS:TEMP?', the replay asked for 'query MEAS:TEMPER?'"
        in ended.err
    )
    assert "the settings of tester are not those of the tape" in ended.err


def test_reading_of_devices_is_replayed(recorded):
    called = call("devices", recorded.station, "--replay", recorded.folder / "devices", "--json")
    assert called.code == ExitCode.PASS
    original, copy = (json.loads(devices.out)[0] for devices in (recorded.devices, called))
    for reading in (original, copy):
        del reading["read_s"]
    assert original == copy
    assert set(original["who"]) == {
        "tester", "tester/bridge", "tester/inverter", "tester/press", "tester/cell",
    }  # fmt: skip


def test_plugin_test_can_use_the_tape_of_one_instrument(recorded):
    import yaml  # noqa: PLC0415  (this test alone)

    station = yaml.safe_load(recorded.station.read_text(encoding="utf-8"))
    bridge = station["devices"]["tester"]["settings"]["parts"]["bridge"]["settings"]
    with replayed("visa", bridge, recorded.folder / "devices", "tester/bridge") as device:
        assert device.connect(10.0).serial == "SIM-LB-01"
        values = json.loads(recorded.devices.out)[0]["values"]
        read = device.read(["angle", "torque", "temperature"])
        assert read["torque"] == values["tester.torque"]
        with pytest.raises(DeviceRejectedError, match="the tape is over"):
            device.read(["torque"])


def test_killed_program_leaves_a_tape_that_replays_to_its_end(tmp_path):
    """SIGKILL during a recording: the communication before it is on the tape."""
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep", TWO)
    arguments = (
        "run", str(procedure), "--station", "simulated", "--unattended", "--realtime",
        "--record", "tape",
    )  # fmt: skip
    process = subprocess.Popen(
        [*PROGRAM, *arguments], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    tape = tmp_path / "tape/devices/tester.jsonl"
    deadline_s = time.monotonic() + 60
    while not (tape.exists() and '"ask":"stream angle' in tape.read_text()):
        assert process.poll() is None
        assert time.monotonic() < deadline_s
        time.sleep(0.05)
    process.kill()
    process.wait()
    stopped = call(
        "run", procedure, "--station", "simulated", "--runs", tmp_path / "again",
        "--replay", tmp_path / "tape",
    )  # fmt: skip
    assert stopped.code == ExitCode.DEVICE
    assert "error: tester: the tape is over at" in stopped.err or "clock.jsonl" in stopped.err
    (folder,) = (tmp_path / "again").iterdir()
    assert read(folder).info.sealed


@pytest.mark.parametrize(
    ("options", "code", "says"),
    [
        (("--record", "there"), ExitCode.DATA, "there exists already: a tape is never overwritten"),
        (("--record", "a", "--replay", "there"), ExitCode.USAGE, "--record and --replay exclude"),
        (("--replay", "there"), ExitCode.DATA, "there holds no tape: tape.json: No such file"),
        (("--replay", "nowhere"), ExitCode.DATA, "nowhere holds no tape: tape.json: No such file"),
        (("--record", "there/x/tape"), ExitCode.DATA, "cannot make the tape there/x/tape: Not a"),
    ],
)
@pytest.mark.parametrize(
    "command",
    [("run", "no_load_inertia_sweep", "--unattended", "--station"), ("devices",), ("jog",)],
    ids=lambda command: command[0],
)
def test_invalid_tape_is_refused_before_anything_is_connected(  # noqa: PLR0917  (a table)
    tmp_path, monkeypatch, command, options, code, says
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there").mkdir()
    (tmp_path / "there/x").touch()
    role = ("tester", "--read", "torque") if command == ("jog",) else ()
    called = call(*command, "simulated", *role, *options)
    assert called.code == code
    assert f"error: {says}" in called.err
    assert called.out == ""
    assert not (tmp_path / "runs").exists()
