"""Capability indices and their intervals against published examples."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from rigrunner.api.errors import DataError
from rigrunner_fleet.trends.capability import capability, one_sided, smaller, two_sided


def test_interval_of_cp():
    """Montgomery, Introduction to Statistical Quality Control, 6th edition, example 8.4.

    USL 62, LSL 38, 20 values with s = 1.75: Cp = 2.29, and 1.57 <= Cp <= 3.01 with 95 %, computed
    there from 2.29 and a chi-square of 8.91, both rounded: 1.568; with all digits it is 1.565.
    """
    cp = two_sided((62.0 - 38.0) / (6.0 * 1.75), 20, 0.95)
    assert cp.value == pytest.approx(2.29, abs=5e-3)
    assert cp.low == pytest.approx(1.57, abs=6e-3)
    assert cp.high == pytest.approx(3.01, abs=5e-3)


def test_bissells_interval_of_cpk():
    """Cpk (1 -+ z sqrt(1/(9 n Cpk^2) + 1/(2(n - 1)))), by hand: 1.33 (1 -+ 1.960 x 0.17163)."""
    cpk = smaller(1.33, 20, 0.95)
    assert cpk.low == pytest.approx(0.8826, abs=2e-4)
    assert cpk.high == pytest.approx(1.7774, abs=2e-4)


@pytest.mark.thorough
def test_bissells_interval_has_about_stated_coverage():
    """Bissell, Appl. Stat. 39 (1990) 331-340: approximate, for values that are normal."""
    rng = np.random.default_rng(7)
    covered = 0
    for _ in range(500):
        result = capability(rng.normal(0.4, 1.0, 40), lower=-4.0, upper=4.0)
        covered += result.indices[1].low <= 1.2 <= result.indices[1].high
    assert covered / 500 == pytest.approx(0.95, abs=0.03)


@pytest.mark.parametrize(
    ("count", "within", "confidence", "factor"),
    [
        (10, 0.90, 0.95, 2.355),
        (10, 0.99, 0.95, 3.981),
        (20, 0.90, 0.95, 1.926),
        (20, 0.99, 0.95, 3.295),
        (43, 0.90, 0.99, 1.8740),
    ],
)
def test_interval_of_one_sided_index(count, within, confidence, factor):
    """One-sided tolerance factors: Natrella, NBS Handbook 91 (1963), table A-7; NIST 7.2.6.3 (43).

    With mean + k s at the limit, at least that part of all values is within it with the factor's
    confidence: the true index is at least z/3 if the estimated one is k/3.
    """
    low = one_sided("Cpu", factor / 3.0, count, 2.0 * confidence - 1.0).low
    assert 3.0 * low == pytest.approx(stats.norm.ppf(within), abs=6e-4)


@pytest.mark.parametrize("index", [1e3, 1e5, 1e8, -1e5])
@pytest.mark.parametrize("count", [10, 1000])
def test_far_limit_has_interval_of_standard_deviation(index, count):
    """So far out the mean is practically exact: only s scatters, by chi-square."""
    cpu = one_sided("Cpu", index, count, 0.95)
    factors = np.sqrt(stats.chi2.ppf([0.025, 0.975], count - 1) / (count - 1))
    assert [cpu.low, cpu.high] == pytest.approx(sorted(index * factors), rel=1e-6)


def test_far_interval_continues_the_exact_one():
    near, far = (one_sided("Cpu", 100.0 * index, 10, 0.95) for index in (0.3162, 0.3163))
    assert far.low / near.low == pytest.approx(0.3163 / 0.3162, rel=2e-4)
    assert far.high / near.high == pytest.approx(0.3163 / 0.3162, rel=2e-4)


def test_one_sided_interval_has_stated_coverage():
    rng = np.random.default_rng(6)
    true, covered = 1.2, 0
    for _ in range(500):
        (index,) = capability(rng.normal(0.0, 1.0, 25), upper=3.6).indices
        covered += index.low <= true <= index.high
    assert covered / 500 == pytest.approx(0.95, abs=0.03)


def test_indices_depend_on_given_limits():
    values = np.linspace(9.0, 12.0, 20)
    assert [index.name for index in capability(values, lower=8.0).indices] == ["Cpl"]
    result = capability(values, lower=8.0, upper=20.0)
    assert [index.name for index in result.indices] == ["Cp", "Cpk", "Cpu", "Cpl"]
    cp, cpk, cpu, cpl = (index.value for index in result.indices)
    deviation = np.std(values, ddof=1)
    assert cpl == cpk == pytest.approx((10.5 - 8.0) / (3 * deviation))
    assert cpu == pytest.approx((20.0 - 10.5) / (3 * deviation))
    assert cp == pytest.approx(12.0 / (6 * deviation))


@pytest.mark.parametrize(
    ("values", "limits"),
    [
        ([1.0], {"upper": 20.0}),
        (range(20), {}),
        (range(20), {"lower": 5.0, "upper": 5.0}),
        ([1.0] * 20, {"upper": 5.0}),
        ([0.72] * 30, {"upper": 5.0}),  # their deviation is 1e-16, as the mean is rounded
    ],
)
def test_data_without_capability_are_refused(values, limits):
    with pytest.raises(DataError):
        capability(list(values), **limits)


def test_lot_of_five_has_intervals_of_student_and_chi_square():
    """t(4) = 2.776 (JCGM 100:2008, Table G.2); chi-square(4) 0.4844 and 11.143 (NIST 1.3.6.7.4)."""
    result = capability([9.98, 10.02, 10.0, 10.03, 9.97], lower=9.9, upper=10.1)
    deviation = 0.0254951  # sqrt(0.0026 / 4)
    half = 2.776 * deviation / 5**0.5
    assert result.mean_interval == pytest.approx((10.0 - half, 10.0 + half), abs=1e-5)
    ends = tuple(deviation * (4 / chi2) ** 0.5 for chi2 in (11.143, 0.4844))
    assert result.deviation_interval == pytest.approx(ends, rel=1e-4)
    cp = result.indices[0]
    assert (cp.low, cp.high) == pytest.approx(
        tuple(0.2 / (6 * sigma) for sigma in ends[::-1]), rel=1e-4
    )


@pytest.mark.parametrize("count", [2, 3, 5])
@pytest.mark.parametrize("upper", [-3.0, 0.5, 3.6, 1000.0])
def test_one_sided_interval_of_few_values_has_its_coverage(count, upper):
    rng = np.random.default_rng(count)
    covered = 0
    for _ in range(400):
        (index,) = capability(rng.normal(0.0, 1.0, count), upper=upper).indices
        covered += index.low <= upper / 3.0 <= index.high
    assert covered / 400 == pytest.approx(0.95, abs=0.035)


def test_one_sided_interval_of_a_process_outside_its_limit():
    """Ends by quadrature over chi: SciPy's distribution function ended in NaN on the way."""
    index = one_sided("Cpl", -1.37, 10, 0.95)
    assert (index.low, index.high) == pytest.approx((-2.0219097, -0.7125980), rel=1e-6)
