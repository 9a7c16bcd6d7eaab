"""The expression tree of a measurement model, with its derivatives."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.expression.evaluation import evaluated
from rigrunner.signal.expression.syntax import Expression, Name, Operation
from rigrunner_plugins.analyses.equation.kinds import formula_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api import Array
    from rigrunner.signal.expression.syntax import Node
    from rigrunner_plugins.analyses.equation.text import Model

_Total = dict[str, "Array"]


@dataclass(frozen=True)
class Effect:
    """An input that changes a quantity by `slope` (input - `at`); for a gain, times the reading."""

    name: str
    is_gain: bool = False
    slope: float = 1.0
    at: float = 0.0


@dataclass(frozen=True, eq=False)
class Tree:
    """An equation of a model as a function of its inputs, with its derivatives.

    Implements `rigrunner.api.uncertainty.Differentiable`. The result is in its stated unit.
    """

    model: Model
    symbol: str
    fixed: Mapping[str, float]
    """Values without uncertainty, in SI units."""
    effects: Mapping[str, tuple[Effect, ...]]
    """The effects on each channel or result, by its symbol in the model."""
    factor: float
    offset: float

    def __call__(self, inputs: Mapping[str, Array]) -> Array:
        """Return the result for trials, shape (n,)."""
        values = self._values(inputs)
        for equation in self.model.equations:
            values[equation.name] = evaluated(equation.expression, values)[0]
        return np.asarray((values[self.symbol] - self.offset) / self.factor)

    def gradient(self, inputs: Mapping[str, Array]) -> Mapping[str, Array]:
        """Return the derivative with respect to each input for trials, shape (n,)."""
        values = self._values(inputs)
        totals: dict[str, _Total] = {name: {name: np.array(1.0)} for name in inputs}
        for name, effects in self.effects.items():
            derivatives = totals.setdefault(name, {})
            mean = self._mean(name, inputs)
            gains = [effect.name for effect in effects if effect.is_gain]
            if name in derivatives:
                derivatives[name] = 1.0 + np.asarray(sum(inputs[gain] for gain in gains))
            for effect in effects:
                derivatives[effect.name] = mean if effect.is_gain else np.array(effect.slope)
        for equation in self.model.equations:
            names = equation.expression.names()
            value, slopes = evaluated(equation.expression, values, names)
            values[equation.name] = value
            total: _Total = {}
            for name, slope in slopes.items():
                for input_name, part in totals.get(name, {}).items():
                    total[input_name] = total.get(input_name, 0.0) + slope * part
            totals[equation.name] = total
        return {name: slope / self.factor for name, slope in totals[self.symbol].items()}

    def undefined(self, inputs: Mapping[str, Array]) -> str:
        """Return the innermost part of the equation that gives no finite number, as text."""
        values = self._values(inputs)
        parts = {equation.name: equation.expression for equation in self.model.equations}
        for name, part in parts.items():
            values[name] = evaluated(part, values)[0]
        node: Node = Name(self.symbol, 0)
        while True:
            if isinstance(node, Name) and node.name in parts:
                node = parts[node.name].root
            operands = node.operands if isinstance(node, Operation) else ()
            undefined = [
                operand
                for operand in operands
                if not np.isfinite(evaluated(Expression("", operand), values)[0])
            ]
            if not undefined:
                break
            node = undefined[0]
        text = formula_text(node)
        for name, literal in self.model.literals.items():
            text = re.sub(rf"\b{name}\b", str(literal), text)
        return text

    def _values(self, inputs: Mapping[str, Array]) -> dict[str, Array]:
        values: dict[str, Array] = {name: np.asarray(value) for name, value in self.fixed.items()}
        values |= inputs
        for name, effects in self.effects.items():
            mean = self._mean(name, inputs)
            total = mean
            for effect in effects:
                change = effect.slope * (inputs[effect.name] - effect.at)
                total = total + change * (mean if effect.is_gain else 1.0)
            values[name] = total
        return values

    def _mean(self, name: str, inputs: Mapping[str, Array]) -> Array:
        return inputs[name] if name in inputs else np.asarray(self.fixed[name])
