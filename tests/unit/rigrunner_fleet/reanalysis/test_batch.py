"""Stored runs are analysed again, each once and with the result of a single analysis."""

from __future__ import annotations

import csv
import json
import os
import signal
import threading

import pytest

from helpers_workflow import run
from rigrunner.analysis.document import document
from rigrunner.api.errors import AbortedError, DataError, UsageError
from rigrunner.jobs import Cluster, Processes
from rigrunner.procedure import AnalysisFile
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure
from rigrunner.run.stored import analyse_run
from rigrunner_fleet.reanalysis import batch as module
from rigrunner_fleet.reanalysis.changes import Changes
from rigrunner_fleet.reanalysis.selection import select_runs
from rigrunner_fleet.reanalysis.task import Reanalysis
from unit.jobs.helpers_cluster import busy_pid, two_workers
from unit.rigrunner_fleet.reanalysis.helpers_reanalysis import batch, lab_of, reanalysed, results


@pytest.fixture(scope="module")
def lab(quick, tmp_path_factory):
    return lab_of(tmp_path_factory.mktemp("lab"), quick)


@pytest.fixture(scope="module")
def complete(lab, tmp_path_factory):
    """Analyse all runs again in two processes; return (folder, summary)."""
    out = tmp_path_factory.mktemp("complete") / "out"
    return out, reanalysed(lab, out, workers=Processes(2))


def settings(**analysis):
    return AnalysisFile.model_validate({"rigrunner": "analysis/1", "analysis": analysis}).analysis


@pytest.mark.thorough
def test_batch_results_equal_single_analyses(lab, complete, quick):
    out, _ = complete
    texts = results(out)
    names = ["rig-1/loaded-0", "rig-1/loaded-2", "rig-1/no-load", "rig-2/loaded-1"]
    assert list(texts) == names
    alone = document(analyse_run(lab / "rig-2" / "loaded-1", load_registry()))
    assert json.loads(texts["rig-2/loaded-1"]) == json.loads(json.dumps(alone))
    first = json.loads((quick.loaded / "result.json").read_text())
    assert json.loads(texts["rig-1/loaded-0"])["headline"] == first["headline"]


def test_summary_compares_each_run_with_its_stored_result(complete, quick):
    out, summary = complete
    with (out / "summary.csv").open() as file:
        rows = {row["run"]: row for row in csv.DictReader(file)}
    row = rows["rig-2/loaded-1"]
    headline = json.loads((quick.loaded / "result.json").read_text())["headline"]["compensated"]
    assert float(row["torque_nm"]) == float(row["torque_before_nm"]) == headline["value"]
    assert float(row["u_nm"]) == headline["standard_uncertainty"]
    assert (row["verdict"], row["verdict_before"]) == ("pass", "pass")
    assert (row["method"], row["run_id"]) == ("template_inverse", quick.loaded.name)
    assert rows["rig-1/no-load"]["torque_nm"] == ""
    assert summary.document() == json.loads((out / "summary.json").read_text())
    assert (len(summary.analysed), summary.failed, summary.other_verdicts) == (4, (), ())


def test_finished_runs_are_not_analysed_again(lab, complete, monkeypatch):
    monkeypatch.setattr(module.Reanalysis, "__call__", lambda *_: pytest.fail("done again"))
    counts = []
    again = reanalysed(lab, complete[0], progress=lambda *count: counts.append(count))
    assert again == complete[1]
    assert counts == [(4, 4)]


@pytest.mark.thorough
def test_stopped_batch_continues_to_the_same_results(lab, complete, tmp_path):
    stop, counts = threading.Event(), []

    def after_two(done, total):
        counts.append((done, total))
        if done == 2:
            stop.set()

    with pytest.raises(AbortedError, match="2 of 4 runs are done") as caught:
        reanalysed(lab, tmp_path / "out", progress=after_two, stop=stop)
    assert "the same command continues" in caught.value.hint
    assert json.loads((tmp_path / "out/summary.json").read_text())["analysed"] == 2
    times = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("result.json")}
    assert len(times) == 2
    again = reanalysed(lab, tmp_path / "out", progress=lambda *count: counts.append(count))
    assert again == complete[1]
    assert counts == [(0, 4), (1, 4), (2, 4), (2, 4), (3, 4), (4, 4)]
    assert results(tmp_path / "out") == results(complete[0])
    assert times.items() <= {p: p.stat().st_mtime_ns for p in times}.items()


@pytest.mark.thorough
def test_damaged_files_are_listed_and_retried(quick, tmp_path):
    lab, out = lab_of(tmp_path / "lab", quick, copies=2), tmp_path / "out"
    damaged, text = lab / "rig-1/loaded-0/run.h5", lab / "no run.h5"
    content = damaged.read_bytes()
    damaged.chmod(0o644)
    damaged.write_bytes(content[: len(content) // 2])
    text.write_text("not HDF5")
    runs = select_runs([lab, text])
    summary = batch(workers=Processes(2)).run(runs, out)
    assert [row.run for row in summary.failed] == ["no run", "rig-1/loaded-0"]
    assert all("run.h5" in row.problem for row in summary.failed)
    assert [row.run for row in summary.analysed] == ["rig-1/no-load", "rig-2/loaded-1"]
    damaged.write_bytes(content)
    again = batch().run(runs, out)
    assert [row.run for row in again.failed] == ["no run"]
    assert "rig-1/loaded-0" in results(out)


def test_traceback_of_a_bug_is_stored(lab, tmp_path, monkeypatch):
    def broken(_, path):
        raise ZeroDivisionError(path.name)

    monkeypatch.setattr(module.Reanalysis, "__call__", broken)
    summary = reanalysed(lab, tmp_path / "out")
    assert len(summary.failed) == 4
    assert summary.failed[0].problem == "ZeroDivisionError: loaded-0"
    assert "in broken" in (tmp_path / "out/rig-1/loaded-0/traceback.txt").read_text()


@pytest.mark.thorough
def test_changed_run_file_is_analysed_again(tmp_path, quick):
    lab = lab_of(tmp_path / "lab", quick, copies=1)
    reanalysed(lab, tmp_path / "out")
    os.utime(lab / "rig-1/loaded-0/run.h5", ns=(1, 1))
    counts = []
    reanalysed(lab, tmp_path / "out", progress=lambda *count: counts.append(count))
    assert counts == [(1, 2), (2, 2)]


def test_failed_run_loses_its_earlier_result(tmp_path, quick):
    lab, out = lab_of(tmp_path / "lab", quick, copies=1), tmp_path / "out"
    reanalysed(lab, out)
    assert "rig-1/loaded-0" in results(out)
    changed = lab / "rig-1/loaded-0/run.h5"
    changed.chmod(0o644)
    changed.write_bytes(changed.read_bytes()[:-1000])
    summary = reanalysed(lab, out)
    assert [row.run for row in summary.failed] == ["rig-1/loaded-0"]
    assert "rig-1/loaded-0" not in results(out)


def test_primary_and_methods_can_be_changed(lab, tmp_path):
    changes = Changes(settings(compensations=["paper_peak", "energy"], primary="energy"))
    summary = reanalysed(lab / "rig-2", tmp_path / "out", changes=changes)
    (row,) = summary.analysed
    assert (row.method, row.method_before) == ("energy", "template_inverse")
    assert row.torque_nm != row.torque_before_nm
    result = json.loads(results(tmp_path / "out")["loaded-1"])
    assert set(result["compensations"]) == {"paper_peak", "energy"}
    by_name = reanalysed(lab / "rig-2", tmp_path / "named", changes=Changes(primary="energy"))
    assert by_name.analysed[0].torque_nm == row.torque_nm


def test_changes_that_contradict_the_procedure_fail(lab, tmp_path):
    summary = reanalysed(lab, tmp_path / "out", changes=Changes(primary="nothing"))
    refused = {row.run for row in summary.failed}
    assert refused == {"rig-1/loaded-0", "rig-1/loaded-2", "rig-2/loaded-1"}
    assert {row.run for row in summary.analysed} == {"rig-1/no-load"}
    assert "analysis[0].swing_torque.primary: got 'nothing'" in summary.failed[0].problem
    assert "allowed: " in summary.failed[0].problem


def test_folder_with_results_of_other_settings_is_refused(lab, complete):
    with pytest.raises(UsageError, match="changes of the analysis was none, is energy"):
        reanalysed(lab, complete[0], changes=Changes(primary="energy"))


def test_folder_with_other_files_is_refused(lab, tmp_path):
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(UsageError, match="is not empty"):
        reanalysed(lab, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]


def test_worker_with_other_software_is_refused(lab):
    task = Reanalysis(changes=Changes(), software={"Rigrunner": "0.0.1"})
    with pytest.raises(DataError, match=r"a worker of the cluster has Rigrunner .*, not 0\.0\.1"):
        task(lab / "rig-2/loaded-1")


def test_aborted_run_is_skipped_once(tmp_path):
    stop, counts = threading.Event(), []
    stop.set()
    aborted = run(find_procedure("no_load_inertia_sweep"), tmp_path / "lab", stop=stop)
    summary = reanalysed(tmp_path / "lab", tmp_path / "out")
    assert [(row.run, row.skipped) for row in summary.done] == [
        (aborted.folder.name, "it ended as aborted")
    ]
    assert not summary.failed
    assert not results(tmp_path / "out")
    reanalysed(tmp_path / "lab", tmp_path / "out", progress=lambda *count: counts.append(count))
    assert counts == [(1, 1)]


@pytest.mark.thorough
def test_cluster_survives_a_killed_worker(lab, complete, tmp_path):
    """A worker is killed during a run; the scheduler gives the run to the other one."""
    with two_workers() as cluster:
        counts = []

        def kill(done, total):
            counts.append((done, total))
            if done == 1:
                os.kill(busy_pid(cluster.scheduler_address), signal.SIGKILL)

        workers = Cluster(cluster.scheduler_address)
        summary = reanalysed(lab, tmp_path / "out", workers=workers, progress=kill)
    assert summary == complete[1]
    assert results(tmp_path / "out") == results(complete[0])
    assert counts == [(done, 4) for done in range(5)]
    lines = (tmp_path / "out/done.jsonl").read_text().splitlines()
    assert len(lines) == 1 + 4
