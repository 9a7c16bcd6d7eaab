"""The shipped procedures, at a few frequencies, on instruments with real protocols, in real time.

A torque bridge over SCPI, an inverter and a press over Modbus and a load cell on a serial line run
as a separate program, fed by a model of the rig. This tests the connections: the meaning of each
protocol's bytes is tested against specifications and manuals elsewhere.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import numpy as np
import pytest

from e2e.helpers_loopback import patient_station
from helpers_cli import call
from helpers_workflow import quick_procedure
from rigrunner.api.errors import ExitCode
from rigrunner.engine import streams
from rigrunner.runfile import read
from rigrunner_bearings.devices.swing_tester_sim.rig import steady_state
from rigrunner_bearings.devices.swing_tester_sim.settings import SwingTesterSimSettings

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = [pytest.mark.in_real_time, pytest.mark.thorough]

LOAD_N = 1000.0
STARTS_WITHIN_S = 200.0


@pytest.fixture(scope="module", autouse=True)
def patient_engine():
    """Let blocks come late, as a busy machine delivers them: none is missing by their count."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(streams, "LEAST_GAP_S", 20.0)
        yield


@pytest.fixture(scope="module")
def station(tmp_path_factory):
    """Yield the station of the running instruments, as written by their program."""
    path = tmp_path_factory.mktemp("loopback") / "loopback.yaml"
    command = [sys.executable, "-m", "rigrunner_bearings.loopback", "--station", path]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as bench:
        until = time.monotonic() + STARTS_WITHIN_S
        while not path.exists() and bench.poll() is None and time.monotonic() < until:
            time.sleep(0.05)
        text = path.read_text(encoding="utf-8")
        path.write_text(patient_station(text), encoding="utf-8")
        yield path
        bench.send_signal(signal.SIGTERM)
        output, _ = bench.communicate(timeout=100)
    assert bench.returncode == 0
    assert "torque bridge" in output


def run(procedure: Path, station: Path, runs: Path) -> Path:
    """Return the folder of a run."""
    done = call("run", procedure, "--station", station, "--runs", runs, "--unattended")
    assert done.code == ExitCode.PASS, done.err
    return max(runs.iterdir())  # the name begins with the time


@pytest.fixture(scope="module")
def folders(station, tmp_path_factory):
    """The no-load and the loaded run, at the quickest frequencies."""
    folder = tmp_path_factory.mktemp("quick")
    procedures = [
        quick_procedure(folder, "no_load_inertia_sweep"),
        quick_procedure(folder, "starting_torque_1000n", ("cycles: 100}", "cycles: 5}")),
    ]
    return [run(procedure, station, folder / "runs") for procedure in procedures]


def test_shipped_procedures_give_the_true_result(folders):
    result = json.loads((folders[1] / "result.json").read_text(encoding="utf-8"))
    assert result["decision"]["verdict"] == "pass"
    rig = SwingTesterSimSettings(seed=1).parameters()
    points = result["compensations"]["template_inverse"]["points"]
    assert [point["set_frequency"]["value"] for point in points][-1] == 35.0
    for point in points:
        torque = point["torque"]
        truth = steady_state(rig, LOAD_N, point["set_frequency"]["value"]).truth
        error = torque["value"] - truth["starting_torque_nm"]
        assert abs(error) < torque["expanded_uncertainty_95"]
        assert torque["expanded_uncertainty_95"] < 0.05  # 0.015 where nothing holds the rig up
    raw = [point["raw_peak"]["mean"]["value"] for point in result["points"]]
    assert raw[-1] > 7.0  # without compensation it is ten times as much


def test_run_file_has_the_answers_of_the_instruments(folders):
    stored = read(folders[1])
    fastest = stored.recordings[-1]
    assert fastest.setpoints["tester.frequency"] == 35.0
    assert fastest.conditions["tester.load"] == pytest.approx(LOAD_N, abs=3.0)  # by the load cell
    assert fastest.conditions["tester.temperature"] == pytest.approx(296.15)
    angle = fastest.channels["tester.angle"]
    assert np.rad2deg(angle.max()) == pytest.approx(2.547, abs=0.02)  # asin(2 mm / 45 mm)
    assert "SIM-LB-01" in stored.header.provenance["device tester/bridge"]
    assert "SIM-VFD" in stored.header.provenance["device tester/inverter"]
