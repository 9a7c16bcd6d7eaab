from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from rigrunner.cli.main import main
from rigrunner.jobs import Cluster, Processes, usable_cores
from rigrunner_bearings.study import diagnostics as module
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.diagnostics import Finding, tally

RIGS = [
    Finding(Case("swing_tester_sim", "", 1, 0), ("stroke",), ("stroke",), 0.004),
    Finding(Case("swing_tester_ode", "", 1, 0), (), ("stroke",), 0.006),
    Finding(Case("swing_tester_sim", "other eccentric", 1, 0), ("stroke",), ("stroke",)),
    Finding(Case("swing_tester_sim", "Stribeck law", 1, 0), (), ("stroke",), 0.001),
]


@pytest.fixture
def calls(monkeypatch, tmp_path):
    """The calls of the study by the command; the study is not run."""
    calls = []
    monkeypatch.chdir(tmp_path)

    def run_diagnostics(**settings):
        calls.append(settings)
        settings["runner"].progress(0, 1)
        settings["runner"].progress(1, 1)
        return tally(RIGS)

    monkeypatch.setattr(module, "run_diagnostics", run_diagnostics)
    return calls


def test_options_reach_the_study(calls, capsys):
    options = ["--rigs", "7", "--broken", "5", "--jobs", "2", "--seed", "3"]
    assert main(["study", "diagnostics", *options]) == 0
    (call,) = calls
    runner = call.pop("runner")
    assert call == {"healthy_rigs": 7, "broken_rigs": 5, "seed": 3}
    assert runner.workers == Processes(2)
    assert runner.journal_path == Path("rigrunner-study-diagnostics.part")
    assert capsys.readouterr().err == "1 of 1 rigs\n"


def test_all_cores_are_used_without_cluster(calls, capsys):
    main(["study", "diagnostics"])
    main(["study", "diagnostics", "--dask", "tcp://there:8786"])
    assert [call["runner"].workers for call in calls] == [
        Processes(usable_cores()),
        Cluster("tcp://there:8786"),
    ]
    assert main(["study", "diagnostics", "--dask", "tcp://there:8786", "--jobs", "2"]) == 2
    assert "--jobs and --dask exclude each other" in capsys.readouterr().err


def test_broken_rigs_are_as_many_as_healthy_ones_by_default(calls):
    main(["study", "diagnostics"])
    assert (calls[0]["healthy_rigs"], calls[0]["broken_rigs"]) == (300, 300)


@pytest.mark.usefixtures("calls")
def test_default_output_has_tables(capsys):
    main(["study", "diagnostics"])
    out = capsys.readouterr().out
    assert "False alarms on 2 healthy rigs" in out
    assert "1/1 (2.5-100.0 %)" in out
    assert re.search(r"^swing_tester_ode +0\.006, 0\.006$", out, re.MULTILINE)
    assert re.search(r"^Stribeck law +no fault", out, re.MULTILINE)


@pytest.mark.usefixtures("calls")
def test_markdown_and_json_output(capsys):
    main(["study", "diagnostics", "--markdown"])
    assert "| stroke | 1/1 (2.5-100.0 %) | 0/1 (0.0-97.5 %) |" in capsys.readouterr().out
    main(["study", "diagnostics", "--json"])
    document = json.loads(capsys.readouterr().out)
    assert document["false_alarms"]["stroke"]["swing_tester_sim"]["hits"] == 1
    assert document["breaks"][1]["unseen_because"].startswith("no fault")


@pytest.mark.parametrize("options", [["--rigs", "0"], ["--jobs", "0"], ["--seed", "-1"]])
def test_invalid_option_is_usage_error(options, capsys):
    assert main(["study", "diagnostics", *options]) == 2
    assert options[0] in capsys.readouterr().err
