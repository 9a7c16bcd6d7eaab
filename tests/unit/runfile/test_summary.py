"""The summary of a run for an index is read from the run file alone."""

from __future__ import annotations

import h5py
import pytest

from rigrunner.api.errors import DataError
from rigrunner.runfile import read_summary
from unit.runfile.helpers_runfile import DOCUMENT, PLOT, TWO, write_run


@pytest.fixture
def path(tmp_path):
    sealed = write_run(tmp_path / "run", TWO).seal(DOCUMENT, PLOT)
    sealed.chmod(0o644)
    return sealed


def test_run_that_was_not_imported_has_no_import(path):
    summary = read_summary(path)
    assert summary.imported == {}
    assert summary.inputs == {"specimen": "<script>", "operator": "Zoë"}


@pytest.mark.parametrize("place", ["inputs", "zeros", "zeros/tester_torque", "recordings"])
def test_link_in_place_of_data_is_refused(path, place):
    with h5py.File(path, "r+") as file:
        entry = file["entry"]
        entry.move(place, "elsewhere")
        entry[place] = h5py.SoftLink("/entry/elsewhere")
    with pytest.raises(DataError, match=f"{place.rpartition('/')[2]} is a link, not data"):
        read_summary(path)


def test_values_kept_in_another_file_are_refused(path, tmp_path):
    (tmp_path / "elsewhere").write_bytes(bytes(8))
    with h5py.File(path, "r+") as file:
        entry = file["entry"]
        del entry["zeros/tester_torque"]
        place = [(str(tmp_path / "elsewhere"), 0, 8)]
        entry.create_dataset("zeros/tester_torque", (1,), "<f8", external=place)
    with pytest.raises(DataError, match="tester_torque is kept in another file"):
        read_summary(path)


def test_summary_of_a_run_is_the_same_before_it_is_sealed(tmp_path):
    writer = write_run(tmp_path / "run", TWO)
    before = read_summary(tmp_path / "run")
    after = read_summary(writer.seal())
    assert (before.sealed, after.sealed) == (False, True)
    for name in ("run_id", "started_utc", "outcome", "inputs", "approval", "recordings", "digest"):
        assert getattr(before, name) == getattr(after, name), name
    assert (before.run_id, before.outcome, before.recordings) == ("run", "completed", 2)


def test_oversized_result_is_refused(path, monkeypatch):
    assert read_summary(path).result_document == DOCUMENT
    monkeypatch.setattr("rigrunner.runfile.summary._LONGEST", 1 << 16)
    with h5py.File(path, "r+") as file:
        del file["entry/analysis/result"]
        file["entry/analysis/result"] = [ord(" ")] * (1 << 16) + [ord("0")]
    with pytest.raises(DataError, match="/entry/analysis/result is not a text"):
        read_summary(path)
