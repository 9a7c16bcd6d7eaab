"""kill -9 amid many points: none is lost that was said to be done, of a scan and of a sweep."""

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
def test_every_point_that_was_reported_is_there(tmp_path, seed, way):
    wanted = random.Random(seed).randrange(50, 2000)  # noqa: S311  (instants of kills)
    reported = killed_after(wanted, tmp_path, way)
    (folder,) = (tmp_path / "runs").iterdir()
    run = read(folder)
    found = [one.setpoints["press.load"] for one in run.measurements]
    assert wanted <= len(reported) <= len(found) <= len(reported) + 1
    assert found[: len(reported)] == reported
    assert found == pytest.approx(helpers_setpoints.loads_n(POINTS)[: len(found)], rel=1e-5)
    for one in run.measurements:
        assert one.values == {"press.torque": 1e-3 * one.setpoints["press.load"]}
    assert not run.info.sealed


def killed_after(points: int, folder, way: str) -> list[float]:
    """Kill a run once it has reported so many points; return all that it had reported."""
    program = [sys.executable, "-m", "benchmarks.helpers_setpoints", str(folder), str(POINTS), way]
    folder = ROOT / "tests"
    with subprocess.Popen(program, cwd=folder, stdout=subprocess.PIPE, text=True) as running:
        lines = [running.stdout.readline() for _ in range(points)]
        running.kill()
        lines += running.stdout.readlines()
    assert running.returncode == -signal.SIGKILL
    return [float(line) for line in lines]
