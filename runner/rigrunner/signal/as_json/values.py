"""Values as JSON has them: numbers with their unit, null for what is unknown."""

from __future__ import annotations

from math import isfinite, isinf
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.coverage import factor

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.data import Estimate

Json = dict[str, object]


def estimate(value: Estimate | None) -> Json | None:
    """Return a value with its standard and 95 % expanded uncertainty; None stays None."""
    if value is None:
        return None
    k = factor(value)
    return {
        "value": number(value.value),
        "standard_uncertainty": number(value.u),
        "degrees_of_freedom": degrees_of_freedom(value.dof),
        "coverage_factor_95": number(k),
        "expanded_uncertainty_95": number(k * value.u),
        "unit": value.unit,
    }


def quantity(value: float, unit: str) -> Json:
    """Return a number with its unit."""
    return {"value": number(value), "unit": unit}


def number(value: float) -> float | None:
    """Return a float that JSON can hold; None for what is not a finite number."""
    return float(value) if isfinite(value) else None


def degrees_of_freedom(dof: float) -> float | str | None:
    """Return the degrees of freedom, or the text 'infinite'."""
    return "infinite" if isinf(dof) else number(dof)


def plain(value: object) -> object:
    """Return nested mappings, sequences, arrays and numbers of numpy as JSON values."""
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return number(value) if isinstance(value, float) else value


def coordinates_of(coordinates: Mapping[str, CoordinateValue]) -> Json:
    """Return where a result holds: a text as it is, a number with its unit."""
    return {
        name: each.value if isinstance(each.value, str) else quantity(each.value, each.unit)
        for name, each in coordinates.items()
    }
