"""The deviation of a transducer over its range, from the points of its certificate.

Tables have ascending indicated values, each with indicated minus applied, in the SI unit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

Table = tuple[tuple[float, float], ...]

DEGREE = 3
"""Maximum degree of the interpolation equation (ISO 376; DIN 51309), which has no constant term."""
STEPS = 200
"""Number of straight lines that represent a cubic with negligible error."""


def linear(deviations: Mapping[float, float], *, through_zero: bool) -> Table:
    """Return the points, with zero if the curve goes through it."""
    return tuple(sorted(({0.0: 0.0, **deviations} if through_zero else deviations).items()))


def cubic(deviations: Mapping[float, float]) -> Table:
    """Return the cubic through zero of each direction, fitted by least squares."""
    curve = {0.0: 0.0}
    for points in _directions(deviations):
        end, coefficients = _fit(points)
        shares = (step / STEPS for step in range(1, STEPS + 1))
        curve |= {share * end: _at(share, coefficients) for share in shares}
    return tuple(sorted(curve.items()))


def off_linear(table: Table) -> float:
    """Return the greatest distance of a point from the line between its neighbours."""
    off = (
        abs(here[1] - low[1] - (high[1] - low[1]) * (here[0] - low[0]) / (high[0] - low[0]))
        for low, here, high in zip(table, table[1:], table[2:], strict=False)
    )
    return max(off, default=0.0)


def off_cubic(deviations: Mapping[float, float]) -> float:
    """Return the greatest distance of a point from the cubic of its direction."""
    residuals = []
    for points in _directions(deviations):
        end, coefficients = _fit(points)
        residuals += [abs(y - _at(x / end, coefficients)) for x, y in points]
    return max(residuals)


def too_few_for_cubic(deviations: Mapping[float, float]) -> int | None:
    """Return the number of points of a direction that are too few for a cubic; None for none."""
    counts = [len(points) for points in _directions(deviations)]
    return next((count for count in counts if count <= DEGREE), None)


def _directions(deviations: Mapping[float, float]) -> Sequence[Sequence[tuple[float, float]]]:
    positive = [(x, y) for x, y in deviations.items() if x > 0]
    negative = [(x, y) for x, y in deviations.items() if x < 0]
    return [points for points in (negative, positive) if points]


def _fit(points: Sequence[tuple[float, float]]) -> tuple[float, Sequence[float]]:
    """Return the farthest indicated value, and the coefficients for x relative to it."""
    import numpy as np  # noqa: PLC0415  (a register is read without it)

    end = max((x for x, _ in points), key=abs)
    share = np.array([x / end for x, _ in points])
    powers = np.stack([share**k for k in range(1, DEGREE + 1)], axis=1)
    coefficients, *_ = np.linalg.lstsq(powers, np.array([y for _, y in points]))
    return end, [float(coefficient) for coefficient in coefficients]


def _at(share: float, coefficients: Sequence[float]) -> float:
    return sum(c * share**k for k, c in enumerate(coefficients, 1))
