"""JCGM 100:2008 (the GUM), H.1: calibration of an end gauge by comparison with a standard.

Inputs of Table H.1 and H.1.2 to H.1.4, lengths in nm; the published results are 50.000 838 mm,
u_c = 32 nm, 16 degrees of freedom, U_99 = 93 nm (H.1.7).
"""

from __future__ import annotations

from math import floor, inf, sqrt

import pytest

from rigrunner.api.uncertainty import Distribution, Input, MeasurementModel
from rigrunner.signal.propagation import propagate
from rigrunner.signal.uncertainty import coverage_factor

RECTANGULAR = Distribution.RECTANGULAR
INPUTS = (
    Input("standard", 50_000_623.0, 25.0, 18, unit="nm"),
    Input("mean difference", 215.0, 5.8, 24, Distribution.T, unit="nm"),
    Input("comparator, random", 0.0, 3.9, 5, unit="nm"),
    Input("comparator, systematic", 0.0, 6.7, 8, unit="nm"),
    Input("expansion", 11.5e-6, 2e-6 / sqrt(3), inf, RECTANGULAR, unit="1/°C"),
    Input("difference in expansion", 0.0, 1e-6 / sqrt(3), 50, RECTANGULAR, unit="1/°C"),
    Input("mean deviation of temperature", -0.1, 0.2, inf, unit="°C"),
    Input("its variation", 0.0, 0.5 / sqrt(2), inf, Distribution.ARCSINE, unit="°C"),
    Input("difference in temperature", 0.0, 0.05 / sqrt(3), 2, RECTANGULAR, unit="°C"),
)


def length(x):
    difference = x["mean difference"] + x["comparator, random"] + x["comparator, systematic"]
    deviation = x["mean deviation of temperature"] + x["its variation"]
    expanded = x["difference in expansion"] * deviation
    expanded = expanded + x["expansion"] * x["difference in temperature"]
    return x["standard"] * (1 - expanded) + difference


@pytest.fixture(scope="module")
def result():
    return propagate(MeasurementModel(INPUTS, length))


def test_length_and_its_uncertainty(result):
    assert result.estimate.value == pytest.approx(50_000_838, abs=1e-6)
    assert round(result.estimate.u) == 32
    assert result.estimate.dof == pytest.approx(16.7, abs=0.1)


def test_expanded_uncertainty_of_99_percent(result):
    factor = coverage_factor(floor(result.estimate.dof), 0.99)
    assert factor == pytest.approx(2.92, abs=0.005)
    assert round(factor * round(result.estimate.u)) == 93  # the guide takes u_c as rounded, 32 nm
    assert factor * result.estimate.u == pytest.approx(92.5, abs=0.05)  # 2.9208 times 31.66 nm


def test_contributions_of_table_h_1(result):
    """Each |c_i| u(x_i) as in the table, in nm."""
    u = {part.name: part.u for part in result.components}
    assert u["standard"] == pytest.approx(25, abs=0.5)
    parts = ("mean difference", "comparator, random", "comparator, systematic")
    assert sqrt(sum(u[name] ** 2 for name in parts)) == pytest.approx(9.7, abs=0.05)
    assert u["difference in expansion"] == pytest.approx(2.9, abs=0.05)
    assert u["difference in temperature"] == pytest.approx(16.6, abs=0.05)
    assert u["expansion"] == 0
    assert u["mean deviation of temperature"] == pytest.approx(0, abs=1e-6)
