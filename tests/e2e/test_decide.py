"""Limits and decisions on the command line: refused, decided, decided again."""

from __future__ import annotations

import json

import pytest

from helpers_cli import call
from rigrunner.api.errors import ExitCode
from rigrunner.run.locate import find_procedure

AS14101 = """\
      min: 0.25 in·lbf
      max: 8.0 in·lbf
      source: AS14101, dash -9
      measurand: {nature: no_load, condition: from_rest}
"""
SEVERAL = """\
rigrunner: acceptance/1
acceptance:
  limits:
    - of: torque
      mean: yes
      max: 0.95 N·m
      source: drawing
      measurand: {nature: load_induced, condition: at_reversal}
    - max: 0.2 N·m
      of: torque
      each: frequency
      where: {frequency: [35 Hz]}
      source: drawing
      measurand: {nature: load_induced, condition: at_reversal}
  rule: non_binary
"""
WHO = ("--by", "A. Person", "--reason", "as agreed <today>")


@pytest.fixture(scope="module")
def folder(quick_copy):
    return quick_copy.loaded


@pytest.mark.parametrize("station", [(), ("--station", "simulated")])
def test_no_load_limits_are_refused_for_a_loaded_swing(tmp_path, station):
    text = find_procedure("starting_torque_1000n").read_text(encoding="utf-8")
    mixed = tmp_path / "mixed.yaml"
    start, end = text.index("      max: 0.95"), text.index("  rule:")
    mixed.write_text(text[:start] + AS14101 + text[end:], encoding="utf-8")

    called = call("check", mixed, *station)
    assert called.code == ExitCode.INVALID
    assert (
        "acceptance.limits[0].measurand: the limit is for the no-load torque from rest"
        in called.err
    )
    assert "the result is the load-induced torque at the reversals of a swing" in called.err


def test_stored_run_is_decided_again_and_the_decision_shown(folder, tmp_path):
    limits = tmp_path / "limits.yaml"
    limits.write_text(SEVERAL, encoding="utf-8")

    looser = call("decide", folder, "--rule", "simple", *WHO)
    assert looser.code == ExitCode.PASS, looser.err
    assert "at most 50.00 % risk in a pass" in looser.out
    failed = call("decide", folder, "--acceptance", limits, *WHO, "--json")
    assert failed.code == ExitCode.FAIL
    parts = json.loads(failed.out)["decision"]["parts"]
    assert [(part["of"], part["verdict"]) for part in parts] == [
        ("mean", "pass"),
        ("35 Hz", "fail"),
    ]

    shown = call("show", folder)
    assert "decided again in decision-2.json  PASS by A. Person" in shown.out
    assert "decided again in decision-3.json  FAIL by A. Person" in shown.out
    document = json.loads(call("show", folder, "--json").out)
    assert [decision["acceptance"]["rule"] for decision in document["later_decisions"]] == [
        "simple",
        "non_binary",
    ]
    assert document["result"]["decision"]["verdict"] == "pass", "the first decision stays"
    assert call("report", folder).code == ExitCode.PASS
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "decision-3.json" in page
    assert "Decided again later:" in page
    assert "as agreed &lt;today&gt;" in page


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (WHO, "give either --acceptance FILE or --rule RULE"),
        (("--fraction", "0.5", *WHO), "give either --acceptance FILE or --rule RULE"),
        (("--rule", "guard_band_fraction", *WHO), "such as --rule guard_band_fraction --fraction"),
        (("--rule", "simple", "--fraction", "0.5", *WHO), "decision_rule 'simple': fraction: "),
        (
            ("--rule", "guard_band", *WHO),
            "did you mean 'guard_band_u'? there are: guard_band_fraction, guard_band_u, non_binary",
        ),
        (("--rule", "guard_band_fraction", "--fraction", "9", *WHO), "less than or equal to 5"),
        (("--rule", "non_binary", "--by", "", "--reason", "x"), "needs a name and a reason"),
        (("--rule", "non_binary", "--by", "A. Person"), "Missing option '--reason'"),
    ],
)
def test_invalid_decision_is_refused(folder, arguments, words):
    called = call("decide", folder, *arguments)
    assert (called.code, words in called.err) == (ExitCode.USAGE, True), called.err


def test_invalid_acceptance_file_is_refused_with_its_line(folder, tmp_path):
    limits = tmp_path / "limits.yaml"
    limits.write_text(SEVERAL.replace("rule: non_binary", "rule: none"), encoding="utf-8")
    called = call("decide", folder, "--acceptance", limits, *WHO)
    assert called.code == ExitCode.INVALID
    assert f"{limits}:15:9: error: acceptance.rule: there is no decision rule 'none'" in called.err
