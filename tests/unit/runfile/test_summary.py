"""What an index keeps of a run is read from the run file itself, and from nowhere else."""

from __future__ import annotations

import h5py
import pytest

from helpers_runfile import DOCUMENT, PLOT, TWO, write_run
from rigrunner.api.errors import DataError
from rigrunner.runfile import read_summary


@pytest.fixture
def path(tmp_path):
    sealed = write_run(tmp_path / "run", TWO).seal(DOCUMENT, PLOT)
    sealed.chmod(0o644)
    return sealed


def test_a_run_that_was_not_imported_says_nothing_of_an_import(path):
    summary = read_summary(path)
    assert summary.imported == {}
    assert summary.inputs == {"specimen": "<script>", "operator": "Zoë"}


@pytest.mark.parametrize("place", ["inputs", "zeros", "zeros/tester_torque", "recordings"])
def test_a_link_in_place_of_data_is_refused(path, place):
    with h5py.File(path, "r+") as file:
        entry = file["entry"]
        entry.move(place, "elsewhere")
        entry[place] = h5py.SoftLink("/entry/elsewhere")
    with pytest.raises(DataError, match=f"{place.rpartition('/')[2]} is a link, not data"):
        read_summary(path)
