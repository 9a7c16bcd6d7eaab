"""Problems of compensations and of the rig are reported with all others."""

import pytest

from helpers_workflow import quick_procedure, station_file
from rigrunner.api.errors import InvalidFileError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.run.prepare import plan_run


def problems_of(procedure, station):
    with pytest.raises(InvalidFileError) as caught:
        plan_run(procedure, station, load_registry(), SimulatedClock())
    return {problem.field: problem.message for problem in caught.value.problems}


def test_all_problems_are_reported_at_once(tmp_path):
    procedure = quick_procedure(
        tmp_path,
        "starting_torque_1000n",
        ("parameters:\n  load: 1000 N", "parameters:\n  load: 1000 Hz"),
        ("channel: tester.torque", "channel: tester.torqe"),
        ("- template_inverse", "- template_invers"),
    )
    problems = problems_of(procedure, station_file(tmp_path))
    assert set(problems) == {
        "setup[4].zero.channel",
        "main[0].set.tester.load",
        "analysis[0].swing_torque.compensations[1]",
    }


def test_problems_of_both_files_are_reported_together(tmp_path):
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep", ("uses:", "usses:"))
    station = station_file(tmp_path, ("mandrel: M-01", "mandrel: 7"))
    fields = set(problems_of(procedure, station))
    assert any("usses" in field for field in fields)
    assert "rig.mandrel" in fields
