"""Gauge repeatability and reproducibility by analysis of variance, crossed and balanced.

AIAG, Measurement Systems Analysis, 4th edition (2010), chapter III, section B and appendix A.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
from scipy import special

from rigrunner.api.errors import DataError
from rigrunner.api.studies import Components, GaugeAnalysis, Known, Row

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

    from rigrunner.api.data import Array


POOLING_LEVEL = 0.25
"""The interaction is pooled with the error where its p-value is above it (AIAG, appendix A)."""


def gauge_rr(readings: npt.ArrayLike) -> GaugeAnalysis:
    """Analyse readings of shape (parts, operators, trials), at least 2 of each.

    Negative estimates of a variance are taken as zero (AIAG, appendix A). Raises DataError for
    another shape, a reading that is not finite, or readings that are all equal.
    """
    values = _checked(readings)
    parts, operators, trials = values.shape
    rows = _table(values)
    part, operator, crossed, error, _ = rows
    pooled = crossed.p is not None and crossed.p > POOLING_LEVEL
    if pooled:
        square = (crossed.sum_of_squares + error.sum_of_squares) / (
            crossed.degrees_of_freedom + error.degrees_of_freedom
        )
        repeatability, interaction, reference = square, 0.0, square
    else:
        repeatability, reference = error.mean_square, crossed.mean_square
        interaction = max(0.0, (crossed.mean_square - error.mean_square) / trials)
    components = Components(
        repeatability=sqrt(repeatability),
        operator=sqrt(max(0.0, (operator.mean_square - reference) / (parts * trials))),
        interaction=sqrt(interaction),
        part=sqrt(max(0.0, (part.mean_square - reference) / (operators * trials))),
    )
    return GaugeAnalysis(rows, pooled, components, intervals(rows[:4], values.shape, pooled=pooled))


def _table(values: npt.NDArray[np.float64]) -> tuple[Row, ...]:
    parts, operators, trials = values.shape
    mean = values.mean()
    by_part, by_operator = values.mean(axis=(1, 2)), values.mean(axis=(0, 2))
    cells = values.mean(axis=2)
    of_parts = operators * trials * float(((by_part - mean) ** 2).sum())
    of_operators = parts * trials * float(((by_operator - mean) ** 2).sum())
    residuals = cells - by_part[:, None] - by_operator[None, :] + mean
    of_both = trials * float((residuals**2).sum())
    of_error = float(((values - cells[:, :, None]) ** 2).sum())
    of_all = float(((values - mean) ** 2).sum())
    error = _row("repeatability", parts * operators * (trials - 1), of_error)
    crossed = _row("part x operator", (parts - 1) * (operators - 1), of_both, error)
    return (
        _row("part", parts - 1, of_parts, crossed),
        _row("operator", operators - 1, of_operators, crossed),
        crossed,
        error,
        _row("total", values.size - 1, of_all),
    )


def _row(source: str, dof: int, squares: float, denominator: Row | None = None) -> Row:
    mean = squares / dof
    if denominator is None or denominator.mean_square == 0.0:
        return Row(source, dof, squares, mean)
    f = mean / denominator.mean_square
    return Row(
        source, dof, squares, mean, f, float(special.fdtrc(dof, denominator.degrees_of_freedom, f))
    )


def _checked(readings: npt.ArrayLike) -> npt.NDArray[np.float64]:
    values = np.asarray(readings, dtype=np.float64)
    if values.ndim != 3 or min(values.shape) < 2:  # noqa: PLR2004  (three factors, two of each)
        shape = " x ".join(map(str, values.shape))
        raise DataError(
            f"readings of {shape} are not a crossed study",
            hint="parts x operators x trials, at least 2 of each",
        )
    if not np.isfinite(values).all():
        raise DataError("a reading is not a finite number")
    if np.ptp(values) == 0.0:
        raise DataError("all readings are the same: there is no variance to analyse")
    return values


CONFIDENCE = 0.95
DRAWS = 20_000
SEED = 20001
"""Seed of the draws: the same study has the same intervals."""


def intervals(
    rows: tuple[Row, ...], shape: tuple[int, ...], *, pooled: bool
) -> Mapping[str, Known]:
    """Return the interval of each component.

    `rows` are part, operator, interaction and repeatability; `shape` is (parts, operators,
    trials). If pooled, the interaction is part of the repeatability.
    """
    parts, operators, trials = shape
    squares = np.array([row.sum_of_squares for row in rows])
    dof = np.array([row.degrees_of_freedom for row in rows])
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
    # A sum of squares over its variance is chi-squared: possible variances are drawn from that.
    drawn = squares / np.random.default_rng(SEED).chisquare(dof, (DRAWS, 4))
    tails = (1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2
    return {
        name: _interval(weights, squares / dof, dof, np.quantile(drawn @ weights, tails))
        for name, weights in combinations.items()
    }


def _interval(weights: Array, mean_squares: Array, dof: Array, limits: Array) -> Known:
    """Return a component as a standard deviation; a negative variance is taken as 0."""
    terms = weights * mean_squares
    # Satterthwaite's degrees of freedom of a sum of mean squares.
    variance, spread = terms.sum(), np.sum(terms**2 / dof)
    freedom = float(variance**2 / spread) if variance > 0 else 0.0
    low, high = np.sqrt(np.maximum(limits, 0.0))
    return Known(float(low), float(high), CONFIDENCE, freedom)
