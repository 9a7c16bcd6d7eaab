"""Run a check: a crash is a finding, a missing package is an error."""

from __future__ import annotations

import pytest

from rigrunner.api.errors import MissingPackageError
from rigrunner_testing.check import Check, State
from rigrunner_testing.examination import examine_one


class Subject:
    """Something to look at."""

    released = 0

    def release(self):
        self.released += 1


def check(work):
    return Check("it_works", "It works.", "make it work", work)


def test_a_crash_is_a_finding():
    finding = examine_one(Subject(), check(lambda _: 1 / 0))
    assert finding.state is State.FAIL
    assert "ZeroDivisionError" in finding.text


def test_a_missing_package_is_told_and_says_nothing_of_the_plugin():
    def needs(_):
        raise MissingPackageError("the package 'x' is not installed", hint="pip install x")

    subject = Subject()
    with pytest.raises(MissingPackageError, match="pip install x"):
        examine_one(subject, check(needs))
    assert subject.released == 1
