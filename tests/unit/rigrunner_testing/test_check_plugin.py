from __future__ import annotations

import io
import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from helpers_cli import call
from rigrunner.api.errors import ExitCode

WINCH = """\
from rigrunner.api.devices import ChannelInfo, DriveInfo, Identity
from rigrunner.api.driver import Driver
from rigrunner.api.hooks import DeviceRecord, hookimpl

api_version = 1


class Winch(Driver):
    def __init__(self, settings, context):
        drives = [DriveInfo("load", "N", "Load", 0.0, 200.0, tolerance=1.0)]
        super().__init__(context, [ChannelInfo("load", "N", "Load")], drives)
        self.load = 0.0

    def open(self, timeout_s):
        return Identity("Zoo", "winch", "1")

    def get(self, channel):
        return self.load

    def put(self, drive, value):
        self.load = value


@hookimpl
def rigrunner_devices():
    return [DeviceRecord(name="winch", help="HELP", factory=Winch)]
"""


@pytest.fixture
def folder(tmp_path):
    tmp_path.joinpath("winch.py").write_text(WINCH.replace("HELP", "A winch."))
    return tmp_path


def test_conforming_plugin_exits_with_0():
    called = call("check-plugin", "grubbs")
    assert called.code == ExitCode.PASS
    assert "outlier rule 'grubbs' of rigrunner_plugins" in called.out
    assert "\npass  finds_a_gross_error\n" in called.out
    assert "\nn/a   wrong_unit_refused: it has no settings with units\n" in called.out
    assert " 0 fail, " in called.out.splitlines()[-1]


def test_failing_plugin_exits_with_1_and_a_fix(folder):
    folder.joinpath("winch.py").write_text(WINCH.replace("HELP", ""))
    called = call("check-plugin", "winch", "--drop-in", folder, "--yes")
    assert called.code == ExitCode.FAIL
    assert "FAIL  help_line" in called.out
    assert "found: the record's help is empty" in called.out
    assert "fix: write one line" in called.out


@pytest.mark.parametrize(
    ("place", "fix"),
    [
        ("json:no_such_name", "fix: a record names a function or class as 'package.module:name'"),
        ("builtins:str", "fix: correct what 'builtins:str' gives"),
    ],
)
def test_wrong_factory_path_is_reported(folder, place, fix):
    folder.joinpath("line.py").write_text(
        "from rigrunner.api.hooks import FitRecord, Imported, hookimpl\n"
        "api_version = 1\n"
        "@hookimpl\n"
        "def rigrunner_fits():\n"
        f"    return [FitRecord(name='line', help='A line.', factory=Imported({place!r}))]\n"
    )
    called = call("check-plugin", "line", "--drop-in", folder)
    assert called.code == ExitCode.FAIL
    assert "FAIL  can_be_made" in called.out
    assert fix in called.out


def test_moving_real_drives_needs_consent(folder, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO())
    called = call("check-plugin", "winch", "--drop-in", folder)
    assert called.code == ExitCode.USAGE
    assert "This is not a simulator." in called.err
    assert "load up to 50 N" in called.err
    assert "give --yes or --read-only" in called.err


def test_yes_moves_the_drives_and_leaves_them_safe(folder):
    called = call("check-plugin", "winch", "--drop-in", folder, "--yes")
    assert called.code == ExitCode.PASS, called.out
    assert "limits_hold" in called.err
    assert "pass  left_safe" in called.out


@pytest.mark.thorough
def test_read_only_skips_checks_that_move_drives(folder):
    called = call("check-plugin", "winch", "--drop-in", folder, "--read-only")
    assert called.code == ExitCode.PASS
    assert "limits_hold" not in called.out
    assert "left out, as they set drives" in called.out


def test_json_lists_every_check():
    called = call("check-plugin", "mad", "--json")
    (document,) = json.loads(called.out)
    assert document["name"] == "mad"
    assert {finding["state"] for finding in document["findings"]} == {"pass", "not applicable"}
    assert all(finding["holds"] for finding in document["findings"])


def test_settings_are_read_from_a_file(tmp_path):
    file = tmp_path / "settings.yaml"
    file.write_text("threshold: 5\n")
    assert call("check-plugin", "mad", "--settings", file).code == ExitCode.PASS
    file.write_text("threshold: [5]\n")
    called = call("check-plugin", "mad", "--settings", file)
    assert called.code == ExitCode.INVALID
    assert "outlier_rule 'mad': threshold: " in called.err
    file.write_text("- 5\n")
    called = call("check-plugin", "mad", "--settings", file)
    assert called.code == ExitCode.USAGE
    assert "holds no settings" in called.err


def test_role_with_another_plugin_is_refused():
    called = call("check-plugin", "tabulated", "--station", "simulated", "--role", "tester")
    assert called.code == ExitCode.USAGE
    assert "has the plugin 'swing_tester_sim' in the role 'tester'" in called.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["grubs"], "did you mean 'grubbs'?"),
        (["grubbs", "--kind", "fit"], "there is no fit 'grubbs'"),
        (["replay"], "give settings with which it can be tried: --settings FILE"),
        (["fault", "--station", "simulated"], "--station and --role go together"),
        (["swing_tester_sim", "--station", "simulated", "--role", "tster"], "did you mean"),
        (["swing_tester_sim", "--station", "nowhere", "--role", "tester"], "nowhere"),
        (["mad", "--settings", "missing.yaml"], "missing.yaml"),
        (["mad", "--drop-in", "missing"], "missing"),
    ],
)
def test_typing_errors_are_reported(arguments, message):
    called = call("check-plugin", *arguments)
    assert called.code in {ExitCode.USAGE, ExitCode.INVALID}
    assert message in called.err


SAME_NAME = """\
from rigrunner.api.hooks import EventSinkRecord, OutlierRuleRecord, hookimpl

api_version = 1


@hookimpl
def rigrunner_event_sinks():
    return [EventSinkRecord(name="two", help="A.", factory=lambda _: lambda event: None)]


@hookimpl
def rigrunner_outlier_rules():
    return [
        OutlierRuleRecord(name="two", help="B.", factory=lambda _: lambda values: [], rejects=False)
    ]
"""


@pytest.mark.thorough
def test_plugins_of_the_same_name_are_both_checked(tmp_path):
    tmp_path.joinpath("two.py").write_text(SAME_NAME)
    called = call("check-plugin", "two", "--drop-in", tmp_path)
    assert called.code == ExitCode.PASS
    assert "event sink 'two'" in called.out
    assert "outlier rule 'two'" in called.out
    called = call("check-plugin", "two", "--drop-in", tmp_path, "--kind", "event_sink")
    assert "outlier rule" not in called.out


HANGING_WINCH = (
    WINCH.replace("HELP", "A winch.")
    .replace(
        "        return self.load\n",
        """        if self.load > 0:  # tell the test, and hang
            Path(__file__).with_name("hangs").touch()
            time.sleep(20)
        return self.load
""",
    )
    .replace(
        "        self.load = value\n",
        """        self.load = value
        Path(__file__).with_name("load").write_text(f"{value:g}")
""",
    )
    .replace(
        "from rigrunner.api.devices",
        "import time\nfrom pathlib import Path\n\nfrom rigrunner.api.devices",
        1,
    )
)


@pytest.mark.parametrize(
    ("signal_number", "code"),
    [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 20, marks=pytest.mark.thorough)],
)
def test_interrupted_check_leaves_the_drive_safe(folder, signal_number, code):
    folder.joinpath("winch.py").write_text(HANGING_WINCH)
    command = [sys.executable, "-m", "rigrunner", "check-plugin", "winch", "--yes"]
    with subprocess.Popen([*command, "--drop-in", str(folder)], stderr=-1, text=True) as process:
        deadline_s = time.monotonic() + 200
        while not folder.joinpath("hangs").exists() and time.monotonic() < deadline_s:
            time.sleep(0.05)
        assert folder.joinpath("load").read_text() == "20"
        process.send_signal(signal_number)
        _, stderr = process.communicate(timeout=200)
    assert folder.joinpath("load").read_text() == "0"
    assert process.returncode == code, stderr
    assert "interrupted; pass  left_safe" in stderr


STATION = """\
rigrunner: station/1
id: yard
title: The winch in the yard
rig:
  mandrel: M-01
  eccentric: 2 mm
  centre_distance: 45 mm
  inertia: 0.002 kg·m²
  support_friction: 0.7 N·m
  support_damping: 0.3 N·m·s/rad
devices:
  winch: {type: winch, plugin: winch}
safety:
  drives:
    winch.load: {max: 40 N, rate: 25 N/s}
plugins: plugins
"""
LOGGING_WINCH = WINCH.replace("HELP", "A winch.").replace(
    "        self.load = value\n",
    """        self.load = value
        with Path(__file__).with_name("set_points").open("a") as log:
            print(value, file=log)
""",
)


@pytest.mark.thorough
def test_drive_stays_within_the_limits_of_the_station(tmp_path):
    folder = tmp_path / "plugins"
    folder.mkdir()
    folder.joinpath("winch.py").write_text(f"from pathlib import Path\n\n{LOGGING_WINCH}")
    tmp_path.joinpath("yard.yaml").write_text(STATION)
    yard = ("--station", tmp_path / "yard.yaml", "--role", "winch")
    called = call("check-plugin", "winch", *yard, "--read-only")
    assert called.code == ExitCode.PASS, called.out
    assert not folder.joinpath("set_points").exists()
    called = call("check-plugin", "winch", *yard, "--yes")
    assert called.code == ExitCode.PASS, called.out
    set_points = [float(line) for line in folder.joinpath("set_points").read_text().split()]
    assert max(set_points) == 10.0
    assert max(np.diff(set_points)) <= 5.0
    assert "load up to 10 N" in called.err
