"""Inputs of measurement models as methods need them, and the model that they make up."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.uncertainty import Corrected, Distribution, Effect, Input, MeasurementModel

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.data import Array
    from rigrunner.api.uncertainty import Equation, Line


def limited(name: str, half_width: float, unit: str = "N·m", value: float = 0.0) -> Input:
    """Return an input within value +/- half_width, its error the same in the whole run.

    Rectangular distribution, u = a/sqrt(3) (GUM 4.3.7).
    """
    u = abs(half_width) / sqrt(3)
    return Input(name, value, u, inf, Distribution.RECTANGULAR, unit, common=True)


def bounded_effect(name: str, half_width: float) -> Effect:
    """Return what may change the result by up to that much, alike at all points.

    How much at which point is known, but not of what: the input is a number from -1 to 1.
    """
    return Effect(limited(name, 1.0, "1"), half_width)


def scattered(name: str, u: float, dof: float) -> Effect:
    """Return the type A input of one point: the error of a mean of few values (GUM 4.2)."""
    return Effect(Input(name, 0.0, u, dof, Distribution.T), 1.0)


def unknown(name: str) -> Effect:
    """Return an input of unknown uncertainty; then that of the result is unknown too."""
    return scattered(name, nan, nan)


def model_of(
    value: float,
    effects: Sequence[Effect],
    *,
    scales: Sequence[Input] = (),
    correlations: Mapping[str, Array] | None = None,
    lines: Mapping[str, Line] | None = None,
) -> MeasurementModel:
    """Return the model of a corrected value.

    `scales` are relative errors of the whole. `correlations` has for an ensemble that of its
    inputs, (m, m), in the order of the effects.
    """
    inputs = (*(effect.input for effect in effects), *scales)
    correlation: Array | None = None
    if correlations:
        correlation = np.eye(len(inputs))
        for ensemble, part in correlations.items():
            rows = [i for i, input_ in enumerate(inputs) if input_.ensemble == ensemble]
            correlation[np.ix_(rows, rows)] = part
    return MeasurementModel(
        inputs=inputs,
        equation=Corrected(value, tuple(effects), tuple(scale.name for scale in scales)),
        correlation=correlation,
        lines=lines or {},
    )


def extended(model: MeasurementModel, effects: Sequence[Effect]) -> MeasurementModel:
    """Return a model to which some independent effects are added."""
    correlation = model.correlation
    if correlation is not None:
        count = len(model.inputs)
        correlation = np.eye(count + len(effects))
        correlation[:count, :count] = model.correlation
    return MeasurementModel(
        inputs=(*model.inputs, *(effect.input for effect in effects)),
        equation=_Extended(model.equation, Corrected(0.0, tuple(effects))),
        correlation=correlation,
        lines=model.lines,
    )


@dataclass(frozen=True)
class _Extended:
    equation: Equation
    more: Corrected

    def __call__(self, inputs: Mapping[str, Array]) -> Array:
        return np.asarray(self.equation(inputs) + self.more(inputs))
