"""A result that is acceptable, and measured values out of their limits: the run fails."""

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
def both(quick, tmp_path_factory):
    folder = tmp_path_factory.mktemp("both")
    shutil.copytree(quick.no_load, folder / "runs" / quick.no_load.name)
    procedure = quick_procedure(folder, "starting_torque_1000n", LIMITED, ("LIM", LIMITS))
    return run(procedure, folder / "runs", clock=SimulatedClock(START))


def test_the_verdict_is_fail_and_both_are_told(both):
    assert both.error is None
    assert str(both.result.decision.verdict) == "pass"
    assert str(both.result.verdict) == "fail"
    assert both.exit_code is ExitCode.FAIL
    document = json.loads((both.folder / "result.json").read_text(encoding="utf-8"))
    assert document["decision"]["verdict"] == "pass"
    assert document["verdict"]["verdict"] == "fail"
    assert (document["limits"]["judged"], document["limits"]["missed"]) == (10, 5)
    for reason in (document["limits"]["reason"], document["decision"]["reason"]):
        assert reason in document["verdict"]["reason"]
    shown = call("show", both.folder).out
    assert "FAIL: Measured values out of limits: 5 of 10" in shown
    assert f"pass: {document['decision']['reason']}" in shown


def test_numbers_of_the_analysis_are_those_without_limits(both, quick):
    before = json.loads((quick.loaded / "result.json").read_text(encoding="utf-8"))
    after = json.loads((both.folder / "result.json").read_text(encoding="utf-8"))
    assert after["headline"] == before["headline"]
    assert after["points"] == before["points"]
    assert after["decision"] == before["decision"]


def test_report_and_archive_have_the_verdict_on_both(both):
    page = (both.folder / "report.html").read_text(encoding="utf-8")
    assert '<div class="card fail">' in page
    assert "Measured values out of limits: 5 of 10" in page
    assert "By the limits of the result: pass." in page
    (found,) = (one for one in run_folders(both.folder.parent) if one.folder == both.folder)
    facts = read_facts(found)
    assert facts.problem == ""
    assert facts.run["verdict"] == "fail"
    assert [each["verdict"] for each in facts.parts["decisions"]] == ["fail"]


def test_analysing_again_finds_the_same(both):
    again = call("analyse", both.folder)
    assert again.code == 1
    assert "FAIL: Measured values out of limits" in again.out
    assert call("verify", both.folder).code == 0
