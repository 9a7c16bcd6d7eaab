"""The second-order variance of a model's result (GUM 5.1.2, note).

For independent inputs in units of their standard uncertainties z, with excess kurtosis k:

    sum over i, j of [ f_ij^2/2 + f_i f_ijj ],
    and for i = j instead:  f_ii^2 (k + 2)/4 + f_i f_iii (k + 3)/3.

With k = 0 this is the formula of the note, for normal inputs. Correlated inputs are transformed to
independent directions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.coverage import KURTOSIS
from rigrunner.signal.propagation import connected, one_error

if TYPE_CHECKING:
    from rigrunner.api import Array, MeasurementModel
    from rigrunner.api.uncertainty import Differentiable

STEP = 1e-2
"""Step of the gradient's differences, in standard uncertainties."""


def added_variance(model: MeasurementModel, equation: Differentiable) -> float:
    """Return the variance that the second-order terms add; it may be negative."""
    if not model.inputs:
        return 0.0
    directions, kurtosis = _independent(model)
    count = len(directions)
    x = np.array([input_.value for input_ in model.inputs])
    steps = STEP * directions
    at = np.concatenate([x[None, :], x + steps, x - steps])
    gradient = _gradient(model, equation, at)  # (1 + 2 m, n)
    slopes = directions @ gradient.T  # f_j at each place, (m, 1 + 2 m)
    here, above, below = slopes[:, 0], slopes[:, 1 : 1 + count], slopes[:, 1 + count :]
    second = (above - below) / (2 * STEP)  # f_jk
    third = (above - 2 * here[:, None] + below) / STEP**2  # f_jkk
    terms = second**2 / 2 + here[:, None] * third
    diagonal = np.diag(second) ** 2 * (kurtosis + 2) / 4
    diagonal += here * np.diag(third) * (kurtosis + 3) / 3
    np.fill_diagonal(terms, diagonal)
    return float(terms.sum())


def _gradient(model: MeasurementModel, equation: Differentiable, at: Array) -> Array:
    inputs = {input_.name: at[:, row] for row, input_ in enumerate(model.inputs)}
    slopes = equation.gradient(inputs)
    columns = [np.broadcast_to(slopes.get(input_.name, 0.0), len(at)) for input_ in model.inputs]
    return np.array(columns, dtype=float).T


def _independent(model: MeasurementModel) -> tuple[Array, Array]:
    """Return independent directions of unit variance, (m, n), and the excess kurtosis of each."""
    u = np.array([input_.u for input_ in model.inputs])
    r = np.eye(len(u)) if model.correlation is None else model.correlation
    directions: list[Array] = []
    kurtosis: list[float] = []
    for rows in connected(model):
        excess = KURTOSIS.get(model.inputs[rows[0]].distribution, 0.0)
        joint_u = u[rows] if len(rows) == 1 else one_error(model, rows)
        if joint_u is not None:
            parts, flat = joint_u[None, :], excess
        else:
            block = np.ix_(rows, rows)
            variances, vectors = np.linalg.eigh(r[block] * np.outer(u[rows], u[rows]))
            parts, flat = np.sqrt(np.clip(variances, 0, None))[:, None] * vectors.T, 0.0
        for part in parts:
            row = np.zeros(len(u))
            row[rows] = part
            directions.append(row)
            kurtosis.append(flat)
    return np.array(directions).reshape(-1, len(u)), np.array(kurtosis)
