from __future__ import annotations

import json

import pytest

from helpers_cli import call
from rigrunner.api.errors import ExitCode
from rigrunner.tools import doctor
from rigrunner.tools.doctor import Finding

FINE = Finding("Python", "ok", "3.11")
POOR = Finding("browser", "warn", "none", "install one")
BROKEN = Finding("HDF5", "fail", "broken", "reinstall it")


@pytest.mark.parametrize(
    ("findings", "code"),
    [([FINE], ExitCode.PASS), ([FINE, POOR], ExitCode.PASS), ([POOR, BROKEN], ExitCode.FAIL)],
)
def test_only_failures_change_the_exit_code(monkeypatch, findings, code):
    monkeypatch.setattr(doctor, "examine", lambda _: findings)
    assert call("doctor").code == code
    assert call("doctor", "--json").code == code


def test_findings_are_listed_with_their_fixes(monkeypatch):
    monkeypatch.setattr(doctor, "examine", lambda _: [FINE, BROKEN])
    assert call("doctor").out == (
        "ok    Python  3.11\nfail  HDF5    broken\n              fix: reinstall it\n\n"
        "1 ok, 0 warn, 1 fail\n"
    )


def test_findings_can_be_printed_as_json(monkeypatch):
    monkeypatch.setattr(doctor, "examine", lambda _: [POOR])
    assert json.loads(call("doctor", "--json").out) == [
        {"name": "browser", "state": "warn", "found": "none", "fix": "install one"}
    ]
