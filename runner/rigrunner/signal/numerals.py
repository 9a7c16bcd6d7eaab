"""Numbers as they are printed: decimals that the uncertainty bears, a point, no grouping.

A printed form may put another decimal sign in its place, but changes no digit.
"""

from __future__ import annotations

from math import isfinite, isinf
from typing import TYPE_CHECKING

from rigrunner.api.certificate import StatedResult
from rigrunner.api.errors import DataError
from rigrunner.api.verdict import CERTAIN
from rigrunner.signal import coverage
from rigrunner.signal.rounding import places, printed

if TYPE_CHECKING:
    from rigrunner.api.data import Estimate

FACTOR_DECIMALS = 2
_PERCENT_DECIMALS = 2


def finite(value: float | None) -> float | None:
    """Return a number, or None where there is none that JSON knows."""
    return value if value is not None and isfinite(value) else None


def percent(probability: float) -> str:
    """Return a probability in per cent; never '100' or '0' of what is not certain."""
    if probability > CERTAIN:
        return f"> {printed(100 * CERTAIN, _PERCENT_DECIMALS)}"
    if probability < 1 - CERTAIN:
        return f"< {printed(100 * (1 - CERTAIN), _PERCENT_DECIMALS)}"
    return printed(100 * probability, _PERCENT_DECIMALS)


def stated(estimate: Estimate, what: str) -> StatedResult:
    """Return an estimate as it is printed; raise DataError without a finite uncertainty."""
    if not (isfinite(estimate.value) and isfinite(estimate.u) and estimate.u > 0):
        raise DataError(
            f"{what} has no uncertainty, and cannot be on a certificate",
            hint="a value without its uncertainty cannot be compared with a limit",
        )
    factor = coverage.factor(estimate)
    width = factor * estimate.u
    decimals = places(width)
    return StatedResult(
        value=float(estimate.value),
        standard_uncertainty=float(estimate.u),
        degrees_of_freedom=None if isinf(estimate.dof) else float(estimate.dof),
        coverage_factor=factor,
        expanded_uncertainty=width,
        unit=estimate.unit,
        decimals=decimals,
        printed=printed(estimate.value, decimals),
        printed_uncertainty=printed(width, decimals),
        printed_factor=printed(factor, FACTOR_DECIMALS),
    )
