"""Properties of the shipped outlier rules beyond the conformance kit, and their page."""

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
"""The rules that reject any of n good values with probability alpha."""
PAGE = Path(__file__).parents[2] / "docs/reference/outlier-rules.md"
CYCLES = 30


def rule(name, **changes):
    return REGISTRY.make("outlier_rule", name, changes)


def normal(seed, n=CYCLES):
    return np.random.default_rng(seed).normal(2.0, 0.05, n)


@pytest.mark.parametrize("name", sorted(set(REJECTING) - {"chauvenet"}))
def test_rule_finds_three_outliers_of_different_size(name):
    """Applied once, Chauvenet's criterion finds only the greatest."""
    values = normal(1)
    values[[4, 11, 20]] = 4.0, 0.5, 7.0
    assert {rejection.index for rejection in rule(name)(values)} >= {4, 11, 20}


@pytest.mark.parametrize("name", ["generalized_esd", "mad"])
def test_rule_finds_outliers_that_mask_each_other(name):
    values = normal(1, 12)
    values[[3, 8]] = 2.6, 2.61
    assert {rejection.index for rejection in rule(name)(values)} == {3, 8}
    assert rule("grubbs")(values) == []


@pytest.mark.parametrize("name", sorted(FALSE_ALARMS))
@pytest.mark.parametrize("alpha", [0.05, 0.01])
def test_false_alarms_occur_at_the_stated_rate(name, alpha):
    """Of 2000 normal samples of 30 values; three standard deviations of the binomial."""
    samples = np.random.default_rng(6).normal(size=(2000, CYCLES))
    the_rule = rule(name, alpha=alpha)
    alarms = sum(bool(the_rule(values)) for values in samples)
    assert abs(alarms - 2000 * alpha) <= 3 * np.sqrt(2000 * alpha * (1 - alpha))


@pytest.mark.parametrize("name", sorted(FALSE_ALARMS))
@pytest.mark.parametrize("alpha", [1e-18, 1e-300])
@pytest.mark.parametrize("n", [5, 30])
def test_tiny_alpha_rejects_no_good_value(name, alpha, n):
    assert list(rule(name, alpha=alpha)(normal(2, n))) == []


@pytest.mark.parametrize("name", sorted(set(RULES) - {"pauta"}))
@pytest.mark.parametrize("n", [0, 1, 2])
def test_no_outlier_among_two_values(name, n):
    assert list(rule(name)(np.array([1.0, 9.0])[:n])) == []


def test_every_rule_is_documented_with_its_settings():
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    documented = {name: set(re.findall(r"`(\w+)`", what)) for name, what in rows}
    assert documented == {
        name: set(REGISTRY.settings_of("outlier_rule", name).model_fields) for name in RULES
    }


@pytest.mark.parametrize("name", sorted(set(REJECTING)))
@pytest.mark.parametrize("n", [15, 50])
def test_false_alarm_rates_on_the_page_are_right(name, n):
    """Of 1000 samples, within four standard errors of both measurements."""
    table = PAGE.read_text(encoding="utf-8").partition("| rule | n = ")[2]
    sizes, rows = table.splitlines()[0], re.findall(rf"^\| {name} \| (.*) \|", table, re.MULTILINE)
    stated = float(dict(zip(re.findall(r"\d+", sizes), rows[0].split(" | "), strict=True))[str(n)])
    samples = np.random.default_rng(7).normal(size=(1000, n))
    measured = 100 * np.mean([bool(rule(name)(values)) for values in samples])
    error = np.sqrt(measured * (100 - measured) * (1 / 1000 + 1 / 4000))
    assert abs(measured - stated) <= 4 * error + 0.5
