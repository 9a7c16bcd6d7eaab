"""Confidence intervals of the components of a gauge study.

By generalised inference (Hamada and Weerahandi, J. Quality Technology 32, 2000, 241; Burdick,
Borror and Montgomery, Design and Analysis of Gauge R&R Studies, 2005): each expected mean square is
its sum of squares over a draw of chi-squared, and a component the same combination of these as of
the mean squares. Degrees of freedom by Satterthwaite.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.studies import Known

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.data import Array
    from rigrunner.api.studies import Row

CONFIDENCE = 0.95
DRAWS = 20_000
SEED = 20001
"""Seed of the draws: the same study has the same intervals."""


def known(rows: tuple[Row, ...], shape: tuple[int, ...], *, pooled: bool) -> Mapping[str, Known]:
    """Return the interval of each component.

    `rows` are part, operator, both and repeatability; `shape` is (parts, operators, trials). If
    pooled, the interaction is part of the repeatability.
    """
    parts, operators, trials = shape
    squares = np.array([each.sum_of_squares for each in rows])
    dof = np.array([each.degrees_of_freedom for each in rows])
    of_operator = np.array([0, 1, -1, 0]) / (parts * trials)
    of_both = np.array([0, 0, 1, -1]) / trials
    repeatability = np.array([0, 0, 0, 1.0])
    combinations = {
        "repeatability": repeatability,
        "operator": of_operator,
        "interaction": of_both,
        "reproducibility": of_operator + of_both,
        "gauge": of_operator + of_both + repeatability,
        "part": np.array([1, 0, -1, 0]) / (operators * trials),
    }
    if pooled:
        del combinations["interaction"]
        squares[3], dof[3] = squares[2] + squares[3], dof[2] + dof[3]
        for weights in combinations.values():
            weights[3], weights[2] = weights[2] + weights[3], 0
        combinations["reproducibility"] = combinations["operator"]
        combinations["gauge"] = combinations["operator"] + repeatability
    drawn = squares / np.random.default_rng(SEED).chisquare(dof, (DRAWS, 4))
    tails = (1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2
    return {
        name: _known(weights, squares / dof, dof, np.quantile(drawn @ weights, tails))
        for name, weights in combinations.items()
    }


def _known(weights: Array, mean_squares: Array, dof: Array, interval: Array) -> Known:
    """Return a component as a standard deviation; a negative variance is taken as 0."""
    terms = weights * mean_squares
    variance, spread = terms.sum(), np.sum(terms**2 / dof)
    freedom = float(variance**2 / spread) if variance > 0 else 0.0
    low, high = np.sqrt(np.maximum(interval, 0.0))
    return Known(float(low), float(high), CONFIDENCE, freedom)
