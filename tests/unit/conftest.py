import pytest

from helpers_figures import drawn
from helpers_workflow import START, quick_procedure, run
from rigrunner.clock import SimulatedClock


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """A no-load run and a loaded one, quick forms of what ships: (folder, no-load, loaded)."""
    folder = tmp_path_factory.mktemp("finished")
    clock = SimulatedClock(START)
    with drawn():
        no_load, loaded = (
            run(quick_procedure(folder, name), folder / "runs", clock=clock)
            for name in ("no_load_inertia_sweep", "starting_torque_1000n")
        )
    return folder, no_load, loaded
