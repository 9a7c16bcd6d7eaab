"""Linear least squares that keeps its digits: QR with refinement in extended precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from rigrunner.api.data import Array

Extended = NDArray[np.longdouble]

REFINEMENTS = 10
RANK_TOLERANCE = 1e-12
"""Of the largest: a smaller pivot of the scaled design means that its columns are dependent."""


@dataclass(frozen=True, eq=False)
class Solution:
    """The least-squares solution of `design @ coefficients = y`.

    `coefficients` (p,) and `residuals` (n,) in extended precision; `factor` (p, p) with
    factor @ factor.T = inverse of design.T @ design.
    """

    coefficients: Extended
    residuals: Extended
    factor: Array

    @property
    def dof(self) -> int:
        """Degrees of freedom of the residual, n - p."""
        return len(self.residuals) - len(self.coefficients)

    @property
    def residual_s(self) -> float:
        """The residual standard deviation, in the unit of y."""
        return float(np.sqrt(np.sum(self.residuals**2) / self.dof))


def solve(design: Extended, y: Extended) -> Solution:
    """Minimise |y - design @ c| for a design of shape (n, p) and y of shape (n,).

    Householder QR of the column-scaled design; the solution and its residual are refined together
    through the augmented system (Björck, BIT 7, 1967). Raises DataError where n <= p, where a value
    is not finite, or where the columns are dependent.
    """
    _check(design, y)
    scale = np.sqrt(np.sum(design**2, axis=0))
    scale[scale == 0] = 1
    scaled = design / scale
    q, r = np.linalg.qr(scaled.astype(np.float64))
    pivots = np.abs(np.diag(r))
    if pivots.min() <= RANK_TOLERANCE * pivots.max():
        raise DataError(
            "the points do not determine all coefficients of the fit",
            hint="use more different values of x, or a simpler fit",
        )
    coefficients, residuals = _refined(scaled, y, q, r)
    factor = np.linalg.inv(r) / scale.astype(np.float64)[:, None]
    return Solution(coefficients / scale, residuals, factor)


def _check(design: Extended, y: Extended) -> None:
    n, p = design.shape
    if n <= p:
        raise DataError(f"{n} points cannot give {p} coefficients with their uncertainty")
    if not (np.isfinite(design).all() and np.isfinite(y).all()):
        raise DataError("a point of the fit is not a finite number")


def _refined(design: Extended, y: Extended, q: Array, r: Array) -> tuple[Extended, Extended]:
    """Solve residual + design @ c = y, design.T @ residual = 0 by iterative refinement."""
    coefficients = np.zeros(design.shape[1], np.longdouble)
    residuals = np.zeros(len(y), np.longdouble)
    for _ in range(REFINEMENTS):
        misfit = (y - residuals - design @ coefficients).astype(np.float64)
        slope = (-(design.T @ residuals)).astype(np.float64)
        along = np.linalg.solve(r.T, slope)
        projected = q.T @ misfit
        residuals = residuals + (misfit + q @ (along - projected))
        coefficients = coefficients + np.linalg.solve(r, projected - along)
    return coefficients, residuals
