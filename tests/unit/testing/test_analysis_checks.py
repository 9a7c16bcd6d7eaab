"""Each check of fits, rules and compensations fails one that is broken in just that way.

That what ships passes them all is held by tests/contract/test_conformance.py.
"""

from __future__ import annotations

import pytest

from helpers_zoo_analysis import (
    COMPENSATIONS,
    FITS,
    RULES,
    compensation_registry,
    fit_registry,
    grubbs,
    line,
    rule_registry,
)
from rigrunner.testing import State, checks, examine_one, subject
from rigrunner.testing.settings import CHECKS as OF_EVERY_PLUGIN


def own_checks(kind):
    return {each.name: each for each in checks(kind) if each not in OF_EVERY_PLUGIN}


def found(kind, name, registry):
    return examine_one(
        subject(kind, registry.plugins[0].record.name, registry=registry), own_checks(kind)[name]
    )


@pytest.mark.parametrize(
    ("kind", "zoo"), [("fit", FITS), ("outlier_rule", RULES), ("compensation", COMPENSATIONS)]
)
def test_there_is_a_broken_one_for_every_check(kind, zoo):
    assert set(zoo) == set(own_checks(kind))


@pytest.mark.parametrize("name", FITS)
def test_a_broken_fit_fails(name):
    finding = found("fit", name, fit_registry(FITS[name]))
    assert finding.state is State.FAIL, finding
    assert "Error: " not in finding.text


@pytest.mark.parametrize("name", FITS)
def test_a_good_fit_passes(name):
    assert found("fit", name, fit_registry(line, examples=())).state is not State.FAIL


@pytest.mark.parametrize("name", RULES)
def test_a_broken_rule_fails(name):
    finding = found("outlier_rule", name, rule_registry(RULES[name]))
    assert finding.state is State.FAIL, finding
    assert "Error: " not in finding.text


@pytest.mark.parametrize("name", RULES)
def test_a_good_rule_passes(name):
    finding = found("outlier_rule", name, rule_registry(grubbs, examples=()))
    assert finding.state is not State.FAIL, finding


@pytest.mark.parametrize("name", COMPENSATIONS)
def test_a_broken_compensation_fails(name):
    finding = found("compensation", name, compensation_registry(**COMPENSATIONS[name]))
    assert finding.state is State.FAIL, finding
    assert "Error: " not in finding.text
