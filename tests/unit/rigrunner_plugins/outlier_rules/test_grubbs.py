from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from rigrunner_plugins.outlier_rules.rules import Grubbs, keep_all
from rigrunner_plugins.outlier_rules.settings import GrubbsSettings

GOOD = np.array([1.00, 1.02, 0.98, 1.01, 0.99, 1.03, 0.97, 1.00])


def rejected(values, **changes):
    rule = Grubbs(GrubbsSettings(**changes))
    return [rejection.index for rejection in rule(np.asarray(values, float))]


def test_good_values_are_kept():
    assert rejected(GOOD) == []


def test_outliers_are_rejected_repeatedly_with_their_original_indices():
    assert rejected([*GOOD[:3], 9.0, *GOOD[3:], 1.4]) == [3, 9]


def test_statistic_is_that_of_the_remaining_values():
    values = np.array([*GOOD, 9.0])
    (rejection,) = Grubbs(GrubbsSettings())(values)
    assert rejection.statistic == pytest.approx((9.0 - values.mean()) / values.std(ddof=1))
    assert rejection.statistic > rejection.critical
    assert rejection.rule == "grubbs"


@pytest.mark.parametrize("value", [1.5, 0.5])
@pytest.mark.parametrize("side", ["both", "high", "low"])
def test_side_tests_its_own_extreme_only(value, side):
    tested = side == "both" or (side == "high") == (value > 1)
    assert rejected([*GOOD, value], side=side) == ([8] if tested else [])


def test_smaller_alpha_rejects_less():
    values = [*GOOD, 1.06]
    assert rejected([*GOOD, 1.085]) == [8]
    assert rejected([*GOOD, 1.085], alpha=0.001) == []
    assert rejected(values) == []


def test_outlier_among_values_with_tiny_scatter_is_rejected():
    """A frequency of 10 MHz with a resolution of 1 µHz: the example of the reference, scaled."""
    example = np.array([199.31, 199.53, 200.19, 200.82, 201.92, 201.95, 202.18, 245.57])
    values = 1e7 + np.round(example) * 2.0**-24  # exact in binary
    assert rejected(values, side="high")[0] == 7


@pytest.mark.parametrize("values", [[], [1.0], [1.0, 5.0], [0.1] * 10, [1.0, 1.0, 1.0 + 1e-15]])
def test_too_few_or_equal_values_are_kept(values):
    assert rejected(values) == []


@pytest.mark.parametrize("bad", [{"alpha": 0.0}, {"alpha": 0.5}, {"alpha": 1}, {"side": "left"}])
def test_invalid_settings_are_refused(bad):
    with pytest.raises(ValidationError):
        GrubbsSettings(**bad)


@settings(deadline=None, max_examples=60, derandomize=True)
@given(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=30))
def test_rejection_does_not_depend_on_order(values):
    outliers = {values[index] for index in rejected(values)}
    backwards = values[::-1]
    assert {backwards[index] for index in rejected(backwards)} == outliers


def test_false_alarm_rate_is_alpha():
    """Of 2000 samples of 20 normal values, 5 % lose a value: binomial 100 +/- 3 * 9.7."""
    rng = np.random.default_rng(3)
    alarms = sum(bool(rejected(rng.normal(size=20))) for _ in range(2000))
    assert 70 <= alarms <= 130


def test_none_keeps_all_values():
    assert keep_all(np.array([1.0, 1.0, 1e9])) == []
