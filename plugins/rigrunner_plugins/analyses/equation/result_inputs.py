"""A result of another analysis as inputs of a model: one for each line of its budget.

Results that have an error in common share its input.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, isclose, isfinite, isnan
from typing import TYPE_CHECKING

from rigrunner.api import Component, Distribution, Input, MeasurementResult, unit
from rigrunner.api.units import si_symbol
from rigrunner_plugins.analyses.equation.tree import Effect

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner_plugins.analyses.equation.inputs import Inputs


def enter_result(
    inputs: Inputs,
    name: str,
    result: MeasurementResult,
    taken: Collection[str],
    place: Mapping[str, CoordinateValue],
) -> None:
    """Add a result by its budget lines; a line that another input also has becomes one input.

    `taken` are the names used in the model itself. A result that holds at all places of the model,
    such as a zero reading, has the same error at all of them, also by its scatter.
    """
    result_unit, estimate = unit(result.of.unit), result.estimate
    inputs.fixed[name] = estimate.value * result_unit.factor + result_unit.offset
    coordinates = result.coordinates
    differs = bool(place) and place.keys() <= coordinates.keys()
    effects: list[Effect] = []
    for line in result.components or _only_line(result):
        if line.u == 0:
            continue
        error = _shareable_error(line, is_here=coordinates.keys() == place.keys())
        error = None if error is None else _share(inputs, error, taken)
        slope, is_at_place = line.sensitivity * result_unit.factor, line.at_place
        # So `Inputs.model` marks the line of several correlated inputs: it has no value of its own.
        is_joint = line.common and line.shared and isnan(line.value) and line.sensitivity == 1
        may_differ = not line.shared or is_joint
        if error is None:
            part = _separate_error(line, result, result_unit.factor, place, differs=differs)
            # It may be there by another result that is made of this one, or by another symbol.
            error = _share(inputs, part, taken) or replace(part, name=f"{part.name}, as {name}")
            if error not in inputs.inputs:
                inputs.inputs.append(error)
            slope, is_at_place, may_differ = 1.0, differs, may_differ and differs
        if is_joint:
            inputs.claim(line.name, result.name)
        inputs.note_unsure(line, error.name)
        if is_at_place:
            inputs.at_place.add(error.name)
        if may_differ:
            inputs.unshared.add(error.name)
        effects.append(Effect(error.name, slope=slope, at=error.value))
    inputs.effects[name] = tuple(effects)


def _shareable_error(line: Component, *, is_here: bool) -> Input | None:
    """Return the error of a line that another result may share; otherwise None.

    `is_here`: the result is one of the very place, so an error of this place is one of it.
    """
    stated = isfinite(line.value) and isfinite(line.input_u) and isfinite(line.sensitivity)
    is_shared = (line.common and line.shared) or (line.at_place and is_here)
    if not (is_shared and stated):
        return None
    return Input(line.name, line.value, line.input_u, line.dof, _shape(line), line.unit,
                 common=line.common)  # fmt: skip


def _share(inputs: Inputs, error: Input, taken: Collection[str]) -> Input | None:
    """Return the input of an error that several results have; None if its name is of another."""
    for candidate in (error, replace(error, name=f"{error.name}, of results")):
        same = next((member for member in inputs.inputs if member.name == candidate.name), None)
        if same is None and candidate.name not in taken:
            inputs.inputs.append(candidate)
            return candidate
        # The degrees of freedom of a line that was propagated are rounded.
        if same and same == replace(candidate, dof=same.dof) and isclose(same.dof, candidate.dof):
            return same
    return None


def _separate_error(
    line: Component,
    result: MeasurementResult,
    factor: float,
    place: Mapping[str, CoordinateValue],
    *,
    differs: bool,
) -> Input:
    """Return a line as an error of this result only, in its SI unit."""
    place_texts = [
        f"{key} = {value}"
        for key, value in result.coordinates.items()
        if not (differs and key in place)
    ]
    at = f" at {', '.join(place_texts)}" if place_texts else ""
    symbol = si_symbol(unit(result.of.unit).dimension)
    name, u = f"{line.name}, of {result.name}{at}", line.u * factor
    return Input(name, 0.0, u, line.dof, _shape(line), symbol, common=line.common or not differs)


def _shape(line: Component) -> Distribution:
    is_known = line.distribution in set(Distribution)
    return Distribution(line.distribution) if is_known else Distribution.NORMAL


def _only_line(result: MeasurementResult) -> tuple[Component, ...]:
    """Return the uncertainty of a result without a budget, as its only line."""
    estimate = result.estimate
    distribution = Distribution.T if estimate.dof < inf else Distribution.NORMAL
    return (Component("uncertainty", estimate.u, estimate.dof, str(distribution), common=False),)
