"""What the rules that ship promise beyond the conformance kit, and what their page says."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from rigrunner.registry import load_registry

REGISTRY = load_registry()
RULES = REGISTRY.names("outlier_rule")
REJECTING = [name for name in RULES if name != "none"]
FALSE_ALARMS = {"grubbs", "generalized_esd"}
"""The rules that promise to reject any of n good values with risk alpha, and no more often."""
PAGE = Path(__file__).parents[2] / "docs/reference/outlier-rules.md"
CYCLES = 30


def rule(name, **changes):
    return REGISTRY.make("outlier_rule", name, changes)


def normal(seed, n=CYCLES):
    return np.random.default_rng(seed).normal(2.0, 0.05, n)


@pytest.mark.parametrize("name", sorted(set(REJECTING) - {"chauvenet"}))
def test_it_finds_three_of_unlike_size(name):
    """Applied once, Chauvenet's criterion sees the greatest alone."""
    values = normal(1)
    values[[4, 11, 20]] = 4.0, 0.5, 7.0
    assert {each.index for each in rule(name)(values)} >= {4, 11, 20}


@pytest.mark.parametrize("name", ["generalized_esd", "mad"])
def test_it_finds_such_as_mask_each_other(name):
    values = normal(1, 12)
    values[[3, 8]] = 2.6, 2.61
    assert {each.index for each in rule(name)(values)} == {3, 8}
    assert rule("grubbs")(values) == []


@pytest.mark.parametrize("name", sorted(FALSE_ALARMS))
@pytest.mark.parametrize("alpha", [0.05, 0.01])
def test_false_alarms_are_as_rare_as_promised(name, alpha):
    """Of 2000 normal samples of 30 values; three standard deviations of the binomial."""
    samples = np.random.default_rng(6).normal(size=(2000, CYCLES))
    the_rule = rule(name, alpha=alpha)
    alarms = sum(bool(the_rule(values)) for values in samples)
    assert abs(alarms - 2000 * alpha) <= 3 * np.sqrt(2000 * alpha * (1 - alpha))


@pytest.mark.parametrize("name", sorted(FALSE_ALARMS))
@pytest.mark.parametrize("alpha", [1e-18, 1e-300])
@pytest.mark.parametrize("n", [5, 30])
def test_a_risk_of_almost_nothing_rejects_nothing_good(name, alpha, n):
    assert list(rule(name, alpha=alpha)(normal(2, n))) == []


@pytest.mark.parametrize("name", sorted(set(RULES) - {"pauta"}))
@pytest.mark.parametrize("n", [0, 1, 2])
def test_of_two_values_none_is_the_odd_one(name, n):
    assert list(rule(name)(np.array([1.0, 9.0])[:n])) == []


def test_every_rule_is_on_its_page_with_its_settings():
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    shown = {name: set(re.findall(r"`(\w+)`", what)) for name, what in rows}
    assert shown == {
        name: set(REGISTRY.settings_of("outlier_rule", name).model_fields) for name in RULES
    }


@pytest.mark.parametrize("name", sorted(set(REJECTING)))
@pytest.mark.parametrize("n", [15, 50])
def test_the_false_alarms_of_the_page_are_those_of_the_rule(name, n):
    """Of 1000 samples, within four standard errors of both measurements."""
    table = PAGE.read_text(encoding="utf-8").partition("| rule | n = ")[2]
    sizes, rows = table.splitlines()[0], re.findall(rf"^\| {name} \| (.*) \|", table, re.MULTILINE)
    stated = float(dict(zip(re.findall(r"\d+", sizes), rows[0].split(" | "), strict=True))[str(n)])
    samples = np.random.default_rng(7).normal(size=(1000, n))
    found = 100 * np.mean([bool(rule(name)(values)) for values in samples])
    error = np.sqrt(found * (100 - found) * (1 / 1000 + 1 / 4000))
    assert abs(found - stated) <= 4 * error + 0.5
