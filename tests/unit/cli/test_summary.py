from __future__ import annotations

import copy

from rigrunner.api.summaries import SummaryParts
from rigrunner.cli import summary as module
from rigrunner.cli.summary import identity, summary


def estimate(value, expanded):
    return {"value": value, "expanded_uncertainty_95": expanded, "unit": "N·m"}


def point(frequency_hz, raw):
    return {
        "set_frequency": {"value": frequency_hz, "unit": "Hz"},
        "raw_peak": {"mean": {"value": raw, "unit": "N·m"}},
    }


LOADED = {
    "measurand": {"symbol": "Td", "name": "starting torque", "unit": "N·m"},
    "run": {"id": "R1", "procedure": {"id": "P", "revision": "A", "title": "A test"}},
    "headline": {
        "method": "template_inverse",
        "compensated": estimate(0.7262, 0.0213),
        "raw_peak": estimate(3.2, 0.5),
    },
    "decision": {
        "verdict": "pass",
        "reason": "0.73 is below 0.95",
        "verdict_uncompensated": "fail",
    },
    "fits": [],
    "points": [point(1.0, 1.58), point(35.0, 7.4)],
    "compensations": {
        "template_inverse": {
            "not_applicable": None,
            "points": [{"torque": estimate(0.72, 0.021)}, {"torque": estimate(0.73, 0.022)}],
            "checks": [{"name": "asymmetry", "ok": False, "text": "6 %", "advice": "Look."}],
        },
        "energy": {"not_applicable": "no loop", "points": [], "checks": []},
    },
    "checks": [{"name": "clipping", "ok": True, "text": "none", "advice": ""}],
}


def test_summary_shows_headline_verdict_table_and_failed_checks():
    assert summary(LOADED).splitlines() == [
        "raw peak         3.20 ± 0.50 N·m",
        "starting torque  0.726 ± 0.021 N·m (95 %, template_inverse)",
        "verdict          PASS: 0.73 is below 0.95",
        "uncompensated    fail",
        "",
        "Torque in N·m, with its expanded uncertainty (95 %)",
        "set-point  raw peak  template_inverse",
        "---------  --------  ----------------",
        "     1 Hz     1.580     0.720 ± 0.021",
        "    35 Hz     7.400     0.730 ± 0.022",
        "energy: not applicable: no loop",
        "",
        "check: asymmetry: 6 %; Look.",
    ]


def test_incomplete_run_has_no_verdict():
    document = copy.deepcopy(LOADED)
    document["run"]["outcome"] = "aborted"
    lines = summary(document).splitlines()
    assert (
        "verdict          none: the run was not completed (aborted), and neither passes nor fails"
        in (lines)
    )
    assert "by the rule      what was recorded would be PASS: 0.73 is below 0.95" in lines


def test_binding_checks_show_their_effect_before_the_notes():
    document = copy.deepcopy(LOADED) | {"compensations": {}}
    common = {"advice": "", "value": None, "threshold": None, "unit": None, "biases": []}
    document["checks"] = [
        {**common, "name": "cycles", "ok": True, "text": "8", "consequence": "note", "effect": ""},
        {**common, "name": "play", "ok": False, "text": "it plays", "effect": "+0.01 N·m"},
        {**common, "name": "zero", "ok": True, "text": "agrees", "consequence": None},
    ]
    lines = summary(document).splitlines()
    assert lines[-2:] == ["check: play: it plays; +0.01 N·m", "note: cycles: 8"]


def test_run_without_compensation_shows_raw_peaks_and_fits():
    document = copy.deepcopy(LOADED) | {"compensations": {}, "decision": None}
    document["headline"] = {"method": None, "compensated": None, "raw_peak": estimate(4.5, 0.1)}
    coefficient = {"value": 0.9173, "standard_uncertainty": 0.1353, "unit": "N·m"}
    curve = {"formula": "T = c0", "coefficients": {"c0": coefficient}}
    document["fits"] = [
        {"name": "polynomial", "curve": curve, "problem": None},
        {"name": "inertia_physical", "curve": None, "problem": "too few points"},
    ]
    assert summary(document).splitlines() == [
        "Torque in N·m",
        "set-point  raw peak",
        "---------  --------",
        "     1 Hz     1.580",
        "    35 Hz     7.400",
        "",
        "Fits of the raw peak over frequency, with standard uncertainties",
        "polynomial: T = c0",
        "  c0 = 0.92 ± 0.14 N·m",
        "inertia_physical: no fit: too few points",
    ]


def test_identity_shows_procedure_state_and_run():
    assert identity(LOADED).splitlines() == [
        "procedure  A test (P, revision A)",
        "state      draft: not for certification",
        "run        R1",
    ]


def test_missing_values_are_shown_as_dashes():
    document = copy.deepcopy(LOADED)
    document["compensations"]["template_inverse"]["points"][0]["torque"] = estimate(None, None)
    document["points"][0]["raw_peak"]["mean"]["value"] = None
    assert "     1 Hz         -                 -" in summary(document)


class Entry:
    def __init__(self, loaded):
        self.loaded = loaded

    def load(self):
        if isinstance(self.loaded, Exception):
            raise self.loaded
        return self.loaded


def test_packages_add_to_the_summary_and_import_errors_are_reported(monkeypatch, capsys):
    wear = SummaryParts(
        facts=lambda document: [("wear depth", f"{document['wear']} µm")],
        blocks=lambda _: ["Wear track\n12 mm", ""],
        checks=lambda _: [{"name": "stylus", "ok": False, "text": "blunt", "advice": ""}],
    )
    entry_points = {"a": Entry(wear), "b": Entry(ImportError("no module"))}
    monkeypatch.setattr(
        module, "entries", lambda group: entry_points if group == module.GROUP else {}
    )
    plain = {"checks": [], "decision": None, "wear": 12.5, "run": {}}
    assert summary(plain).splitlines() == [
        "wear depth  12.5 µm",
        "",
        "Wear track",
        "12 mm",
        "",
        "check: stylus: blunt",
    ]
    assert "the summary of 'b' cannot be loaded: no module" in capsys.readouterr().err
