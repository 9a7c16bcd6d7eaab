"""The uncertainty budgets in `result.json`: a line for each input (GUM 8, EA-4/02 M:2022)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.analysis.document_values import degrees_of_freedom, number, quantity
from rigrunner.signal.uncertainty import share_percent

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.analysis.document_values import Json
    from rigrunner.api.analysis import Component

TORQUE = "N·m"


def budget(components: Sequence[Component]) -> list[Json]:
    """Return the lines of a budget, each with its share of the variance."""
    shares = share_percent(components)
    return [_line(each, share) for each, share in zip(components, shares, strict=True)]


def _line(component: Component, share: float) -> Json:
    return {
        "name": component.name,
        "estimate": quantity(component.value, component.unit),
        "distribution": component.distribution,
        "standard_uncertainty": quantity(component.input_u, component.unit),
        "degrees_of_freedom": degrees_of_freedom(component.dof),
        "sensitivity": quantity(component.sensitivity, _per(component.unit)),
        "contribution": quantity(component.u, TORQUE),
        "share": quantity(share, "%"),
        "known": number(component.u) is not None,
        "common_to_all_points": component.common,
    }


def _per(unit: str) -> str:
    """Return the unit of a sensitivity of the torque to an input in that unit."""
    if unit == TORQUE:
        return "1"
    if unit == "1":
        return TORQUE
    return f"{TORQUE}/({unit})" if {"·", "/"} & set(unit) else f"{TORQUE}/{unit}"
