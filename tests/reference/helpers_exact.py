"""Least squares in rational numbers: exact, without rounding."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import sqrt


@dataclass(frozen=True)
class ExactSolution:
    coefficients: list[Fraction]
    normal: list[list[Fraction]]
    inverse: list[list[Fraction]]
    """Of the normal matrix."""
    rss: Fraction

    @property
    def condition(self) -> float:
        """Of the design with columns of unit length, in the Frobenius norm."""
        p = len(self.coefficients)
        return sqrt(p * float(sum(self.normal[i][i] * self.inverse[i][i] for i in range(p))))


def exact_least_squares(design, y) -> ExactSolution:
    """Solve the normal equations; raises ZeroDivisionError if the columns are dependent."""
    rows = [[Fraction(value) for value in row] for row in design]
    values = [Fraction(value) for value in y]
    p = len(rows[0])
    normal = [[sum(row[i] * row[j] for row in rows) for j in range(p)] for i in range(p)]
    right = [sum(row[i] * value for row, value in zip(rows, values, strict=True)) for i in range(p)]
    inverse = inverted(normal)
    coefficients = [dot(row, right) for row in inverse]
    residuals = [value - dot(row, coefficients) for row, value in zip(rows, values, strict=True)]
    return ExactSolution(coefficients, normal, inverse, dot(residuals, residuals))


def inverted(matrix):
    """Return the inverse of a symmetric positive definite matrix, by Gauss and Jordan."""
    n = len(matrix)
    rows = [[*row, *(Fraction(int(i == j)) for j in range(n))] for i, row in enumerate(matrix)]
    for i in range(n):
        pivot = rows[i][i]
        rows[i] = [value / pivot for value in rows[i]]
        for k in range(n):
            if k != i:
                factor = rows[k][i]
                rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i], strict=True)]
    return [row[n:] for row in rows]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))
