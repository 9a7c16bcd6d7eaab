"""The conclusion of a verification, and its exit code."""

from __future__ import annotations

import pytest

from rigrunner.api.errors import ExitCode
from rigrunner.documents.verifying.verification import Verification

CONCLUSIONS = {
    "differences": (ExitCode.FAIL, "DOES NOT MATCH: 1 difference"),
    "withdrawn": (ExitCode.WITHDRAWN, "WITHDRAWN: x"),
    "replaced": (ExitCode.REPLACED, "REPLACED: x"),
    "unproven": (ExitCode.UNPROVEN, "PAGE NOT PROVEN: x"),
    "not_recomputed": (ExitCode.REVISED, "NUMBERS NOT RECOMPUTED: x"),
    "unchecked": (ExitCode.UNDECIDED, "OPEN: nothing differs, but not all could be checked"),
}
"""The most severe first."""


def test_no_differences_are_a_match():
    verification = Verification(held=["a"], information=["b"])
    assert verification.matches
    assert (verification.exit_code, verification.conclusion) == (ExitCode.PASS, "MATCH")


@pytest.mark.parametrize("name", CONCLUSIONS)
def test_any_finding_is_no_match(name):
    verification = Verification(**{name: ["x"]})
    assert not verification.matches
    assert (verification.exit_code, verification.conclusion) == CONCLUSIONS[name]


def test_most_severe_finding_decides_and_all_are_stated():
    for count in range(len(CONCLUSIONS)):
        names = list(CONCLUSIONS)[count:]
        verification = Verification(**{name: ["x"] for name in names})
        assert verification.exit_code is CONCLUSIONS[names[0]][0]
        words = [CONCLUSIONS[name][1] for name in names]
        if count == 0:
            words[-1] = "OPEN: not all could be checked"
        assert verification.conclusion == "; ".join(words)


def test_findings_of_a_kind_are_counted():
    assert Verification(differences=["a", "b"]).conclusion == "DOES NOT MATCH: 2 differences"
    assert Verification(unproven=["a", "b"]).conclusion == "PAGE NOT PROVEN: a (and 1 more)"
