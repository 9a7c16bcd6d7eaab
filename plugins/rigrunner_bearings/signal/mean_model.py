"""The measurement model of a mean over set-points, in which common inputs occur once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isnan, nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Distribution, Effect, Input, MeasurementModel
from rigrunner.api.uncertainty import Corrected
from rigrunner.signal.inputs import extended
from rigrunner.signal.propagation import propagate

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api import Array, Component
    from rigrunner_bearings.api.compensations import CompensatedPoint


def mean_model(points: Sequence[CompensatedPoint]) -> MeasurementModel:
    """Return the model of the mean torque of one or more points; ValueError as `mean_of_models`."""
    return mean_of_models([model_of_point(point) for point in points])


def mean_of_models(models: Sequence[MeasurementModel]) -> MeasurementModel:
    """Return the model of the mean of one or more measurands.

    A common input is one and the same in all points, so that its errors add up with their signs;
    the others are distinguished by the point and average out. Raises ValueError if a common input
    is not the same in two points.
    """
    # The name of each input of a point among the inputs of all points.
    names = [
        {
            input_.name: input_.name if input_.common else f"{input_.name}, point {place}"
            for input_ in model.inputs
        }
        for place, model in enumerate(models, 1)
    ]
    inputs: dict[str, Input] = {}
    for model, renamed in zip(models, names, strict=True):
        for input_ in model.inputs:
            name = renamed[input_.name]
            # An ensemble of one point stays an ensemble of that point.
            ensemble = input_.ensemble + name.removeprefix(input_.name) if input_.ensemble else ""
            renamed_input = replace(input_, name=name, line=input_.budget_line, ensemble=ensemble)
            if not _same(inputs.setdefault(name, renamed_input), renamed_input):
                raise ValueError(f"{name} is common to all points, but not the same in two of them")
    return MeasurementModel(
        inputs=tuple(inputs.values()),
        equation=_Mean(tuple(zip(models, names, strict=True))),
        correlation=_correlation(list(inputs), models, names),
    )


@dataclass(frozen=True)
class _Mean:
    parts: tuple[tuple[MeasurementModel, Mapping[str, str]], ...]

    def __call__(self, inputs: Mapping[str, Array]) -> Array:
        total = sum(
            model.equation({original: inputs[name] for original, name in names.items()})
            for model, names in self.parts
        )
        return np.asarray(total / len(self.parts))


def _same(one: Input, other: Input) -> bool:
    is_same_estimate = (one.value, one.distribution) == (other.value, other.distribution)
    return is_same_estimate and (one.u == other.u or (isnan(one.u) and isnan(other.u)))


def _correlation(
    order: Sequence[str], models: Sequence[MeasurementModel], names: Sequence[Mapping[str, str]]
) -> Array | None:
    if all(model.correlation is None for model in models):
        return None
    place = {name: i for i, name in enumerate(order)}
    correlation = np.eye(len(order))
    for model, renamed in zip(models, names, strict=True):
        if model.correlation is not None:
            rows = [place[renamed[input_.name]] for input_ in model.inputs]
            correlation[np.ix_(rows, rows)] = model.correlation
    return correlation


def model_of_point(point: CompensatedPoint) -> MeasurementModel:
    """Return the model of a point; where it has components only, each adds to the torque."""
    if point.model is not None:
        return point.model
    effects = tuple(_effect(part) for part in point.components)
    return MeasurementModel(
        inputs=tuple(effect.input for effect in effects),
        equation=Corrected(point.torque.value, effects),
    )


def with_effects(point: CompensatedPoint, effects: Sequence[Effect]) -> CompensatedPoint:
    """Return the point with further effects in its model, its uncertainty and its budget."""
    model = extended(model_of_point(point), effects)
    propagated = propagate(model)
    return replace(point, torque=propagated.estimate, components=propagated.components, model=model)


def _effect(part: Component) -> Effect:
    """Return a component as an input of uncertainty 1, so that a common one is the same everywhere.

    Its sign is not known: that of a common one is taken to be the same in all points.
    """
    name = part.distribution
    distribution = Distribution(name) if name in set(Distribution) else Distribution.NORMAL
    u = nan if isnan(part.u) else 1.0
    return Effect(Input(part.name, 0.0, u, part.dof, distribution, "1", part.common), part.u)
