"""Running a check: a crash is a finding, a missing package is an error."""

from __future__ import annotations

import pytest

from rigrunner.api.errors import MissingPackageError
from rigrunner_testing.check import Check, State
from rigrunner_testing.examination import examine_one


class Subject:
    """A subject that counts its releases."""

    released = 0

    def release(self):
        self.released += 1


def check(run):
    return Check("it_works", "It works.", "make it work", run)


def test_crash_is_a_finding():
    finding = examine_one(Subject(), check(lambda _: 1 / 0))
    assert finding.state is State.FAIL
    assert "ZeroDivisionError" in finding.text


def test_missing_package_is_an_error_and_not_a_finding():
    def needs_package(_):
        raise MissingPackageError("the package 'x' is not installed", hint="pip install x")

    subject = Subject()
    with pytest.raises(MissingPackageError, match="pip install x"):
        examine_one(subject, check(needs_package))
    assert subject.released == 1
