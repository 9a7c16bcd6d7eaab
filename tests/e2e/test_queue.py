"""`rigrunner queue`: specimens are queued, run and repeated without a browser."""

from __future__ import annotations

import json

import pytest

from helpers_cli import call
from helpers_workflow import quick_procedure


@pytest.fixture
def runs(tmp_path):
    return ("--runs", tmp_path / "runs")


def queue_entries(runs):
    return json.loads(call("queue", "list", "--json", *runs).out)


def test_queue_runs_without_a_browser(runs, tmp_path):
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep")
    add = ("queue", "add", procedure, "--station", "simulated", *runs)
    assert call(*add, "--set", "operator=Ann", "--by", "Ann").out == "1    waiting\n"
    assert call(*add, "--propose", "--by", "LIMS").out == "2    proposed\n"
    result = call("queue", "next", "--unattended", "--by", "Ann", *runs)
    assert result.code == 0, result.err
    first, second = queue_entries(runs)
    assert (first["status"], first["outcome"]) == ("done", "completed")
    assert (tmp_path / "runs" / first["run"] / "run.h5").is_file()
    assert second["status"] == "proposed"
    refused = call("queue", "next", "--unattended", *runs)
    assert (refused.code, "no entry of the queue is waiting" in refused.err) == (2, True)
    assert call("queue", "repeat", "1", "--reason", "a bump", "--by", "Ann", *runs).code == 0
    assert call("queue", "next", "--unattended", *runs).code == 0
    repeat = queue_entries(runs)[1]
    assert (repeat["id"], repeat["repeats"], repeat["outcome"]) == (3, 1, "completed")
    log = (tmp_path / "runs" / repeat["run"] / "run.log").read_text(encoding="utf-8")
    assert "repeat test by Ann: entry 3 of the queue repeats entry 1; reason: a bump" in log
    assert call("queue", "clear", *runs).err == "Removed 2 entries.\n"
    assert [entry["id"] for entry in queue_entries(runs)] == [2]


def test_run_that_cannot_start_leaves_its_entry_waiting(runs, tmp_path):
    broken = tmp_path / "broken.yaml"
    added = call("queue", "add", "starting_torque_1000n", "SN-1", "--station", "simulated", *runs)
    assert added.code == 0, added.err
    refused = call("queue", "next", "--unattended", *runs)
    assert "no no-load run" in refused.err
    assert queue_entries(runs)[0]["status"] == "waiting", "nothing was started"
    assert call("queue", "skip", "1", *runs).code == 2
    assert call("queue", "skip", "1", "--reason", "lost", *runs).code == 0
    broken.write_text("specimen,lot\nSN-2,L\nSN-3\n", encoding="utf-8")
    add = ("queue", "add", "starting_torque_1000n", "--station", "simulated", *runs)
    refused = call(*add, "--file", broken)
    assert refused.code == 3
    assert "broken.yaml:3: error: got 1 cell, expected 2: specimen, lot" in refused.err
    broken.write_text("specimen,lot\nSN-2,L\nSN-3,L\n", encoding="utf-8")
    assert call(*add, "--file", broken).code == 0
    assert call("queue", "move", "3", "--before", "2", *runs).code == 0
    assert call("queue", "hold", "3", "--reason", "wait", *runs).code == 0
    assert call("queue", "release", "3", *runs).code == 0
    specimens = [entry["inputs"]["specimen"] for entry in queue_entries(runs)]
    assert specimens == ["SN-1", "SN-3", "SN-2"]


def test_specimen_with_a_run_requires_the_option_again(demo):
    add = ("queue", "add", "starting_torque_1000n", "DEMO-0001", "--station", "simulated")
    refused = call(*add, "--runs", demo.folder)
    assert refused.code == 3
    assert f"error: DEMO-0001 has already been tested: run {demo.loaded.name}" in refused.err
    assert "give the reason with --again" in refused.err
    assert not list(demo.folder.glob("queue-*")), "nothing was added"
