"""Grubbs' test against published critical values and a published example."""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner_plugins.outlier_rules.rules import Grubbs, critical_value
from rigrunner_plugins.outlier_rules.settings import GrubbsSettings

# Mass spectrometer readings of uranium isotopes, Tietjen and Moore (1972), after Grubbs (1969)
URANIUM = np.array([199.31, 199.53, 200.19, 200.82, 201.92, 201.95, 202.18, 245.57])


@pytest.mark.parametrize(
    ("n", "critical"),
    [
        (3, 1.1543),
        (5, 1.7150),
        (8, 2.1266),
        (10, 2.2900),
        (20, 2.7082),
        (50, 3.1282),
        (100, 3.3841),
    ],
)
def test_two_sided_critical_values_5_percent(n, critical):
    assert critical_value(n, 0.05) == pytest.approx(critical, abs=5e-5)


@pytest.mark.parametrize(("n", "critical"), [(10, 2.4821), (20, 3.0008)])
def test_two_sided_critical_values_1_percent(n, critical):
    assert critical_value(n, 0.01) == pytest.approx(critical, abs=5e-5)


def test_one_sided_test_of_published_example():
    rejections = Grubbs(GrubbsSettings(side="high"))(URANIUM)
    assert [rejection.index for rejection in rejections] == [7]
    assert rejections[0].value == 245.57
    assert rejections[0].statistic == pytest.approx(2.46876, abs=5e-6)
    assert rejections[0].critical == pytest.approx(2.03165, abs=5e-6)
