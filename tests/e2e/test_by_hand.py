"""`rigrunner jog` at a real terminal: Ctrl-C, a signal and a closed window leave the rig safe."""

from __future__ import annotations

import signal
import sys
import time

import pytest

from e2e.helpers_terminal import Terminal
from helpers_workflow import station_file
from rigrunner.api.errors import ExitCode

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
SAFE = "tester is safe: read back tester.frequency 0 Hz"


@pytest.mark.parametrize(
    ("end", "code"),
    [
        (lambda terminal: terminal.type("\x03"), ExitCode.INTERRUPTED),
        (lambda terminal: terminal.process.send_signal(signal.SIGTERM), ExitCode.ABORTED),
        (lambda terminal: terminal.type("\x04"), ExitCode.PASS),
        (lambda terminal: terminal.type("quit\n"), ExitCode.PASS),
    ],
    ids=["Ctrl-C", "SIGTERM", "Ctrl-D", "quit"],
)
def test_every_exit_makes_the_rig_safe(tmp_path, end, code):
    with Terminal(("jog", "simulated", "tester"), str(tmp_path)) as terminal:
        terminal.wait_for("tester> ")
        terminal.type("set frequency 5 Hz\n")
        terminal.wait_for("frequency reads back 5 Hz")
        terminal.wait_for("tester> ")
        end(terminal)
        terminal.wait_for(SAFE)
        assert terminal.process.wait(200) == code
    assert SAFE in (tmp_path / "jog.log").read_text(encoding="utf-8")


def test_ctrl_c_while_a_drive_moves_makes_it_safe(tmp_path):
    station = station_file(tmp_path, ("{seed: 1}", "{seed: 1, load_rate: 10 N/s}"))
    arguments = ("jog", str(station), "tester", "--set", "load=1000 N", "--realtime")
    with Terminal(arguments, str(tmp_path)) as terminal:
        log = tmp_path / "jog.log"
        while not log.exists() or "station simulated" not in log.read_text(encoding="utf-8"):
            assert terminal.process.poll() is None
            time.sleep(0.01)
        time.sleep(1.0)  # the drive moves for 100 s
        terminal.press_ctrl_c()
        assert terminal.ends_with() == ExitCode.INTERRUPTED
    assert "set load 1000 N: interrupted from the keyboard" in log.read_text(encoding="utf-8")
    assert SAFE in log.read_text(encoding="utf-8")


def test_closed_window_leaves_the_rig_safe(tmp_path):
    with Terminal(("jog", "simulated", "tester"), str(tmp_path)) as terminal:
        terminal.wait_for("tester> ")
        terminal.type("set frequency 5 Hz\n")
        terminal.wait_for("frequency reads back 5 Hz")
        terminal.hang_up()
        terminal.process.wait(200)
    assert SAFE in (tmp_path / "jog.log").read_text(encoding="utf-8")
