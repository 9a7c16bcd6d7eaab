"""The journal is synced as the station demands."""

from __future__ import annotations

import pytest

from benchmarks.helpers_setpoints import lab_of
from helpers_workflow import run
from rigrunner.runfile import read
from rigrunner.runfile.journal import JournalWriter

POINTS = 7


@pytest.mark.parametrize("sweep", [False, True])
@pytest.mark.parametrize("sync", ["each_second", "each_measurement"])
def test_values_are_synced_as_station_demands(tmp_path, monkeypatch, sync, sweep):
    synced = []
    sync_all = JournalWriter.sync
    monkeypatch.setattr(JournalWriter, "sync", lambda self: (synced.append(self), sync_all(self)))
    procedure, station = lab_of(tmp_path, POINTS, sync=sync, sweep=sweep)
    finished = run(procedure, tmp_path / "runs", station=station)
    assert len(read(finished.folder).measurements) == POINTS
    other_syncs = 6  # header, make safe of drive and device, end of the run and of its journals
    assert (len(synced) >= POINTS) is (sync == "each_measurement")
    assert len(synced) - (POINTS if sync == "each_measurement" else 0) < other_syncs
