"""A second program uses the instrument of a run: it is refused, or the run notices."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import pytest

from e2e.helpers_supply import SupplyLab
from rigrunner.api.errors import ExitCode
from rigrunner.run.locate import run_names
from rigrunner.runfile import read

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="as the tests of the supply")
PROGRAM = "import sys; from rigrunner.cli.main import main; sys.exit(main())"
SHARED = ("plugin: supply\n", "plugin: supply\n    shared: yes\n")


@pytest.fixture
def lab(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    lab = SupplyLab(tmp_path / "lab")
    longer = lab.procedure.read_text(encoding="utf-8").replace("times: 12", "times: 2000")
    lab.procedure.write_text(longer, encoding="utf-8")  # no test waits until it ends
    return lab


def start(*words):
    command = [sys.executable, "-c", PROGRAM, *map(str, words)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


UNTIL_OFF = """\
  - set: {psu.voltage: 40 V}
  - repeat:
      until: {channel: psu.voltage, below: 1 V}
      at_most: 2000
      steps:
        - wait: {time: 0.05 s}
  - measure: {channels: [psu.voltage], name: steps}
teardown:
"""
"""At 40 V until another program sets 0 V: the two never set it in turn, however slow."""


def run_and_jog(lab, station, other):
    """Run with one station; as soon as the supply is at 40 V, jog it to 0 V with the other."""
    words = ["run", lab.procedure, "--station", station, "--unattended", "--runs", lab.runs]
    with start(*words) as run:
        deadline_s = time.monotonic() + 60
        while lab.outputs()[0] != 40.0:
            assert time.monotonic() < deadline_s
            assert run.poll() is None, run.stderr.read()
            time.sleep(0.005)
        log = lab.folder / "jog.log"
        with start("jog", other, "psu", "--set", "voltage=0 V", "--log", log) as jog:
            jog_output = jog.communicate(timeout=60)[1]
        if jog.returncode != ExitCode.PASS:  # the run goes on
            assert run.poll() is None
            run.send_signal(signal.SIGINT)
        run_output = run.communicate(timeout=60)[1]
    return run.returncode, run_output, jog.returncode, jog_output


def test_second_station_file_is_refused_and_the_run_continues(lab):
    code, output, jog_code, jog_output = run_and_jog(
        lab, lab.station, lab.add_station("other.yaml", "other")
    )
    assert jog_code == ExitCode.DEVICE
    assert "is in use: STEPS" in jog_output
    assert code == ExitCode.INTERRUPTED, output
    assert lab.outputs() == (0.0, 0.0)


@pytest.mark.thorough
def test_run_that_lost_its_shared_drive_is_aborted(lab):
    """Found when the run ended as completed, with a row 'set 20 V, measured 0 V'."""
    text = lab.procedure.read_text(encoding="utf-8")
    head, loop = text.split("  - repeat:\n")
    lab.procedure.write_text(head + UNTIL_OFF + loop.split("teardown:\n")[1], encoding="utf-8")
    station = lab.add_station("one.yaml", "one", SHARED)
    code, output, jog_code, jog_output = run_and_jog(
        lab, station, lab.add_station("b.yaml", "b", SHARED)
    )
    assert jog_code == ExitCode.PASS, jog_output
    (name,) = run_names(lab.runs)
    stored = read(lab.runs / name)
    assert code == ExitCode.ABORTED, output
    assert stored.info.outcome == "aborted"
    assert "reads back 0" in output
    assert lab.outputs() == (0.0, 0.0)
