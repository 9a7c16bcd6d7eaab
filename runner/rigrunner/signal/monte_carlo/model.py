"""Draws the inputs of a measurement model and evaluates its equation (JCGM 101:2008, 5.4)."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.monte_carlo.distributions import (
    MultivariateNormal,
    MultivariateT,
    OneError,
    named,
)
from rigrunner.signal.propagation import connected, one_error

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.random import Generator

    from rigrunner.api.data import Array
    from rigrunner.api.uncertainty import Input, MeasurementModel
    from rigrunner.signal.monte_carlo.distributions import Distribution


def output_of(model: MeasurementModel) -> Callable[[Generator, int], Array]:
    """Return the function that draws n values of the measurand, shape (n,).

    Inputs that are correlated, or of one ensemble, are drawn together: as a multivariate t of the
    degrees of freedom that they share, or a multivariate normal if these are infinite; bounded ones
    with r = 1 or -1 as one error. Raises DataError for correlations that contradict each other.
    """
    alone, together = _grouped_inputs(model)

    def output(rng: Generator, n: int) -> Array:
        drawn: dict[str, Array] = {
            input_.name: named(input_.distribution, input_.value, input_.u, input_.dof).draw(rng, n)
            for input_ in alone
        }
        for group, distribution in together:
            rows = distribution.draw(rng, n)
            drawn |= {input_.name: rows[:, i] for i, input_ in enumerate(group)}
        # An equation without inputs gives a single value.
        return np.asarray(np.broadcast_to(model.equation(drawn), n))

    return output


def _grouped_inputs(
    model: MeasurementModel,
) -> tuple[tuple[Input, ...], tuple[tuple[tuple[Input, ...], Distribution], ...]]:
    """Return the inputs that are drawn alone, and those that are drawn together."""
    groups = connected(model)
    alone = tuple(model.inputs[group[0]] for group in groups if len(group) == 1)
    together = tuple(
        (tuple(model.inputs[row] for row in group), _joint(model, group))
        for group in groups
        if len(group) > 1
    )
    return alone, together


def _joint(model: MeasurementModel, rows: Sequence[int]) -> Distribution:
    inputs = [model.inputs[row] for row in rows]
    mean = np.array([input_.value for input_ in inputs])
    if (error_u := one_error(model, rows)) is not None:
        return OneError(mean, error_u, named(inputs[0].distribution, 0.0, 1.0, inputs[0].dof))
    u = np.array([input_.u for input_ in inputs])
    identity = np.eye(len(rows))
    r = identity if model.correlation is None else model.correlation[np.ix_(rows, rows)]
    # They share it: correlated inputs of different degrees of freedom cannot be propagated.
    dof = min(input_.dof for input_ in inputs)
    scale = r * np.outer(u, u)
    return MultivariateNormal(mean, scale) if dof == inf else MultivariateT(mean, scale, dof)
