import pytest

from helpers_workflow import START, quick_procedure, run
from rigrunner.clock import SimulatedClock


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """A no-load run and a loaded one, quick forms of what ships: (folder, no-load, loaded)."""
    folder = tmp_path_factory.mktemp("finished")
    clock = SimulatedClock(START)
    no_load = run(quick_procedure(folder, "no_load_inertia_sweep"), folder / "runs", clock=clock)
    loaded = run(quick_procedure(folder, "starting_torque_1000n"), folder / "runs", clock=clock)
    return folder, no_load, loaded
