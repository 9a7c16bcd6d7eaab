"""The rules for gross errors against published examples and critical values."""

from __future__ import annotations

import statistics
from math import sqrt

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner_plugins.outlier_rules.rules import (
    GeneralizedEsd,
    Grubbs,
    Mad,
    chauvenet,
    chauvenet_critical_value,
    modified_z_score,
    pauta,
    suspects,
)
from rigrunner_plugins.outlier_rules.settings import (
    GeneralizedEsdSettings,
    GrubbsSettings,
    MadSettings,
)

# Rosner, Technometrics 25(2), 1983, as in the NIST/SEMATECH e-Handbook, 1.3.5.17.3
ROSNER = np.array([
    -0.25, 0.68, 0.94, 1.15, 1.20, 1.26, 1.26, 1.34, 1.38, 1.43, 1.49, 1.49, 1.55, 1.56,
    1.58, 1.65, 1.69, 1.70, 1.76, 1.77, 1.81, 1.91, 1.94, 1.96, 1.99, 2.06, 2.09, 2.10,
    2.14, 2.15, 2.23, 2.24, 2.26, 2.35, 2.37, 2.40, 2.47, 2.54, 2.62, 2.64, 2.90, 2.92,
    2.92, 2.93, 3.21, 3.26, 3.30, 3.59, 3.68, 4.30, 4.64, 5.34, 5.42, 6.01,
])  # fmt: skip
# Statistic and critical value of each step as printed there, truncated to three decimals
PRINTED = [
    (3.118, 3.158), (2.942, 3.151), (3.179, 3.143), (2.810, 3.136), (2.815, 3.128),
    (2.848, 3.120), (2.279, 3.111), (2.310, 3.103), (2.101, 3.094), (2.067, 3.085),
]  # fmt: skip
# Taylor, An Introduction to Error Analysis, 6.1: six times of a pendulum, in s
TAYLOR = np.array([3.8, 3.5, 3.9, 3.9, 3.4, 1.8])


def truncated(value):
    return int(value * 1000) / 1000


def test_rosner_rejects_three():
    rejections = GeneralizedEsd(GeneralizedEsdSettings(at_most=10))(ROSNER)
    assert [rejection.value for rejection in rejections] == [6.01, 5.42, 5.34]
    assert [
        (truncated(rejection.statistic), truncated(rejection.critical)) for rejection in rejections
    ] == PRINTED[:3]


def test_statistics_of_every_rosner_step():
    rule = GeneralizedEsd(GeneralizedEsdSettings(at_most=10))
    steps = [step for step, _ in zip(suspects("", ROSNER, rule._suspect), PRINTED, strict=False)]
    assert [(truncated(step.statistic), truncated(step.critical)) for step in steps] == PRINTED


def test_repeated_grubbs_test_is_masked():
    assert Grubbs(GrubbsSettings())(ROSNER) == []


@pytest.mark.parametrize(
    ("n", "k"), [(3, 1.383), (5, 1.645), (10, 1.960), (20, 2.241), (50, 2.576), (100, 2.807)]
)
def test_chauvenet_critical_values(n, k):
    assert chauvenet_critical_value(n) == pytest.approx(k, abs=5e-4)


def test_chauvenet_rejects_the_fast_pendulum_value():
    """Mean 3.38, s 0.80: 1.8 is two standard deviations out, and 6 * 5 % < 1/2."""
    (only,) = chauvenet(TAYLOR)
    assert only.value == 1.8
    assert only.statistic == pytest.approx((TAYLOR.mean() - 1.8) / TAYLOR.std(ddof=1))
    assert only.critical == pytest.approx(1.732, abs=5e-4)


def test_modified_z_score_of_rosner_data():
    """The 27th and 28th of the 54 values are 2.09 and 2.10."""
    median = (2.09 + 2.10) / 2
    mad = statistics.median(abs(value - median) for value in ROSNER)
    assert modified_z_score(ROSNER)[-1] == pytest.approx(0.6745 * (6.01 - median) / mad, rel=1e-4)
    assert modified_z_score(ROSNER)[0] == pytest.approx(0.6745 * (median + 0.25) / mad, rel=1e-4)
    rejections = Mad(MadSettings())(ROSNER)
    assert [rejection.value for rejection in rejections] == [5.34, 5.42, 6.01]


@pytest.mark.parametrize("n", [3, 5, 10])
def test_three_sigma_is_refused_if_it_cannot_reject(n):
    """Shiffler (1988): in n values no |z| exceeds (n - 1)/sqrt(n), which is 2.85 for n = 10."""
    with pytest.raises(DataError, match=rf"none of {n} values.*= {(n - 1) / sqrt(n):.2f}"):
        pauta(np.array([0.0] * (n - 1) + [1e9]))


def test_three_sigma_rejects_one_of_eleven():
    (only,) = pauta(np.array([0.0] * 10 + [1e9]))
    assert only.statistic == pytest.approx(10 / sqrt(11))
    assert only.critical == 3.0
