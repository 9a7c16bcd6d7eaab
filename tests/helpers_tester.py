"""The core's tests on a tester of their own: no bearings are needed.

Its package stands in `tester`, and is installed within `installed()` alone, also for programs that
a test starts: no other test is to find its plugin. The fixture `tester` does it for a module. The
torques are those of `tester_of_tests`, which are known by construction.
"""

from __future__ import annotations

import os
from contextlib import contextmanager
from pathlib import Path

import pytest

import helpers_workflow
from helpers_workflow import START, edited
from rigrunner.clock import SimulatedClock

HERE = Path(__file__).parent / "tester"
STATION = HERE / "files" / "station.yaml"
FREQUENCIES = "[8 Hz, 15 Hz, 20 Hz, 25 Hz, 35 Hz]"
PER_1000_N = 0.7
"""The torque of 1000 N in N·m, above that without load: `tester_of_tests.PER_NEWTON_NM`."""
IDLE = 0.3


@contextmanager
def installed():
    """Have the tester's package installed within the block."""
    before = os.environ.get("PYTHONPATH")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(HERE))
        patch.setenv("PYTHONPATH", os.pathsep.join(filter(None, (str(HERE), before))))
        yield


def station_file(folder, *changes):
    """Write the tester's station with changes."""
    return _written(folder, "station", changes)


def procedure_file(folder, name, *changes):
    """Write `idle` or `loaded` with changes."""
    return _written(folder, name, changes)


def run(procedure, runs, *, station=None, tare=None, **options):
    """Plan and execute one procedure on the tester, unattended; return the FinishedRun."""
    partners = {} if tare is None else {"tare": str(tare)}
    station = station or STATION
    return helpers_workflow.run(procedure, runs, station=station, partners=partners, **options)


def both(folder):
    """Run `idle` and then `loaded` in a folder's `runs`; return both FinishedRuns."""
    clock = SimulatedClock(START)
    return tuple(
        run(procedure_file(folder, name), folder / "runs", clock=clock)
        for name in ("idle", "loaded")
    )


def _written(folder, name, changes):
    source, target = HERE / "files" / f"{name}.yaml", folder / f"{name}.yaml"
    return edited(source, target, **{str(i): pair for i, pair in enumerate(changes)})
