"""Powers of x as the columns of a design, scaled so that they do not overflow or nearly depend."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api import Array, Points
    from rigrunner_plugins.fits.least_squares import Extended

_SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


class Powers(Protocol):
    """Functions of x that span the same curves as some powers of x."""

    @property
    def powers(self) -> tuple[int, ...]:
        """Which powers, ascending."""
        ...

    def columns(self, x: Array) -> Extended:
        """Return the functions at x (n,), shape (n, p)."""
        ...

    def to_plain(self) -> Extended:
        """Return the (p, p) matrix that turns their coefficients into those of the powers of x."""
        ...


@dataclass(frozen=True)
class ScaledPowers:
    """Chosen powers of x/scale."""

    powers: tuple[int, ...]
    scale: float

    def columns(self, x: Array) -> Extended:
        """Return the powers at x (n,), shape (n, p)."""
        scaled = x.astype(np.longdouble) / self.scale
        return np.asarray(scaled[:, None] ** np.array(self.powers))

    def to_plain(self) -> Extended:
        """Return the (p, p) matrix that turns coefficients into those of the powers of x."""
        return np.diag(np.longdouble(self.scale) ** -np.array(self.powers))


@dataclass(frozen=True)
class MappedPowers:
    """All powers up to a degree of x mapped from [low, high] onto [-1, 1]: far from dependent."""

    degree: int
    low: float
    high: float

    @property
    def powers(self) -> tuple[int, ...]:
        """Return 0 to the degree."""
        return tuple(range(self.degree + 1))

    def columns(self, x: Array) -> Extended:
        """Return the powers of the mapped x (n,), shape (n, degree + 1)."""
        mapped = (2 * x.astype(np.longdouble) - self.low - self.high) / self._width
        return np.asarray(mapped[:, None] ** np.arange(self.degree + 1))

    def to_plain(self) -> Extended:
        """Return the matrix that turns coefficients on the mapped x into those on x itself.

        Binomial theorem: t = a x + b gives t^k = sum_j C(k, j) a^j b^(k-j) x^j.
        """
        a = 2 / self._width
        b = -(np.longdouble(self.low) + self.high) / self._width
        matrix = np.zeros((self.degree + 1, self.degree + 1), np.longdouble)
        for k in range(self.degree + 1):
            for j in range(k + 1):
                matrix[j, k] = comb(k, j) * a**j * b ** (k - j)
        return matrix

    @property
    def _width(self) -> np.longdouble:
        return np.longdouble(self.high) - self.low


def formula(powers: tuple[int, ...], points: Points) -> str:
    """Return the curve as a person writes it, with the names of the points: 'T = c0 + c2·f²'."""
    terms = (f"c{k}·{points.x_name}{_superscript(k)}" if k else "c0" for k in powers)
    return f"{points.y_name} = {' + '.join(terms)}"


def unit(y_unit: str, x_unit: str, power: int) -> str:
    """Return the unit of the coefficient of a power of x: 'N·m/Hz²'; of numbers alone none."""
    return f"{y_unit}/{x_unit}{_superscript(power)}" if power and x_unit else y_unit


def _superscript(power: int) -> str:
    return "" if power == 1 else str(power).translate(_SUPERSCRIPTS)
