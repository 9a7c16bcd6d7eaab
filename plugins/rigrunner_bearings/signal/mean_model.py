"""The measurement model of a mean over set-points: what they have in common enters once."""

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
    # What each input of a point is called among those of all points.
    names = [
        {
            each.name: each.name if each.common else f"{each.name}, point {place}"
            for each in model.inputs
        }
        for place, model in enumerate(models, 1)
    ]
    inputs: dict[str, Input] = {}
    for model, renamed in zip(models, names, strict=True):
        for own in model.inputs:
            name = renamed[own.name]
            # An ensemble of a point's own stays its own.
            ensemble = own.ensemble + name.removeprefix(own.name) if own.ensemble else ""
            new = replace(own, name=name, line=own.budget_line, ensemble=ensemble)
            if not _same(inputs.setdefault(name, new), new):
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
            model.equation({own: inputs[name] for own, name in names.items()})
            for model, names in self.parts
        )
        return np.asarray(total / len(self.parts))


def _same(one: Input, other: Input) -> bool:
    known = (one.value, one.distribution) == (other.value, other.distribution)
    return known and (one.u == other.u or (isnan(one.u) and isnan(other.u)))


def _correlation(
    order: Sequence[str], models: Sequence[MeasurementModel], names: Sequence[Mapping[str, str]]
) -> Array | None:
    if all(model.correlation is None for model in models):
        return None
    place = {name: i for i, name in enumerate(order)}
    whole = np.eye(len(order))
    for model, renamed in zip(models, names, strict=True):
        if model.correlation is not None:
            rows = [place[renamed[each.name]] for each in model.inputs]
            whole[np.ix_(rows, rows)] = model.correlation
    return whole


def model_of_point(point: CompensatedPoint) -> MeasurementModel:
    """Return the model of a point; where it has components only, each adds to the torque."""
    if point.model is not None:
        return point.model
    effects = tuple(_effect(part) for part in point.components)
    return MeasurementModel(
        inputs=tuple(each.input for each in effects),
        equation=Corrected(point.torque.value, effects),
    )


def with_effects(point: CompensatedPoint, effects: Sequence[Effect]) -> CompensatedPoint:
    """Return the point with more in its model, and so in its uncertainty and its budget."""
    model = extended(model_of_point(point), effects)
    found = propagate(model)
    return replace(point, torque=found.estimate, components=found.components, model=model)


def _effect(part: Component) -> Effect:
    """Return a component as an input of uncertainty 1, so that a common one is the same everywhere.

    Its sign is not known: that of a common one is taken to be the same in all points.
    """
    name = part.distribution
    known = Distribution(name) if name in set(Distribution) else Distribution.NORMAL
    u = nan if isnan(part.u) else 1.0
    return Effect(Input(part.name, 0.0, u, part.dof, known, "1", part.common), part.u)
