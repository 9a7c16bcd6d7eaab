"""Linear least squares that keeps its digits: orthogonalisation in extended precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rigrunner.api import DataError

if TYPE_CHECKING:
    from rigrunner.api import Array

Extended = NDArray[np.longdouble]
"""Of 64 bits or more on Linux; where the platform's long double is a double, digits are fewer."""

RANK_TOLERANCE = 1e-12
"""Of a column's length: what is left of it beside the columns before it, or it depends on these."""


@dataclass(frozen=True, eq=False)
class Solution:
    """The least-squares solution of `design @ coefficients = y`, in extended precision.

    `coefficients` (p,) and `residuals` (n,); `factor` (p, p) with factor @ factor.T = inverse of
    design.T @ design.
    """

    coefficients: Extended
    residuals: Extended
    factor: Extended

    @property
    def dof(self) -> int:
        """Degrees of freedom of the residual, n - p."""
        return len(self.residuals) - len(self.coefficients)

    @property
    def residual_s(self) -> float:
        """The residual standard deviation, in the unit of y."""
        return float(np.sqrt(np.sum(self.residuals**2) / self.dof))


def solve(design: Extended | Array, y: Extended | Array) -> Solution:
    """Minimise |y - design @ c| for a design of shape (n, p) and y of shape (n,).

    Modified Gram-Schmidt on the column-scaled design with y beside it, which is as stable as
    Householder's QR (Björck, BIT 7, 1967). The rounding error of the scaled coefficients is about
    k eps of their size or, if larger, of their standard uncertainty; k is the condition number of
    the scaled design, eps the extended precision. Raises DataError where n <= p, where a value is
    not finite, or where the columns are dependent.
    """
    n, p = design.shape
    if n <= p:
        raise DataError(f"{n} points cannot give {p} coefficients with their uncertainty")
    if not (np.isfinite(design).all() and np.isfinite(y).all()):
        raise DataError("a point of the fit is not a finite number")
    columns, values = design.astype(np.longdouble), y.astype(np.longdouble)
    scale = np.sqrt(np.sum(columns**2, axis=0))
    scale[scale == 0] = 1
    r, projection = _orthogonalised(columns / scale, values)
    inverse = _back_substituted(r, np.eye(len(r), dtype=np.longdouble))
    coefficients = _back_substituted(r, projection[:, None])[:, 0] / scale
    return Solution(coefficients, values - columns @ coefficients, inverse / scale[:, None])


def _orthogonalised(design: Extended, y: Extended) -> tuple[Extended, Extended]:
    """Return R (p, p) of design = Q R, and Q.T @ y (p,); columns of design have unit length."""
    p = design.shape[1]
    q = np.column_stack([design, y])
    r = np.zeros((p, p + 1), np.longdouble)
    for k in range(p):
        r[k, k] = np.sqrt(np.sum(q[:, k] ** 2))
        if r[k, k] <= RANK_TOLERANCE:
            raise DataError(
                "the points do not determine all coefficients of the fit",
                hint="use more different values of x, or a simpler fit",
            )
        q[:, k] /= r[k, k]
        r[k, k + 1 :] = q[:, k] @ q[:, k + 1 :]
        q[:, k + 1 :] -= np.outer(q[:, k], r[k, k + 1 :])
    return r[:, :p], r[:, p]


def _back_substituted(r: Extended, right: Extended) -> Extended:
    """Return the solution (p, m) of R @ solution = right, for an upper triangle R (p, p)."""
    solution = np.zeros_like(right)
    for k in reversed(range(len(r))):
        solution[k] = (right[k] - r[k, k + 1 :] @ solution[k + 1 :]) / r[k, k]
    return solution
