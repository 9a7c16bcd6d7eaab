from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner_plugins.outlier_rules.rules import GeneralizedEsd, Grubbs
from rigrunner_plugins.outlier_rules.settings import GeneralizedEsdSettings, GrubbsSettings

GOOD = np.array([1.00, 1.02, 0.98, 1.01, 0.99, 1.03, 0.97, 1.00, 1.01, 0.99, 1.02, 0.98])


def rejected(values, **changes):
    rule = GeneralizedEsd(GeneralizedEsdSettings(**changes))
    return [rejection.index for rejection in rule(np.asarray(values, float))]


def test_masked_outlier_is_rejected_with_its_group():
    """9.0 and 9.1 among 14: (9.1 - 2.15)/2.92 = 2.38 is below 2.51, and without it 9.0 exceeds."""
    rejections = GeneralizedEsd(GeneralizedEsdSettings())(np.array([*GOOD, 9.0, 9.1]))
    assert [rejection.index for rejection in rejections] == [13, 12]
    assert rejections[0].statistic < rejections[0].critical
    assert rejections[1].statistic > rejections[1].critical


@pytest.mark.parametrize(("n", "limit"), [(3, 1), (4, 1), (14, 2), (15, 3), (30, 6)])
def test_one_in_five_values_may_be_an_outlier(n, limit):
    good = np.resize(GOOD, n)
    spoiled = good.copy()
    spoiled[:limit] = 1e4 * 3.0 ** np.arange(limit)
    assert rejected(spoiled) == list(reversed(range(limit)))
    spoiled[limit] = 3e3
    assert len(rejected(spoiled)) <= limit


def test_no_more_than_at_most_are_rejected():
    values = np.resize(GOOD, 30)
    values[[3, 4, 5]] = 50.0, 500.0, 5000.0
    assert rejected(values, at_most=2) == [5, 4]
    assert rejected(values, at_most=3) == [5, 4, 3]


@pytest.mark.parametrize("value", [1.1, 9.0])
def test_one_outlier_is_grubbs_test(value):
    values = np.array([*GOOD, value])
    ours = GeneralizedEsd(GeneralizedEsdSettings(at_most=1))(values)
    theirs = Grubbs(GrubbsSettings())(values)
    assert [(e.index, e.statistic, e.critical) for e in ours] == [
        (e.index, e.statistic, e.critical) for e in theirs
    ]


@pytest.mark.parametrize(
    "settings", [{"alpha": 0.0}, {"alpha": 0.5}, {"at_most": 0}, {"at_most": 2.0}, {"side": "high"}]
)
def test_invalid_settings_are_refused(settings):
    with pytest.raises(ValidationError):
        GeneralizedEsdSettings(**settings)
