"""A rig that a killed process left energised is reported at each start, made safe, recorded."""

from __future__ import annotations

import io
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

from e2e.helpers_panel import Screen, ready, rig_process, served
from e2e.helpers_supply import SupplyLab
from helpers_cli import call
from rigrunner.api.errors import ExitCode
from rigrunner.api.events import Intervention, Prompt, RunStarted
from rigrunner.rig_state import read_marker
from rigrunner.run.locate import run_names
from rigrunner.runfile import read

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="kill -9 is of POSIX")
PROGRAM = "import sys; from rigrunner.cli.main import main; sys.exit(main())"
SPECIMEN = "Put the specimen between the terminals"


@pytest.fixture
def lab(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    return SupplyLab(tmp_path / "lab")


def words(lab, *options):
    return ["run", lab.procedure, "--station", lab.station, "--runs", lab.runs, *options]


def start(lab, *options):
    command = [sys.executable, "-c", PROGRAM, *map(str, words(lab, "--unattended", *options))]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def kill_at_40_volts(lab):
    """Kill a run as soon as the supply is at 40 V, and return the run's name."""
    with start(lab) as run:
        until_s = time.monotonic() + 60
        while lab.outputs()[0] != 40.0:
            assert time.monotonic() < until_s
            assert run.poll() is None, run.stderr.read()
            time.sleep(0.005)
        run.send_signal(signal.SIGKILL)
        run.wait()
    assert lab.outputs() == (pytest.approx(35, abs=5), 20.0)
    return run_names(lab.runs)[-1]


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """Kill a run at 40 V, once; return its lab, its name, and a copy of its folder."""
    folder = tmp_path_factory.mktemp("killed")
    place, copy = folder / "place", folder / "copy"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RIGRUNNER_LOCKS", str(place / "rigs"))
        lab = SupplyLab(place / "lab")
        name = kill_at_40_volts(lab)
    shutil.copytree(place, copy)
    return lab, name, copy


@pytest.fixture
def left(killed, monkeypatch):
    """Return the lab as that run left it, with files and marker, and the run's name."""
    lab, name, copy = killed
    place = lab.folder.parent
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(place / "rigs"))
    shutil.rmtree(place)
    shutil.copytree(copy, place)
    return lab, name


def attended(monkeypatch, *answers):
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"{answer}\n" for answer in answers)))


def found_record(lab, name):
    """Return the record of the rig as found by a run; check that it precedes all prompts."""
    events = read(lab.runs / name).events
    (intervention,) = [
        e for e in events if isinstance(e, Intervention) and e.action == "found energised"
    ]
    start = events.index(intervention) - 1
    assert isinstance(events[start], RunStarted)
    prompts = [event.seq for event in events[start:] if isinstance(event, Prompt)]
    assert all(intervention.seq < seq for seq in prompts)
    return intervention


def test_unattended_run_makes_the_rig_safe_and_records_it(left):
    lab, killed = left
    assert read_marker("supply").run_name == killed
    called = call(*words(lab, "--unattended"))
    assert called.code == ExitCode.PASS, called.err
    output = called.err
    assert f"left energised by STEPS (run {killed}), process" in output
    assert "psu.speed 20 Hz" in output
    assert "psu.speed reads back 20 Hz, safe is 0 Hz" in output
    assert output.index("the rig was made safe now") > output.index("reads back 20 Hz")
    intervention = found_record(lab, run_names(lab.runs)[-1])
    assert intervention.by == "nobody was asked"
    assert f"(run {killed})" in intervention.subject
    assert "'make safe' made it safe" in intervention.subject
    assert read_marker("supply") is None


def test_operator_is_asked_about_the_rig_before_the_specimen(left, monkeypatch):
    lab, _ = left
    attended(monkeypatch, "yes", "yes")
    called = call(*words(lab))
    assert called.code == ExitCode.PASS, called.err
    output = called.err
    assert output.index("left energised") < output.index("Make the rig safe now?")
    assert output.index("Make the rig safe now?") < output.index(SPECIMEN)
    assert found_record(lab, run_names(lab.runs)[-1]).by == "operator"


def test_declining_to_make_safe_starts_no_run(left, monkeypatch):
    lab, _ = left
    outputs, runs = lab.outputs(), run_names(lab.runs)
    attended(monkeypatch, "no")
    called = call(*words(lab))
    assert called.code == ExitCode.ABORTED
    assert "the rig was left as it is: psu.voltage reads back" in called.err
    assert SPECIMEN not in called.err
    assert lab.outputs() == outputs
    assert read_marker("supply") is not None
    assert run_names(lab.runs) == runs


def test_resume_and_dry_run_report_the_energised_rig(left):
    lab, killed = left
    dry = call("resume", killed, "--runs", lab.runs, "--station", lab.station, "--dry-run")
    assert dry.code == ExitCode.PASS, dry.err
    assert f"left energised by STEPS (run {killed})" in dry.err
    assert lab.outputs()[1] == 20.0
    called = call("resume", killed, "--runs", lab.runs, "--station", lab.station, "--unattended")
    assert called.code == ExitCode.PASS, called.err
    assert called.err.index("reads back 20 Hz, safe is 0 Hz") < called.err.index("found energised")
    assert f"(run {killed})" in found_record(lab, killed).subject
    assert read_marker("supply") is None


def test_list_of_runs_reports_the_energised_rig(left):
    lab, killed = left
    output = call("runs", "--runs", lab.runs).err
    assert f"the rig of station supply was left energised by STEPS (run {killed})" in output
    assert "nothing has confirmed since that it is safe" in output


def test_jog_reports_and_makes_safe_first(left):
    lab, _ = left
    log = lab.folder / "jog.log"
    called = call("jog", lab.station, "psu", "--set", "voltage=5 V", "--log", log)
    assert called.code == ExitCode.PASS, called.err
    assert "left energised by STEPS" in called.err
    assert "found energised by nobody was asked" in log.read_text()
    assert read_marker("supply") is None
    assert lab.outputs() == (0.0, 0.0)


def test_devices_makes_safe_and_the_next_run_records_it(left):
    lab, _ = left
    called = call("devices", lab.station)
    assert called.code == ExitCode.PASS
    assert "left energised by STEPS" in called.err
    assert "NOT SAFE when found" in called.out
    assert lab.outputs() == (0.0, 0.0)
    assert "'devices' made it safe" in call("runs", "--runs", lab.runs).err
    assert call(*words(lab, "--unattended")).code == ExitCode.PASS
    assert "'devices' made it safe" in found_record(lab, run_names(lab.runs)[-1]).subject
    assert "left energised" not in call("runs", "--runs", lab.runs).err


def test_unreachable_rig_blocks_runs_until_confirmed_safe(left):
    lab, _ = left
    state = lab.state.read_text()
    lab.state.unlink()
    called = call(*words(lab, "--unattended"))
    assert called.code == ExitCode.DEVICE
    assert "unplugged; the rig of station supply was left energised by STEPS" in called.err
    assert "--safe-by NAME --reason TEXT" in called.err
    assert read_marker("supply") is not None
    assert call("devices", lab.station).code == ExitCode.DEVICE
    refused = call("devices", lab.station, "--safe-by", "Ann")
    assert (refused.code, refused.out) == (ExitCode.USAGE, ""), "no device was connected"
    assert read_marker("supply") is not None
    confirmed = call(
        "devices", lab.station, "--safe-by", "Ann", "--reason", "unplugged, and replaced"
    )
    assert "Ann states that psu is safe" in confirmed.err
    lab.state.write_text(json.dumps(json.loads(state) | {"voltage": 0.0, "speed": 0.0}))
    assert call(*words(lab, "--unattended")).code == ExitCode.PASS
    intervention = found_record(lab, run_names(lab.runs)[-1])
    assert "Ann says that it is safe: unplugged, and replaced" in intervention.subject


def test_drive_that_stays_on_blocks_every_run(left):
    lab, _ = left
    lab.put(stuck="speed")
    called = call(*words(lab, "--unattended"))
    assert called.code == ExitCode.DEVICE
    assert "the rig is not safe: psu: " in called.err
    assert read_marker("supply") is not None
    lab.put(stuck="")
    assert call(*words(lab, "--unattended")).code == ExitCode.PASS
    assert read_marker("supply") is None


def test_unreported_energised_rig_is_detected(lab):
    lab.put(voltage=60.0)
    called = call(*words(lab, "--unattended"))
    assert called.code == ExitCode.PASS, called.err
    text = "the rig is not safe, and no run has said so: psu.voltage reads back 60 V, safe is 0 V"
    assert text in called.err
    assert "psu.voltage reads back 60 V" in found_record(lab, run_names(lab.runs)[-1]).subject


def test_rig_is_not_touched_if_the_operator_declines(lab, monkeypatch):
    lab.put(voltage=60.0)
    attended(monkeypatch, "no")
    assert call(*words(lab)).code == ExitCode.ABORTED
    assert lab.outputs() == (60.0, 0.0)
    attended(monkeypatch, "no")
    assert call("jog", lab.station, "psu", "--log", lab.folder / "jog.log").code == ExitCode.ABORTED
    assert lab.outputs() == (60.0, 0.0)


def test_completed_run_leaves_no_marker(lab):
    assert call(*words(lab, "--unattended")).code == ExitCode.PASS
    assert read_marker("supply") is None
    assert "energised" not in call("runs", "--runs", lab.runs).err


def test_panel_raises_an_alarm_if_the_run_process_dies(lab):
    with served(lab.folder, lab.runs) as server:
        screen = Screen(server, "a" * 16)
        pair = ready(screen, "procedure.yaml")
        screen.post("run/start", 202, **pair)
        screen.answer()
        screen.until(lambda _: lab.outputs()[0] == 40.0)
        os.kill(rig_process(server), signal.SIGKILL)
        screen.phase("finished")
        state = screen.until(lambda state: state["alarms"])
        (alarm,) = [alarm for alarm in state["alarms"] if alarm["source"] == "rig"]
        assert alarm["active"]
        assert "the rig of station supply was left energised by STEPS" in alarm["text"]
        assert "psu.speed 20 Hz" in alarm["text"]
        ready(screen, "procedure.yaml")
        items = screen.state["preflight"]["items"]
        warnings = [item["text"] for item in items if item["state"] == "warn"]
        assert any("left energised by STEPS" in text for text in warnings)
        (found_energised,) = [text for text in warnings if text.startswith("found energised")]
        assert "psu.speed reads back 20 Hz, safe is 0 Hz" in found_energised
        assert found_energised.endswith("made safe, read back now: voltage 0 V, speed 0 Hz")
        assert screen.state["preflight"]["may_start"]
        assert lab.outputs() == (0.0, 0.0)
        screen.close()


@pytest.mark.thorough
def test_unreachable_rig_is_confirmed_safe_at_the_panel(left):
    lab, _ = left
    state = lab.state.read_text()
    lab.state.unlink()
    with served(lab.folder, lab.runs) as server:
        screen = Screen(server, "d" * 16)
        pair = ready(screen, "procedure.yaml")
        (item,) = [e for e in screen.state["preflight"]["items"] if e["asks_safe"]]
        assert (item["state"], item["text"]) == ("fail", "not read back as safe since then: psu")
        assert screen.state["alarms"][0]["active"]
        screen.post("preflight", 202, **pair, safe="unplugged, and replaced")
        screen.until(lambda s: s["preflight"]["done"] and not s["alarms"][0]["active"])
        items = screen.state["preflight"]["items"]
        assert [e for e in items if e["asks_safe"]] == []
        assert "says that it is safe: unplugged, and replaced" in read_marker("supply").safe_by
        screen.close()
    lab.state.write_text(json.dumps(json.loads(state) | {"voltage": 0.0, "speed": 0.0}))
    assert call(*words(lab, "--unattended")).code == ExitCode.PASS
    intervention = found_record(lab, run_names(lab.runs)[-1])
    assert "says that it is safe: unplugged, and replaced" in intervention.subject


def test_panel_started_after_a_kill_reports_the_rig(left):
    lab, _ = left
    with served(lab.folder, lab.runs) as server:
        screen = Screen(server, "b" * 16)
        state = screen.until(lambda state: state["alarms"])
        assert "was left energised by STEPS" in state["alarms"][0]["text"]
        screen.close()


def test_preflight_reports_found_voltage_and_makes_safe(lab):
    lab.put(voltage=60.0)
    with served(lab.folder, lab.runs) as server:
        screen = Screen(server, "c" * 16)
        ready(screen, "procedure.yaml")
        (item,) = [e for e in screen.state["preflight"]["items"] if "found energised" in e["text"]]
        assert item["state"] == "warn"
        assert "psu.voltage reads back 60 V, safe is 0 V; made safe" in item["text"]
        screen.close()
    assert lab.outputs() == (0.0, 0.0)
