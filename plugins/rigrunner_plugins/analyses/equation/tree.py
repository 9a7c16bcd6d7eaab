"""The expression tree of a measurement model, with its derivatives."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.expression.evaluation import evaluated
from rigrunner.signal.expression.syntax import Expression, Name, Operation
from rigrunner_plugins.analyses.equation.kinds import written

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
    wanted: str
    fixed: Mapping[str, float]
    """Values without uncertainty, in SI units."""
    effects: Mapping[str, tuple[Effect, ...]]
    """The effects on each channel or result, by its symbol in the model."""
    factor: float
    offset: float

    def __call__(self, inputs: Mapping[str, Array]) -> Array:
        """Return the result for trials, shape (n,)."""
        values = self._values(inputs)
        for each in self.model.equations:
            values[each.name] = evaluated(each.expression, values)[0]
        return np.asarray((values[self.wanted] - self.offset) / self.factor)

    def gradient(self, inputs: Mapping[str, Array]) -> Mapping[str, Array]:
        """Return the derivative with respect to each input for trials, shape (n,)."""
        values = self._values(inputs)
        totals: dict[str, _Total] = {name: {name: np.array(1.0)} for name in inputs}
        for name, effects in self.effects.items():
            own = totals.setdefault(name, {})
            mean = self._mean(name, inputs)
            gains = [each.name for each in effects if each.is_gain]
            if name in own:
                own[name] = 1.0 + np.asarray(sum(inputs[gain] for gain in gains))
            for each in effects:
                own[each.name] = mean if each.is_gain else np.array(each.slope)
        for equation in self.model.equations:
            names = equation.expression.names()
            value, slopes = evaluated(equation.expression, values, names)
            values[equation.name] = value
            total: _Total = {}
            for name, slope in slopes.items():
                for of, part in totals.get(name, {}).items():
                    total[of] = total.get(of, 0.0) + slope * part
            totals[equation.name] = total
        return {name: each / self.factor for name, each in totals[self.wanted].items()}

    def undefined(self, inputs: Mapping[str, Array]) -> str:
        """Return the innermost part of the equation that gives no finite number, as text."""
        values = self._values(inputs)
        parts = {each.name: each.expression for each in self.model.equations}
        for name, part in parts.items():
            values[name] = evaluated(part, values)[0]
        node: Node = Name(self.wanted, 0)
        while True:
            if isinstance(node, Name) and node.name in parts:
                node = parts[node.name].root
            inner = node.operands if isinstance(node, Operation) else ()
            bad = [
                each
                for each in inner
                if not np.isfinite(evaluated(Expression("", each), values)[0])
            ]
            if not bad:
                break
            node = bad[0]
        text = written(node)
        for name, literal in self.model.literals.items():
            text = re.sub(rf"\b{name}\b", str(literal), text)
        return text

    def _values(self, inputs: Mapping[str, Array]) -> dict[str, Array]:
        values: dict[str, Array] = {name: np.asarray(each) for name, each in self.fixed.items()}
        values |= inputs
        for name, effects in self.effects.items():
            mean = self._mean(name, inputs)
            total = mean
            for each in effects:
                moved = each.slope * (inputs[each.name] - each.at)
                total = total + moved * (mean if each.is_gain else 1.0)
            values[name] = total
        return values

    def _mean(self, name: str, inputs: Mapping[str, Array]) -> Array:
        return inputs[name] if name in inputs else np.asarray(self.fixed[name])
