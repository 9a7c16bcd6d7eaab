"""The uncertainty budgets in `result.json`: a line for each input (GUM 8, EA-4/02 M:2022)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.signal.as_json.values import degrees_of_freedom, number, quantity
from rigrunner.signal.uncertainty import share_percent

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.analysis import Component
    from rigrunner.signal.as_json.values import Json


def budget(components: Sequence[Component], unit: str) -> list[Json]:
    """Return the lines of a budget in a unit, each with its share of the variance."""
    shares = share_percent(components)
    return [
        {
            "name": component.name,
            "estimate": quantity(component.value, component.unit),
            "distribution": component.distribution,
            "standard_uncertainty": quantity(component.input_u, component.unit),
            "degrees_of_freedom": degrees_of_freedom(component.dof),
            "sensitivity": quantity(component.sensitivity, _per(component.unit, unit)),
            "contribution": quantity(component.u, unit),
            "share": quantity(share, "%"),
            "known": number(component.u) is not None,
            "common_to_all_points": bool(component.common),
        }
        for component, share in zip(components, shares, strict=True)
    ]


def _per(unit: str, result: str) -> str:
    """Return the unit of a sensitivity of the result, in its unit, to an input in that unit."""
    if unit == result:
        return "1"
    if unit == "1":
        return result
    return f"{result}/({unit})" if {"·", "/"} & set(unit) else f"{result}/{unit}"
