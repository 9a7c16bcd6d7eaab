"""A measurement model as data: the inputs and the equation (GUM 4.1).

One model serves both ways of propagation: first order with degrees of freedom (GUM) and trials
(JCGM 101), which evaluate the same equation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api.data import Array

Equation = Callable[[Mapping[str, "Array"]], "Array"]
"""Takes the inputs by name, each of shape (trials,), and returns the measurand, (trials,)."""


@runtime_checkable
class Differentiable(Protocol):
    """An equation with derivatives; for others they are calculated numerically."""

    def __call__(self, inputs: Mapping[str, Array]) -> Array:
        """Return the measurand for inputs of shape (trials,)."""
        ...

    def gradient(self, inputs: Mapping[str, Array]) -> Mapping[str, Array]:
        """Return the derivative by each input that has an effect, each of shape (trials,)."""
        ...


class Distribution(StrEnum):
    """Distribution of an input (JCGM 101:2008, 6.4)."""

    NORMAL = "normal"
    T = "t"
    """Scaled and shifted: `u` is its scale s/sqrt(n), and `dof` its degrees of freedom (6.4.9)."""
    RECTANGULAR = "rectangular"
    """Within value +/- u sqrt(3) (6.4.2)."""
    TRIANGULAR = "triangular"
    """Within value +/- u sqrt(6) (6.4.5)."""
    ARCSINE = "arcsine"
    """U-shaped within value +/- u sqrt(2) (6.4.6)."""


@dataclass(frozen=True)
class Input:
    """One input quantity: estimate, standard uncertainty, and where it acts."""

    name: str
    """Unique in a model. A common input has the same name at all points of a run."""
    value: float
    u: float
    dof: float = inf
    distribution: Distribution = Distribution.NORMAL
    unit: str = "N·m"
    common: bool = False
    """True if its error is the same at all points of the run."""
    line: str = ""
    """Name of its line of the budget; by default its own."""
    ensemble: str = ""
    """Inputs with the same ensemble come from one estimation, such as the coefficients of a fit.

    They share its degrees of freedom (Willink, Metrologia 44, 2007, 340); if finite, the inputs are
    jointly t-distributed.
    """

    @property
    def budget_line(self) -> str:
        """The name of its line in the budget."""
        return self.line or self.name


@dataclass(frozen=True)
class Line:
    """A line of the budget for several inputs, such as a fit: one value of the measurand."""

    value: float
    sensitivity: float = 1.0


@dataclass(frozen=True, eq=False)
class MeasurementModel:
    """Inputs, their correlation, and the equation of the measurand.

    `correlation` has shape (n, n) in the order of the inputs; None for no correlation. Raises
    ValueError for a repeated name and for a correlation of another shape.
    """

    inputs: tuple[Input, ...]
    equation: Equation
    correlation: Array | None = None
    lines: Mapping[str, Line] = field(default_factory=dict)
    """Lines of the budget for several inputs, by name."""

    def __post_init__(self) -> None:
        names = [x.name for x in self.inputs]
        if len(set(names)) < len(names):
            raise ValueError(f"an input is repeated in {', '.join(names)}")
        if self.correlation is not None and self.correlation.shape != (len(names),) * 2:
            raise ValueError(f"{len(names)} inputs, but a correlation {self.correlation.shape}")

    @property
    def value(self) -> float:
        """The measurand at the estimates of the inputs."""
        estimates = {x.name: np.array([x.value]) for x in self.inputs}
        return float(np.ravel(self.equation(estimates))[0])


@dataclass(frozen=True)
class Effect:
    """The first-order effect of an input on the measurand."""

    input: Input
    sensitivity: float
    """Change of the measurand per change of the input (GUM 5.1.3)."""


@dataclass(frozen=True)
class Corrected:
    """y = (value + sum c_i (x_i - estimate_i)) / product (1 + e_j): the equation of a result.

    The effects are changes of the result of an algorithm; `scales` are the names of inputs that are
    relative errors of the whole, such as the gain of a transducer.
    """

    value: float
    effects: tuple[Effect, ...]
    scales: tuple[str, ...] = ()

    def __call__(self, inputs: Mapping[str, Array]) -> Array:
        """Return the measurand of trials of shape (n,)."""
        y = np.asarray(self.value)
        for effect in self.effects:
            y = y + effect.sensitivity * (inputs[effect.input.name] - effect.input.value)
        for name in self.scales:
            y = y / (1 + inputs[name])
        return np.asarray(y)
