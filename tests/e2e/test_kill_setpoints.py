"""kill -9 during many points of a scan or sweep: no reported point is lost."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys

import pytest

from benchmarks import helpers_setpoints
from helpers_docs import ROOT
from helpers_thorough import first
from rigrunner.runfile import read

POINTS = 5_000
KILLS = int(os.environ.get("RIGRUNNER_KILLS", "3"))

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kill -9 needs a Unix")


@pytest.mark.parametrize("way", ["scan", "sweep"])
@pytest.mark.parametrize("seed", first(1, range(KILLS)))
def test_every_reported_point_is_stored(tmp_path, seed, way):
    least_points = random.Random(seed).randrange(50, 2000)  # noqa: S311  (instants of kills)
    reported = killed_after(least_points, tmp_path, way)
    (folder,) = (tmp_path / "runs").iterdir()
    run = read(folder)
    loads = [row.setpoints["press.load"] for row in run.measurements]
    assert least_points <= len(reported) <= len(loads) <= len(reported) + 1
    assert loads[: len(reported)] == reported
    assert loads == pytest.approx(helpers_setpoints.loads_n(POINTS)[: len(loads)], rel=1e-5)
    for row in run.measurements:
        assert row.values == {"press.torque": 1e-3 * row.setpoints["press.load"]}
    assert not run.info.sealed


def killed_after(points: int, folder, way: str) -> list[float]:
    """Kill a run once it has reported a number of points; return all reported points."""
    program = [sys.executable, "-m", "benchmarks.helpers_setpoints", str(folder), str(POINTS), way]
    folder = ROOT / "tests"
    with subprocess.Popen(program, cwd=folder, stdout=subprocess.PIPE, text=True) as running:
        lines = [running.stdout.readline() for _ in range(points)]
        running.kill()
        lines += running.stdout.readlines()
    assert running.returncode == -signal.SIGKILL
    return [float(line) for line in lines]
