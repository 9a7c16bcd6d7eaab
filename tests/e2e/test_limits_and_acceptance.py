"""An acceptable result with measured values out of limits: the run fails."""

from __future__ import annotations

import json
import shutil

import pytest

from helpers_cli import call
from helpers_workflow import START, quick_procedure, run
from rigrunner.api.errors import ExitCode
from rigrunner.clock import SimulatedClock
from rigrunner.runfile.scan import run_folders
from rigrunner_fleet.archive.run_facts import read_facts

pytestmark = pytest.mark.thorough

LIMITS = "limits: {tester.load: {max: 900 N}, tester.torque: {mean: {max: 50 N·m}}}"
LIMITED = (
    "record: {channels: [tester.angle, tester.torque], cycles: 12}",
    "record: {channels: [tester.angle, tester.torque], cycles: 12, on_fail: continue, LIM}",
)


@pytest.fixture(scope="module")
def finished(quick, tmp_path_factory):
    folder = tmp_path_factory.mktemp("both")
    shutil.copytree(quick.no_load, folder / "runs" / quick.no_load.name)
    procedure = quick_procedure(folder, "starting_torque_1000n", LIMITED, ("LIM", LIMITS))
    return run(procedure, folder / "runs", clock=SimulatedClock(START))


def test_verdict_is_fail_with_both_reasons(finished):
    assert finished.error is None
    assert str(finished.result.decision.verdict) == "pass"
    assert str(finished.result.verdict) == "fail"
    assert finished.exit_code is ExitCode.FAIL
    document = json.loads((finished.folder / "result.json").read_text(encoding="utf-8"))
    assert document["decision"]["verdict"] == "pass"
    assert document["verdict"]["verdict"] == "fail"
    assert (document["limits"]["judged"], document["limits"]["missed"]) == (10, 5)
    for reason in (document["limits"]["reason"], document["decision"]["reason"]):
        assert reason in document["verdict"]["reason"]
    shown = call("show", finished.folder).out
    assert "FAIL: Measured values out of limits: 5 of 10" in shown
    assert f"pass: {document['decision']['reason']}" in shown


def test_limits_do_not_change_the_analysis(finished, quick):
    before = json.loads((quick.loaded / "result.json").read_text(encoding="utf-8"))
    after = json.loads((finished.folder / "result.json").read_text(encoding="utf-8"))
    assert after["headline"] == before["headline"]
    assert after["points"] == before["points"]
    assert after["decision"] == before["decision"]


def test_report_and_archive_have_the_overall_verdict(finished):
    page = (finished.folder / "report.html").read_text(encoding="utf-8")
    assert '<div class="card fail">' in page
    assert "Measured values out of limits: 5 of 10" in page
    assert "By the limits of the result: pass." in page
    (run_entry,) = (
        entry for entry in run_folders(finished.folder.parent) if entry.folder == finished.folder
    )
    facts = read_facts(run_entry)
    assert facts.problem == ""
    assert facts.run["verdict"] == "fail"
    assert [decision["verdict"] for decision in facts.parts["decisions"]] == ["fail"]


def test_repeated_analysis_gives_the_same_verdict(finished):
    reanalysed = call("analyse", finished.folder)
    assert reanalysed.code == 1
    assert "FAIL: Measured values out of limits" in reanalysed.out
    assert call("verify", finished.folder).code == 0
