from __future__ import annotations

import json

import pytest

from rigrunner.cli.commands.study import diagnostics as module
from rigrunner.cli.main import main
from rigrunner.workflow.study.diagnostics import tally
from rigrunner.workflow.study.diagnostics_case import Case, Finding

RIGS = [
    Finding(Case("swing_tester_sim", "", 1, 0), ("stroke",), ("stroke",), 0.004),
    Finding(Case("swing_tester_ode", "", 1, 0), (), ("stroke",), 0.006),
    Finding(Case("swing_tester_sim", "other eccentric", 1, 0), ("stroke",), ("stroke",)),
    Finding(Case("swing_tester_sim", "Stribeck law", 1, 0), (), ("stroke",), 0.001),
]


@pytest.fixture
def asked(monkeypatch):
    """What the command asks of the study, which itself is not run."""
    calls = []

    def run_diagnostics(**settings):
        calls.append(settings)
        settings["progress"](1, 1)
        return tally(RIGS)

    monkeypatch.setattr(module, "run_diagnostics", run_diagnostics)
    return calls


def test_what_is_asked_for_reaches_the_study(asked, capsys):
    options = ["--rigs", "7", "--broken", "5", "--jobs", "2", "--seed", "3"]
    assert main(["study", "diagnostics", *options]) == 0
    (call,) = asked
    del call["stop"], call["progress"]
    assert call == {"healthy_rigs": 7, "broken_rigs": 5, "jobs": 2, "seed": 3}
    assert capsys.readouterr().err == "1 of 1 rigs\n"


def test_as_many_broken_rigs_as_healthy_ones(asked):
    main(["study", "diagnostics"])
    assert (asked[0]["healthy_rigs"], asked[0]["broken_rigs"]) == (300, 300)


@pytest.mark.usefixtures("asked")
def test_the_tables(capsys):
    main(["study", "diagnostics"])
    out = capsys.readouterr().out
    assert "False alarms on 2 healthy rigs" in out
    assert "1/1 (2.5-100.0 %)" in out
    assert "swing_tester_ode: 0.006, 0.006" in out
    assert "Stribeck law: no fault" in out


@pytest.mark.usefixtures("asked")
def test_markdown_and_json(capsys):
    main(["study", "diagnostics", "--markdown"])
    assert "| stroke | 1/1 (2.5-100.0 %) | 0/1 (0.0-97.5 %) |" in capsys.readouterr().out
    main(["study", "diagnostics", "--json"])
    document = json.loads(capsys.readouterr().out)
    assert document["false_alarms"]["stroke"]["swing_tester_sim"]["hits"] == 1
    assert document["breaks"][1]["unseen_because"].startswith("no fault")


@pytest.mark.parametrize("options", [["--rigs", "0"], ["--jobs", "0"], ["--seed", "-1"]])
def test_nonsense_is_a_usage_error(options, capsys):
    assert main(["study", "diagnostics", *options]) == 2
    assert options[0] in capsys.readouterr().err
