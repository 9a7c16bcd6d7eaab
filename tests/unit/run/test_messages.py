"""What drivers tell beside their answers, tracebacks, and runs without time limits."""

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
safety: {patience: {answer: 0.3 s}}
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
    """Make a lab whose oven does something of its own when it is read; give how to run it."""

    def run(get, *words):
        (tmp_path / "plugins").mkdir()
        (tmp_path / "plugins" / "oven.py").write_text(PLUGIN.replace("{get}", get), "utf-8")
        (tmp_path / "station.yaml").write_text(STATION, "utf-8")
        (tmp_path / "heat.yaml").write_text(PROCEDURE, "utf-8")
        runs = tmp_path / "runs"
        called = call(
            "run", tmp_path / "heat.yaml", "--station", tmp_path / "station.yaml",
            "--unattended", "--realtime", "--runs", runs, *words,
        )  # fmt: skip
        assert runs.exists(), called.err
        (name,) = run_names(runs)
        return called, runs / name

    return run


def test_what_a_driver_tells_is_in_the_log_the_record_and_what_show_shows(lab):
    called, folder = lab(
        'self.log.info("heated for %s s", 7); self.log.warning("fan at %d rpm", 900)'
    )
    assert called.code == ExitCode.PASS, called.err
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


def test_a_message_whose_values_do_not_fit_costs_nothing(lab):
    called, folder = lab('self.log.warning("%d of %d", "three")')
    assert called.code == ExitCode.PASS, called.err
    alarms = [event.text for event in read(folder).events if isinstance(event, Alarm)]
    assert any("%d of %d" in text for text in alarms)


def test_a_driver_that_tells_at_every_reading_does_not_fill_the_record(lab):
    called, folder = lab('[self.log.warning("again") for _ in range(5000)]')
    assert called.code == ExitCode.PASS, called.err
    alarms = [event.text for event in read(folder).events if isinstance(event, Alarm)]
    assert len(alarms) == 1000
    assert alarms[-1] == "warning: 999 messages were logged; further ones are dropped"


def test_run_log_has_the_traceback_of_an_error(lab):
    called, folder = lab("[][3]")
    assert called.code == ExitCode.BUG
    log = (folder / "run.log").read_text("utf-8")
    assert "IndexError: list index out of range" in log
    assert "    Traceback (most recent call last):" in log
    lines = [line for line in log.splitlines() if "Traceback" in line or "oven.py" in line]
    assert len(lines) > 1
    assert all(line.startswith("    ") for line in lines)  # no line looks like another event


SLOW = "time.sleep(1.5)"


def test_without_the_option_a_call_that_takes_too_long_is_given_up(lab):
    called, _ = lab(SLOW)
    assert called.code == ExitCode.DEVICE
    assert "suspended" not in called.err


def test_under_a_debugger_no_call_is_given_up_and_that_is_said_and_on_record(lab):
    called, folder = lab(SLOW, "--debugger")
    assert called.code == ExitCode.PASS, called.err
    assert "WARNING: time limits are suspended for a debugger" in called.err
    (intervention,) = [event for event in read(folder).events if isinstance(event, Intervention)]
    assert (intervention.action, intervention.by) == ("suspend time limits", "option --debugger")
    assert "suspend time limits" in (folder / "run.log").read_text("utf-8")
