"""Each check on compensations fails one that is broken in just that way.

That what ships passes them all is held by tests/contract/test_conformance.py.
"""

from __future__ import annotations

import pytest

from rigrunner_testing import State, checks, examine_one, subject
from rigrunner_testing.settings import CHECKS as OF_EVERY_PLUGIN
from unit.rigrunner_bearings.conformance.helpers_zoo import COMPENSATIONS, compensation_registry

OWN = {each.name: each for each in checks("compensation") if each not in OF_EVERY_PLUGIN}


def test_there_is_a_broken_compensation_for_every_check():
    assert set(COMPENSATIONS) == set(OWN)


@pytest.mark.parametrize("name", COMPENSATIONS)
def test_a_broken_compensation_fails(name):
    registry = compensation_registry(**COMPENSATIONS[name])
    finding = examine_one(subject("compensation", "method", registry=registry), OWN[name])
    assert finding.state is State.FAIL
    assert "Error: " not in finding.text
