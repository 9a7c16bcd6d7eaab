"""AIAG, Measurement Systems Analysis, 4th edition (2010): 10 parts, 3 appraisers, 3 trials.

The readings are those of figure III-B 6a, the expected numbers as printed in tables A 3 and A 4,
except the F of parts and operators: the manual divides by the repeatability (213.52 and 34.44),
here the divisor is the interaction, as in the model with random effects (Montgomery; Burdick,
Borror and Montgomery), computed from the printed mean squares.
"""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner_fleet.trends.gauge_rr import gauge_rr

APPRAISERS = (
    (
        (0.29, -0.56, 1.34, 0.47, -0.80, 0.02, 0.59, -0.31, 2.26, -1.36),
        (0.41, -0.68, 1.17, 0.50, -0.92, -0.11, 0.75, -0.20, 1.99, -1.25),
        (0.64, -0.58, 1.27, 0.64, -0.84, -0.21, 0.66, -0.17, 2.01, -1.31),
    ),
    (
        (0.08, -0.47, 1.19, 0.01, -0.56, -0.20, 0.47, -0.63, 1.80, -1.68),
        (0.25, -1.22, 0.94, 1.03, -1.20, 0.22, 0.55, 0.08, 2.12, -1.62),
        (0.07, -0.68, 1.34, 0.20, -1.28, 0.06, 0.83, -0.34, 2.19, -1.50),
    ),
    (
        (0.04, -1.38, 0.88, 0.14, -1.46, -0.29, 0.02, -0.46, 1.77, -1.49),
        (-0.11, -1.13, 1.09, 0.20, -1.07, -0.67, 0.01, -0.56, 1.45, -1.77),
        (-0.15, -0.96, 0.67, 0.11, -1.45, -0.49, 0.21, -0.49, 1.87, -2.16),
    ),
)
READINGS = np.array(APPRAISERS).transpose(2, 0, 1)


@pytest.mark.parametrize(
    ("source", "dof", "sum_of_squares", "mean_square", "f"),
    [
        ("operator", 2, 3.1673, 1.58363, 79.41),
        ("part", 9, 88.3619, 9.81799, 492.29),
        ("part x operator", 18, 0.3590, 0.01994, 0.434),
        ("repeatability", 60, 2.7589, 0.04598, None),
        ("total", 89, 94.6471, None, None),
    ],
)
def test_table_equals_printed_one(source, dof, sum_of_squares, mean_square, f):
    (row,) = [row for row in gauge_rr(READINGS).table if row.source == source]
    assert row.degrees_of_freedom == dof
    assert row.sum_of_squares == pytest.approx(sum_of_squares, abs=5e-5)
    if mean_square is not None:
        assert row.mean_square == pytest.approx(mean_square, abs=5e-6)
    if f is not None:
        assert row.f == pytest.approx(f, abs=5e-3 if f > 1 else 5e-4)


@pytest.mark.parametrize(("source", "printed"), [("part", 213.52), ("operator", 34.44)])
def test_f_of_manual_is_relative_to_repeatability(source, printed):
    rows = {row.source: row for row in gauge_rr(READINGS).table}
    f = rows[source].mean_square / rows["repeatability"].mean_square
    assert f == pytest.approx(printed, abs=1e-2)


def test_components_equal_printed_ones():
    study = gauge_rr(READINGS)
    assert study.pooled
    components = study.components
    assert components.repeatability == pytest.approx(0.199933, abs=5e-7)
    assert components.operator == pytest.approx(0.226838, abs=5e-7)
    assert components.interaction == 0.0
    assert components.gauge == pytest.approx(0.302373, abs=2e-6)
    assert components.part == pytest.approx(1.042327, abs=5e-7)
    assert components.total == pytest.approx(1.0853, abs=5e-5)
    assert 100.0 * components.gauge / components.total == pytest.approx(27.9, abs=0.05)
    assert int(components.distinct_categories) == 4


def test_significant_interaction_is_not_pooled():
    rng = np.random.default_rng(3)
    cells = rng.normal(0.0, 1.0, (10, 3, 1))
    study = gauge_rr(cells + rng.normal(0.0, 0.1, (10, 3, 5)))
    assert not study.pooled
    assert study.components.interaction > 0.5


def test_interaction_is_pooled_if_p_is_above_a_quarter():
    rng = np.random.default_rng(8)
    studies = [gauge_rr(rng.normal(size=(5, 3, 2))) for _ in range(60)]
    results = [(study.table[2].p, study.pooled) for study in studies]
    assert all(pooled == (p > 0.25) for p, pooled in results)
    assert sum(0.1 < p < 0.25 for p, _ in results) > 3
    assert sum(0.25 < p < 0.5 for p, _ in results) > 3


@pytest.mark.thorough
def test_mean_components_are_those_of_simulation():
    """Over many studies the mean variances equal those of the simulated readings."""
    rng = np.random.default_rng(4)
    squares = np.zeros(3)
    for _ in range(400):
        readings = (
            rng.normal(0.0, 2.0, (8, 1, 1))
            + rng.normal(0.0, 0.5, (1, 5, 1))
            + rng.normal(0.0, 0.3, (8, 5, 3))
        )
        components = gauge_rr(readings).components
        squares += np.square([components.part, components.operator, components.repeatability])
    assert squares / 400 == pytest.approx([4.0, 0.25, 0.09], rel=0.12)


@pytest.mark.parametrize(
    "readings",
    [np.zeros((3, 2, 2)), np.zeros((3, 2)), np.ones((1, 3, 3)), np.full((3, 3, 3), np.nan)],
)
def test_invalid_study_is_refused(readings):
    with pytest.raises(DataError):
        gauge_rr(readings)
