"""NIST/SEMATECH e-Handbook of Statistical Methods, 6.3.2.2 (individuals) and 6.3.2.4 (EWMA)."""

from __future__ import annotations

import pytest

from rigrunner_fleet.trends.charts import ewma, individuals

FLOW_RATES = (49.6, 47.6, 49.9, 51.3, 47.8, 51.2, 52.6, 52.4, 53.6, 52.1)
EWMA_VALUES = (
    52.0, 47.0, 53.0, 49.3, 50.1, 47.0, 51.0, 50.1, 51.2, 50.5,
    49.6, 47.6, 49.9, 51.3, 47.8, 51.2, 52.6, 52.4, 53.6, 52.1,
)  # fmt: skip
EWMA_PRINTED = (
    50.60, 49.52, 50.56, 50.18, 50.16, 49.21, 49.75, 49.85, 50.26, 50.33,
    50.11, 49.36, 49.52, 50.05, 49.38, 49.92, 50.73, 51.23, 51.94, 51.99,
)  # fmt: skip
"""With the target, 50, as the value before the first."""


def test_individuals_chart():
    chart = individuals(FLOW_RATES)
    assert chart.individuals.centre == pytest.approx(50.81, abs=5e-3)
    assert chart.moving_range.centre == pytest.approx(1.8778, abs=5e-5)
    # printed with 1.128 for 2/sqrt(pi) = 1.12838: 3 x 1.8778/1.128 = 4.9941
    assert chart.individuals.upper == pytest.approx(55.8041, abs=2e-3)
    assert chart.individuals.lower == pytest.approx(45.8159, abs=2e-3)


def test_ewma_chart():
    """The printed process has the mean 50, the standard deviation 2.0539 and the weight 0.3."""
    chart = ewma(EWMA_VALUES, 50.0, 2.0539, weight=0.3)
    assert chart.values == pytest.approx(EWMA_PRINTED, abs=6e-3)
    assert chart.upper[-1] == pytest.approx(52.5884, abs=1e-3)
    assert chart.lower[-1] == pytest.approx(47.4115, abs=1e-3)
