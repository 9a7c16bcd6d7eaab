"""Messages of drivers, tracebacks, and runs without time limits."""

from __future__ import annotations

import pytest

from helpers_cli import call
from rigrunner.api.errors import ExitCode
from rigrunner.api.events import Alarm, Intervention, Note
from rigrunner.run.locate import run_names
from rigrunner.runfile import read

PLUGIN = """\
import time

from rigrunner.api.devices import ChannelInfo, DriveInfo, Identity
from rigrunner.api.driver import Driver
from rigrunner.api.hooks import DeviceRecord, hookimpl

api_version = 1


class Oven(Driver):
    channels = (ChannelInfo("temperature", "K", "Temperature"),)
    drives = (DriveInfo("power", "V", "Power", 0.0, 100.0),)

    def __init__(self, settings, context):
        super().__init__(context)
        self.power = 0.0

    def open(self, timeout_s):
        return Identity("Test", "oven", "1", simulated=True)

    def get(self, channel):
        {get}
        return 300.0

    def actual(self, drive):
        return self.power

    def put(self, drive, value):
        self.power = value


@hookimpl
def rigrunner_devices():
    return [DeviceRecord(name="oven", help="An oven.", factory=Oven, simulated=True)]
"""
STATION = """\
rigrunner: station/1
id: oven
title: An oven
plugins: plugins
devices:
  oven: {type: oven, plugin: oven}
safety: {patience: {answer: 1.5 s}}
"""
PROCEDURE = """\
rigrunner: procedure/2
id: heat
revision: "1"
title: Heat
uses: {oven: oven}
main:
  - set: {oven.power: 50 V}
  - measure: {channels: [oven.temperature]}
teardown:
  - set: {oven.power: 0 V}
"""


@pytest.fixture
def lab(tmp_path):
    """Return a function that runs a lab whose oven executes `get` when it is read."""

    def run(get, *words):
        (tmp_path / "plugins").mkdir()
        (tmp_path / "plugins" / "oven.py").write_text(PLUGIN.replace("{get}", get), "utf-8")
        (tmp_path / "station.yaml").write_text(STATION, "utf-8")
        (tmp_path / "heat.yaml").write_text(PROCEDURE, "utf-8")
        runs = tmp_path / "runs"
        result = call(
            "run", tmp_path / "heat.yaml", "--station", tmp_path / "station.yaml",
            "--unattended", "--realtime", "--runs", runs, *words,
        )  # fmt: skip
        assert runs.exists(), result.err
        (name,) = run_names(runs)
        return result, runs / name

    return run


def test_driver_messages_are_in_log_events_and_show(lab):
    result, folder = lab(
        'self.log.info("heated for %s s", 7); self.log.warning("fan at %d rpm", 900)'
    )
    assert result.code == ExitCode.PASS, result.err
    events = read(folder).events
    assert ("device oven", "heated for 7 s") in [
        (event.step, event.text) for event in events if isinstance(event, Note)
    ]
    assert [(event.source, event.text) for event in events if isinstance(event, Alarm)] == [
        ("device oven", "warning: fan at 900 rpm")
    ]
    log = (folder / "run.log").read_text("utf-8")
    assert "device oven: note: heated for 7 s" in log
    assert "ALARM device oven: warning: fan at 900 rpm" in log
    assert "device oven: warning: fan at 900 rpm" in call("show", folder).out


def test_malformed_driver_message_is_kept(lab):
    result, folder = lab('self.log.warning("%d of %d", "three")')
    assert result.code == ExitCode.PASS, result.err
    alarms = [event.text for event in read(folder).events if isinstance(event, Alarm)]
    assert any("%d of %d" in text for text in alarms)


def test_number_of_driver_messages_is_limited(lab):
    result, folder = lab('[self.log.warning("again") for _ in range(5000)]')
    assert result.code == ExitCode.PASS, result.err
    alarms = [event.text for event in read(folder).events if isinstance(event, Alarm)]
    assert len(alarms) == 1000
    assert alarms[-1] == "warning: 999 messages were logged; further ones are dropped"


def test_run_log_has_traceback_of_error(lab):
    result, folder = lab("[][3]")
    assert result.code == ExitCode.BUG
    log = (folder / "run.log").read_text("utf-8")
    assert "IndexError: list index out of range" in log
    assert "    Traceback (most recent call last):" in log
    lines = [line for line in log.splitlines() if "Traceback" in line or "oven.py" in line]
    assert len(lines) > 1
    assert all(line.startswith("    ") for line in lines)  # no line looks like another event


SLOW = "time.sleep(3)"


def test_slow_call_times_out_without_debugger_option(lab):
    result, _ = lab(SLOW)
    assert result.code == ExitCode.DEVICE
    assert "suspended" not in result.err


def test_debugger_option_suspends_time_limits_and_is_recorded(lab):
    result, folder = lab(SLOW, "--debugger")
    assert result.code == ExitCode.PASS, result.err
    assert "WARNING: time limits are suspended for a debugger" in result.err
    (intervention,) = [event for event in read(folder).events if isinstance(event, Intervention)]
    assert (intervention.action, intervention.by) == ("suspend time limits", "option --debugger")
    assert "suspend time limits" in (folder / "run.log").read_text("utf-8")
