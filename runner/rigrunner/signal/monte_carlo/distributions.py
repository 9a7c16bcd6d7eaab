"""Distributions of input quantities (JCGM 101:2008, 6.4), each drawn by a Generator.

Univariate ones draw arrays of shape (n,), multivariate ones of shape (n, k).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf, isinf, sqrt
from typing import TYPE_CHECKING, Protocol

import numpy as np

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.random import Generator

    from rigrunner.api.data import Array


class Distribution(Protocol):
    """What an input quantity may be."""

    def draw(self, rng: Generator, n: int) -> Array:
        """Return n values of shape (n,), or n rows of shape (n, k)."""
        ...


@dataclass(frozen=True)
class Normal:
    """Gaussian (6.4.7)."""

    mean: float
    u: float

    def draw(self, rng: Generator, n: int) -> Array:
        """Return values of shape (n,)."""
        return rng.normal(self.mean, self.u, n)


@dataclass(frozen=True)
class ScaledT:
    """Scaled and shifted t (6.4.9): a mean of few readings; its deviation exceeds the scale."""

    mean: float
    scale: float
    dof: float

    def draw(self, rng: Generator, n: int) -> Array:
        """Return values of shape (n,)."""
        return self.mean + self.scale * rng.standard_t(self.dof, n)


@dataclass(frozen=True)
class Rectangular:
    """Within centre +/- half_width, all alike (6.4.2)."""

    centre: float
    half_width: float

    def draw(self, rng: Generator, n: int) -> Array:
        """Return values of shape (n,)."""
        return self.centre + self.half_width * rng.uniform(-1, 1, n)


@dataclass(frozen=True)
class CurvilinearTrapezoid:
    """Rectangular, of a half width that is itself known to +/- doubt (6.4.3)."""

    centre: float
    half_width: float
    doubt: float

    def draw(self, rng: Generator, n: int) -> Array:
        """Return values of shape (n,)."""
        half_width = self.half_width + self.doubt * rng.uniform(-1, 1, n)
        return np.asarray(self.centre + half_width * rng.uniform(-1, 1, n))


@dataclass(frozen=True)
class Triangular:
    """Within centre +/- half_width, most likely in the middle (6.4.5)."""

    centre: float
    half_width: float

    def draw(self, rng: Generator, n: int) -> Array:
        """Return values of shape (n,)."""
        # Two equal rectangles add to a triangle.
        mean_of_two = rng.uniform(-1, 1, (2, n)).mean(axis=0)
        return np.asarray(self.centre + self.half_width * mean_of_two)


@dataclass(frozen=True)
class Arcsine:
    """U-shaped within centre +/- half_width: a sine at an unknown phase (6.4.6)."""

    centre: float
    half_width: float

    def draw(self, rng: Generator, n: int) -> Array:
        """Return values of shape (n,)."""
        return np.asarray(self.centre + self.half_width * np.sin(rng.uniform(0, 2 * np.pi, n)))


@dataclass(frozen=True, eq=False)
class OneError:
    """Inputs of mean (k,) that one error moves, each by its own u with sign (k,)."""

    mean: Array
    u: Array
    error: Distribution
    """Of mean 0 and standard deviation 1."""

    def draw(self, rng: Generator, n: int) -> Array:
        """Return rows of shape (n, k)."""
        return np.asarray(self.mean + self.error.draw(rng, n)[:, None] * self.u)


@dataclass(frozen=True, eq=False)
class MultivariateNormal:
    """Gaussian of mean (k,) and covariance (k, k) (6.4.8); degenerate ones too."""

    mean: Array
    covariance: Array

    def draw(self, rng: Generator, n: int) -> Array:
        """Return rows of shape (n, k)."""
        rows = _draw_correlated(rng, n, self._factor)
        rows += self.mean
        return rows

    @cached_property
    def _factor(self) -> Array:
        return _factor_of(self.covariance)


@dataclass(frozen=True, eq=False)
class MultivariateT:
    """t of location (k,), scale matrix (k, k) and degrees of freedom: the parameters of a fit.

    Its covariance is dof/(dof - 2) times the scale matrix (JCGM 102:2011, 5.3.2).
    """

    mean: Array
    scale: Array
    dof: float

    def draw(self, rng: Generator, n: int) -> Array:
        """Return rows of shape (n, k): all parameters share the unknown residual deviation."""
        wider = np.sqrt(self.dof / rng.chisquare(self.dof, n))
        return np.asarray(self.mean + wider[:, None] * _draw_correlated(rng, n, self._factor))

    @cached_property
    def _factor(self) -> Array:
        return _factor_of(self.scale)


def _draw_correlated(rng: Generator, n: int, factor: Array) -> Array:
    """Return rows of shape (n, k), of mean 0; each column in one piece, for what comes after."""
    return np.asarray((factor @ rng.standard_normal((n, len(factor))).T).T)


def _factor_of(covariance: Array) -> Array:
    """Return a factor F, F F' = covariance, (k, k).

    By eigenvalues, as full correlation leaves no Cholesky factor.
    """
    values, vectors = np.linalg.eigh(covariance)
    # Of full correlation the eigenvalues that should be 0 come out a little below it.
    if values.min() < -1e-9 * max(values.max(), 0.0):
        raise DataError(
            "the correlations between the inputs contradict each other",
            hint="a correlation matrix has no negative eigenvalue",
        )
    return np.asarray(vectors * np.sqrt(np.clip(values, 0.0, None)))


def _gaussian(value: float, u: float, dof: float) -> Distribution:
    return Normal(value, u) if isinf(dof) else ScaledT(value, u, dof)


def _bounded(value: float, u: float, dof: float) -> Distribution:
    """Return a rectangle; finite degrees of freedom say how well its width is known (GUM G.4.2)."""
    half_width = sqrt(3) * u
    if isinf(dof):
        return Rectangular(value, half_width)
    return CurvilinearTrapezoid(value, half_width, half_width / sqrt(2 * dof))


NAMED: Mapping[str, Callable[[float, float, float], Distribution]] = {
    "normal": _gaussian,
    "t": _gaussian,
    "rectangular": _bounded,
    "triangular": lambda value, u, _: Triangular(value, sqrt(6) * u),
    "arcsine": lambda value, u, _: Arcsine(value, sqrt(2) * u),
}
"""By their names in a budget."""


def named(name: str, value: float, u: float, dof: float = inf) -> Distribution:
    """Return the distribution that a budget means by its name; raise DataError for another.

    `u` is the standard uncertainty of the budget; of a type A evaluation it is the scale of a t
    (JCGM 101, 6.4.9.2).
    """
    if name not in NAMED:
        raise DataError(
            f"no distribution is called {name!r}", hint=f"known: {', '.join(sorted(NAMED))}"
        )
    return NAMED[name](value, u, dof)
