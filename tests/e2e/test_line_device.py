"""A device created by `rigrunner new`, with a peer on loopback: measured, or lost and made safe."""

from __future__ import annotations

import socket

import pytest

from helpers_cli import call
from rigrunner.api.errors import ExitCode
from rigrunner.run.locate import run_names
from rigrunner.runfile import read
from rigrunner.tools.new_plugin import NewPlugin
from unit.api.helpers_lines import HANG_UP, ScriptedPeer

LATE = object()
"""The normal answer, once the driver has given up and closed the connection."""
SIX = """\
rigrunner: procedure/2
id: SIX
revision: "A"
title: Six readings
measurand: {symbol: F, name: force}
uses: {device: press}
main:
  - set: {device.force: 500 N, retries: 3}
  - repeat:
      times: 6
      steps:
        - measure: {channels: [device.force], name: forces, retries: 3}
teardown:
  - set: {device.force: 0 N}
"""


class Press(ScriptedPeer):
    """A press that echoes every set-point, and keeps it.

    A line in `wrong` gets that answer instead, once, if the press is not at rest, after
    `readings_before` normal answers to readings.
    """

    def __init__(self, wrong, readings_before=0):
        self.force = b"0.0"
        self.wrong = wrong
        self.readings_before = readings_before
        super().__init__(self)

    def get(self, line, _):
        """Return the answer, like the dictionary of a script."""
        if line.startswith(b"FORCE ") and line not in self.wrong:
            self.force = line.removeprefix(b"FORCE ").strip()
        usual = b"Example,press,0042,1.0" if line == b"*IDN?\n" else self.force
        if line == b"FORCE?\n" and self.force == b"0.0":  # as read at each start
            return usual + b"\n"
        if line == b"FORCE?\n" and self.readings_before:
            self.readings_before -= 1
            return usual + b"\n"
        answer = self.wrong.pop(line, usual + b"\n")
        if answer is LATE:
            self._open[-1].recv(1, socket.MSG_PEEK)
            return usual + b"\n"
        return answer


@pytest.fixture
def lab(tmp_path):
    """Create a station with the drop-in and the package's procedure; return how to run them."""
    plugin = NewPlugin("device", "press")
    texts = plugin.texts()
    (tmp_path / "plugins").mkdir()
    (tmp_path / "plugins" / "press.py").write_text(plugin.module(), encoding="utf-8")
    procedure = tmp_path / "procedure.yaml"
    procedure.write_text(texts["example/procedure.yaml"], encoding="utf-8")

    def run(wrong, readings_before=0):
        press = Press(wrong, readings_before)
        station = tmp_path / "station.yaml"
        text = texts["example/station.yaml"].replace(
            "{simulated: yes}", f"{{address: '{press.address}', timeout: 1 s}}"
        )
        station.write_text(text + "plugins: plugins\n", encoding="utf-8")
        runs = tmp_path / "runs"
        words = ["run", procedure, "--station", station, "--unattended", "--runs", runs]
        try:
            called = call(*words)
        finally:
            press.close()
        return called, press, [runs / name for name in run_names(runs)]

    return run


def test_device_is_measured_over_a_socket(lab):
    called, press, (folder,) = lab({})
    assert called.code == ExitCode.PASS, called.err
    values = [row.values["device.force"] for row in read(folder).measurements]
    assert values == [0.0, 500.0, 1000.0]
    assert press.heard[0] == b"*IDN?\n"
    assert press.force == b"0.0"


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({b"FORCE 500.0\n": HANG_UP}, "closed the connection at 'FORCE 500.0'"),
        ({b"FORCE 500.0\n": b"500.0\r"}, "this line terminator"),
        ({b"FORCE 500.0\n": b""}, "did not answer 'FORCE 500.0' within"),
        ({b"FORCE?\n": b"E07\n"}, "'E07'"),
    ],
)
def test_failure_is_reported_and_the_press_made_safe(lab, wrong, words):
    called, press, (folder,) = lab(wrong)
    assert called.code == ExitCode.DEVICE
    assert words in called.err
    assert press.force == b"0.0"
    assert press.heard[-1] == b"FORCE?\n"  # the safe force was read back
    assert read(folder).info.outcome == "error"


@pytest.mark.parametrize(
    ("wrong", "number"),
    [*((LATE, number) for number in range(6)), (HANG_UP, 2), (b"", 3)],
    ids=[*(f"late-{number}" for number in range(6)), "dropped-2", "none-3"],
)
def test_one_failed_answer_loses_no_measurement(lab, tmp_path, wrong, number):
    """Once, one late answer lost four measurements of six, with `retries: 3`.

    The first readings confirm the set-point. Each of the six is read between two readings of the
    drive.
    """
    (tmp_path / "procedure.yaml").write_text(SIX, encoding="utf-8")
    called, press, folders = lab({b"FORCE?\n": wrong}, number)
    assert called.code == ExitCode.PASS, called.err
    (folder,) = folders
    rows = read(folder).measurements
    assert [row.values["device.force"] for row in rows] == [500.0] * 6
    assert press.heard.count(b"*IDN?\n") == 2  # identified again after it was connected again
    assert press.force == b"0.0"


def test_another_instrument_is_refused_before_any_set_point(lab):
    called, press, folders = lab({b"*IDN?\n": b"ERROR 3\n"})
    assert called.code == ExitCode.DEVICE
    assert "is it the right instrument at this address?" in called.err
    assert not any(line.startswith(b"FORCE 5") for line in press.heard)
    assert folders == []


@pytest.mark.usefixtures("lab")
def test_device_passes_the_kit_over_a_socket(tmp_path):
    press = Press({})
    settings = tmp_path / "settings.yaml"
    settings.write_text(f"address: '{press.address}'\ntimeout: 1 s\n", encoding="utf-8")
    try:
        words = ["press", "--drop-in", tmp_path / "plugins", "--settings", settings, "--yes"]
        called = call("check-plugin", *words)
    finally:
        press.close()
    assert called.code == ExitCode.PASS, called.out
    assert ", 0 fail, " in called.out
    assert press.force == b"0.0"
