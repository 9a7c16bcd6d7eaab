"""The contract of fits, and of the curves that they return."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.data import Array, Points


class Curve(Protocol):
    """A fitted curve."""

    @property
    def formula(self) -> str:
        """The curve as a formula, with the names of its parameters."""
        ...

    @property
    def names(self) -> Sequence[str]:
        """The names of the coefficients."""
        ...

    @property
    def units(self) -> Sequence[str]:
        """The unit of each coefficient."""
        ...

    @property
    def coefficients(self) -> Array:
        """The estimates, shape (p,)."""
        ...

    @property
    def covariance(self) -> Array:
        """Their covariance, shape (p, p)."""
        ...

    @property
    def dof(self) -> float:
        """Degrees of freedom of the residual."""
        ...

    @property
    def residuals(self) -> Array:
        """Observed minus fitted, shape (n,)."""
        ...

    @property
    def residual_s(self) -> float:
        """The residual standard deviation, in the unit of y."""
        ...

    @property
    def r_squared(self) -> float:
        """The coefficient of determination."""
        ...

    @property
    def valid_x(self) -> tuple[float, float]:
        """The range of x within which the curve may be used."""
        ...

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Return the curve at x and its standard uncertainty (of the curve, not of one more point).

        Raises DataError outside `valid_x`.
        """
        ...


@runtime_checkable
class Spreading(Protocol):
    """An optional ability of a Curve: its uncertainty in independent directions."""

    def spread(self, x: Array) -> Array:
        """Return the curve's gradient times a square root of the covariance at x (m,).

        Shape (m, p). The norm of a row is the standard uncertainty there, the product of two rows
        the covariance of the curve at two places. Raises DataError outside `valid_x`.
        """
        ...


@runtime_checkable
class Extrapolating(Protocol):
    """An optional ability of a Curve: values outside `valid_x`."""

    def extrapolate(self, x: Array) -> tuple[Array, Array]:
        """Return the curve and its standard uncertainty as `predict`, at any x.

        The uncertainty is that of the coefficients; whether the curve is valid there is unknown.
        """
        ...


@runtime_checkable
class Weighted(Protocol):
    """An optional ability of a Curve: the weights of its points."""

    @property
    def root_weights(self) -> Array:
        """Square roots of weights of mean 1, shape (n,); `residual_s` is that of weight 1."""
        ...


@dataclass(frozen=True)
class Candidate:
    """A candidate of a fit that chooses a curve."""

    formula: str
    parameters: int
    """Number of coefficients."""
    score: float
    """Value of the criterion, lower is better; nan if the curve could not be fitted."""
    residual_s: float
    """The residual standard deviation, in the unit of y; nan if there is none."""
    chosen: bool = False
    problem: str = ""
    """Why the curve could not be fitted."""


@runtime_checkable
class Chosen(Protocol):
    """An optional ability of a Curve: the candidates that it was chosen from."""

    @property
    def criterion(self) -> str:
        """The criterion of the comparison, such as 'AICc'."""
        ...

    @property
    def candidates(self) -> Sequence[Candidate]:
        """All candidates in the order of the procedure, including the chosen one."""
        ...


class Fit(Protocol):
    """Fits a curve to points."""

    def __call__(self, points: Points) -> Curve:
        """Return the fitted curve; raise DataError where the points do not allow it."""
        ...
