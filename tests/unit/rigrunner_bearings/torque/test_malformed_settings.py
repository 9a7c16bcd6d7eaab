"""Invalid settings of the analysis of torque are refused with their location."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, edited, only_problem, place_of
from rigrunner.procedure import parse_procedure
from rigrunner.yamlfile import validate
from rigrunner_bearings.torque.settings import SwingTorque
from unit.rigrunner_bearings.torque.helpers_planning import planned

AT = "analysis[0].swing_torque"

# old part, new part, text at the reported location, field, message, hint
SETTINGS = [
    ("from: latest", "form: latest", "form", f"{AT}.no_load.form", "unknown key 'form'",
     "did you mean 'from'? known keys: from, procedure, max_age, same, after, drift"),
    ("procedure: TEST-0, ", "", "{from: latest", f"{AT}.no_load",
     "the key 'procedure' is missing, or 'from: this run'", ""),
    ("max_age: 30 d", "max_age: 30", "30, same", f"{AT}.no_load.max_age",
     "30 is not a number with a unit", "write it as '30 s'"),
    ("max_age: 30 d", "max_age: 30 N", "30 N", f"{AT}.no_load.max_age",
     "'30 N' is a force, not a time", "units of time: s, ms, min, h, d"),
    ("window: 11", "window: 2", "2}}", f"{AT}.despike.hampel.window",
     "got 2, expected 3 or more", ""),
    ("window: 11", "window: no", "no}}", f"{AT}.despike.hampel.window",
     "got 'no', expected a whole number", ""),
    ("{grubbs: {alpha: 0.05}}", "{grubbs: 0.05}", "0.05}\n      fits", f"{AT}.outliers.grubbs",
     "got 0.05, expected a mapping of names to values", ""),
    ("{grubbs: {alpha: 0.05}}", "{grubbs: {}, mad: {}}", "{grubbs", f"{AT}.outliers",
     "a plugin is written as 'name', or as 'name: {setting: value}'", ""),
    ("{grubbs: {alpha: 0.05}}", "[grubbs]", "[grubbs]", f"{AT}.outliers",
     "a plugin is written as 'name', or as 'name: {setting: value}'", ""),
    ("        - energy\n", "        - energy: fast\n", "fast", f"{AT}.compensations[1].energy",
     "got 'fast', expected a mapping of names to values", ""),
    ("        - energy\n", "        - {energy: {}, as: running torque}\n", "running torque",
     f"{AT}.compensations[1].as", "'running torque' is not a name: letters, digits and _", ""),
    ("        - energy\n", "        - {as: running}\n", "{as: running}", f"{AT}.compensations[1]",
     "a plugin is written as 'name', or as 'name: {setting: value}'", ""),
    ("window: 11", "window: 11, threshold: true", "true", f"{AT}.despike.hampel.threshold",
     "got true, expected a number", ""),
    ("window: 11", "window: 11, threshold: 0", "0}}", f"{AT}.despike.hampel.threshold",
     "got 0, expected 1.0 or more", ""),
]  # fmt: skip
CONTRADICTIONS = [
    ("        - inertia\n", "        - polynomial\n", "polynomial\n", f"{AT}.fits[1]",
     "'polynomial' is given twice", "name it once"),
    ("        - energy\n", "        - {energy: {}, as: template}\n", "{energy",
     f"{AT}.compensations[1]", "'template' is given twice", "as: NAME"),
    ("        - energy\n", "        - template\n", "template\n      primary",
     f"{AT}.compensations[1]",
     "'template' is given twice", "name it once"),
    ("primary: template", "primary: templat", "templat\n", f"{AT}.primary",
     "got 'templat', which is not among the compensations", "allowed: template, energy"),
    ("      primary: template\n", "", "swing_torque",
     f"{AT}.primary", "the key 'primary' is missing",
     "say which one counts: template, energy"),
    ("      no_load: {from: latest, procedure: TEST-0, max_age: 30 d, same: [station, mandrel]}\n",
     "",
     "swing_torque", f"{AT}.no_load", "the key 'no_load' is missing",
     "compensations need it: 'no_load: {from: latest, procedure: ID}'"),
]  # fmt: skip


def read(text):
    document = parse_procedure(text, "p.yaml").document
    return validate(SwingTorque, document, ("analysis", 0, "swing_torque"))


@pytest.mark.parametrize(
    ("check", "case"),
    [*((read, case) for case in SETTINGS), *((planned, case) for case in CONTRADICTIONS)],
    ids=lambda case: (case[1] or case[0])[:30] if isinstance(case, tuple) else case.__name__,
)
def test_invalid_settings_are_refused_with_location(check, case):
    old, new, anchor, field, message, hint = case
    text = edited(PROCEDURE, (old, new))
    problem = only_problem(check, text)
    assert message in problem.message
    assert problem.field == field
    assert hint in problem.hint
    assert str(problem.location) == f"p.yaml:{place_of(text, anchor)}"
