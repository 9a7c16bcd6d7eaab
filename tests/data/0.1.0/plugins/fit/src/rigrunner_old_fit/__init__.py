"""The fit old_fit: least squares; put your functions into `design`."""

from dataclasses import dataclass

import numpy as np
from rigrunner.api.analysis import Fit
from rigrunner.api.data import Array, Points
from rigrunner.api.errors import DataError
from rigrunner.api.hooks import FitRecord, NoSettings, hookimpl

api_version = 1
FORMULA = "T = c0 + c1 f"


def design(x: Array) -> Array:
    """Return each function at x of shape (n,), one to a column: shape (n, p)."""
    return np.column_stack([np.ones_like(x), x])


@dataclass(frozen=True, eq=False)
class OldFitCurve:
    """What was fitted; satisfies `rigrunner.api.analysis.Curve`."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    coefficients: Array
    covariance: Array
    dof: float
    residuals: Array
    residual_s: float
    r_squared: float
    valid_x: tuple[float, float]
    formula: str = FORMULA

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Return the curve at x (m,) and its standard uncertainty; never extrapolate."""
        low, high = self.valid_x
        outside = x[~((x >= low) & (x <= high))]
        if outside.size:
            raise DataError(f"the fit holds from {low:.6g} to {high:.6g}, not at {outside[0]:.6g}")
        columns = design(x)
        variance = np.einsum("ij,jk,ik->i", columns, self.covariance, columns)
        return columns @ self.coefficients, np.sqrt(variance)


def fit(points: Points) -> OldFitCurve:
    """Return the fitted curve; raise DataError where the points do not allow it."""
    columns, y = design(points.x), points.y
    n, p = columns.shape
    if n <= p:
        raise DataError(f"{n} points cannot give {p} coefficients with their uncertainty")
    if not (np.isfinite(columns).all() and np.isfinite(y).all()):
        raise DataError("a point of the fit is not a finite number")
    if np.linalg.matrix_rank(columns) < p:
        raise DataError("the points do not determine all coefficients of the fit")
    q, r = np.linalg.qr(columns)
    inverse = np.linalg.inv(r)
    coefficients = inverse @ (q.T @ y)
    residuals = y - columns @ coefficients
    rss = float(residuals @ residuals)
    total = float(np.sum((y - y.mean()) ** 2))
    covariance = inverse @ inverse.T * (rss / (n - p))
    return OldFitCurve(
        names=("c0", "c1"),
        units=(points.y_unit, f"{points.y_unit}/{points.x_unit}"),
        coefficients=coefficients,
        covariance=(covariance + covariance.T) / 2,
        dof=n - p,
        residuals=residuals,
        residual_s=float(np.sqrt(rss / (n - p))),
        r_squared=1 - rss / total if total else float("nan"),
        valid_x=(float(points.x.min()), float(points.x.max())),
    )


def _make(_: NoSettings) -> Fit:
    return fit


@hookimpl
def rigrunner_fits() -> list[FitRecord]:
    """Tell Rigrunner what is in this file."""
    return [
        FitRecord(
            name="old_fit",
            help=f"Old fit: {FORMULA}",
            factory=_make,
        )
    ]
