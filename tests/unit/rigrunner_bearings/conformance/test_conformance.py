"""Each check on compensations fails a method that is broken in that way.

That the shipped methods pass is tested by tests/contract/test_conformance.py.
"""

from __future__ import annotations

import pytest

from rigrunner_testing import State, checks, examine_one, subject
from rigrunner_testing.settings import CHECKS as OF_EVERY_PLUGIN
from unit.rigrunner_bearings.conformance.helpers_zoo import COMPENSATIONS, compensation_registry

OWN_CHECKS = {check.name: check for check in checks("compensation") if check not in OF_EVERY_PLUGIN}


def test_every_check_has_a_broken_compensation():
    assert set(COMPENSATIONS) == set(OWN_CHECKS)


SLOW = {"truth_is_within_its_interval", "truth_is_within_it_on_another_rig"}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.thorough] * (name in SLOW)) for name in COMPENSATIONS],
)
def test_broken_compensation_fails_its_check(name):
    registry = compensation_registry(**COMPENSATIONS[name])
    finding = examine_one(subject("compensation", "method", registry=registry), OWN_CHECKS[name])
    assert finding.state is State.FAIL
    assert "Error: " not in finding.text
