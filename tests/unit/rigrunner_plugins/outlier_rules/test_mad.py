from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner_plugins.outlier_rules.rules import Mad, modified_z_score
from rigrunner_plugins.outlier_rules.settings import MadSettings


def rejected(values, **changes):
    return [rejection.index for rejection in Mad(MadSettings(**changes))(np.asarray(values, float))]


def test_threshold_decides():
    """By hand: median 3, MAD 1; 9 is 0.6745 * 6 = 4.05 out."""
    values = [1.0, 2.0, 3.0, 4.0, 9.0]
    assert rejected(values) == [4]
    assert rejected(values, threshold=4.0) == [4]
    assert rejected(values, threshold=4.1) == []


def test_almost_half_of_the_values_may_be_outliers():
    values = [1.0, 1.1, 0.9, 1.05, 0.95, 1.02, 9.0, 9.1, 9.2, -5.0]
    assert rejected(values) == [6, 7, 8, 9]


def test_mean_deviation_is_used_if_most_values_are_equal():
    """By hand: the mean distance of nine 1.0 and one 9.0 from 1.0 is 0.8; 8/(0.8 * 1.2533)."""
    values = np.array([1.0] * 9 + [9.0])
    assert modified_z_score(values)[9] == pytest.approx(8 / (0.8 * 1.2533141))
    assert rejected(values) == [9]


@pytest.mark.parametrize("settings", [{"threshold": 0.0}, {"threshold": -1.0}, {"alpha": 0.05}])
def test_invalid_settings_are_refused(settings):
    with pytest.raises(ValidationError):
        MadSettings(**settings)
