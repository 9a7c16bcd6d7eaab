"""The value of a formula and its derivatives, in the precision of what goes in."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.signal.expression.syntax import Name, Number

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from rigrunner.signal.expression.syntax import Expression, Node, Operation


def evaluated(
    expression: Expression, values: Mapping[str, Any], by: Collection[str] = ()
) -> tuple[Any, dict[str, Any]]:
    """Return the value of a formula, and its derivative by each name of `by` that is in it.

    `values` has a number or an array for each name; they broadcast against each other, and the
    result has their precision. Derivatives by forward differentiation of the tree, with the rules
    of calculus. What is not defined, such as log(-1), is nan or inf, without a warning.
    """
    with np.errstate(all="ignore"):
        result = _Evaluation(values, frozenset(by)).of(expression.root)
    return result.value, result.slopes


@dataclass(frozen=True)
class _Dual:
    """A value, and its derivative by each name that it depends on."""

    value: Any
    slopes: dict[str, Any]

    def chained(self, value: Any, slope: Any) -> _Dual:
        """Return a function of this value, with its derivative by it."""
        return _Dual(value, {name: slope * inner for name, inner in self.slopes.items()})

    def plus(self, other: _Dual, value: Any) -> _Dual:
        """Return the value with the derivatives of both added."""
        slopes = dict(self.slopes)
        for name, slope in other.slopes.items():
            slopes[name] = slopes[name] + slope if name in slopes else slope
        return _Dual(value, slopes)


@dataclass(frozen=True)
class _Evaluation:
    values: Mapping[str, Any]
    by: frozenset[str]

    def of(self, node: Node) -> _Dual:
        if isinstance(node, Number):
            return _Dual(node.value, {})
        if isinstance(node, Name):
            value = self.values[node.name]
            return _Dual(value, {node.name: np.ones_like(value)} if node.name in self.by else {})
        return self._operation(node)

    def _operation(self, node: Operation) -> _Dual:
        first, *others = (self.of(operand) for operand in node.operands)
        if node.function in _SEVERAL:
            return _SEVERAL[node.function]([first, *others])
        if node.function == "-" and not others:
            return first.chained(-first.value, -1.0)
        if not others:
            value, slope = _FUNCTIONS[node.function](first.value)
            return first.chained(value, slope)
        return _BINARY[node.function](first, others[0])


def _sum(a: _Dual, b: _Dual) -> _Dual:
    return a.plus(b, a.value + b.value)


def _difference(a: _Dual, b: _Dual) -> _Dual:
    return a.plus(b.chained(b.value, -1.0), a.value - b.value)


def _product(a: _Dual, b: _Dual) -> _Dual:
    value = a.value * b.value
    return a.chained(value, b.value).plus(b.chained(value, a.value), value)


def _quotient(a: _Dual, b: _Dual) -> _Dual:
    value = np.divide(a.value, b.value)
    return a.chained(value, np.divide(1, b.value)).plus(
        b.chained(value, np.divide(-value, b.value)), value
    )


def _power(a: _Dual, b: _Dual) -> _Dual:
    value = np.power(a.value, b.value)
    result = a.chained(value, b.value * np.power(a.value, b.value - 1.0)) if a.slopes else a
    if b.slopes:
        # Of 0**b it is 0; the formula would give 0 * log(0), which is nan.
        slope = np.where(np.equal(value, 0), 0, value * np.log(a.value))
        result = result.plus(b.chained(value, slope), value)
    return _Dual(value, result.slopes)


def _angle(operands: Sequence[_Dual]) -> _Dual:
    y, x = operands
    value, square = np.arctan2(y.value, x.value), x.value * x.value + y.value * y.value
    by_y, by_x = np.divide(x.value, square), np.divide(-y.value, square)
    return y.chained(value, by_y).plus(x.chained(value, by_x), value)


def _least(operands: Sequence[_Dual]) -> _Dual:
    return reduce(lambda a, b: _chosen(a, b, np.less_equal(a.value, b.value)), operands)


def _greatest(operands: Sequence[_Dual]) -> _Dual:
    return reduce(lambda a, b: _chosen(a, b, np.greater_equal(a.value, b.value)), operands)


def _chosen(a: _Dual, b: _Dual, first: Any) -> _Dual:
    value = np.where(first, a.value, b.value)
    return a.chained(value, np.where(first, 1.0, 0.0)).plus(
        b.chained(value, np.where(first, 0.0, 1.0)), value
    )


def _mean(operands: Sequence[_Dual]) -> _Dual:
    total = reduce(_sum, operands)
    return total.chained(np.divide(total.value, len(operands)), 1 / len(operands))


_SEVERAL: Mapping[str, Callable[[Sequence[_Dual]], _Dual]] = {
    "atan2": _angle,
    "min": _least,
    "max": _greatest,
    "mean": _mean,
}

_BINARY: Mapping[str, Callable[[_Dual, _Dual], _Dual]] = {
    "+": _sum,
    "-": _difference,
    "*": _product,
    "/": _quotient,
    "**": _power,
}


def _exp(x: Any) -> tuple[Any, Any]:
    value = np.exp(x)
    return value, value


def _sqrt(x: Any) -> tuple[Any, Any]:
    value = np.sqrt(x)
    return value, np.divide(0.5, value)


def _tan(x: Any) -> tuple[Any, Any]:
    value = np.tan(x)
    return value, 1 + value**2


def _tanh(x: Any) -> tuple[Any, Any]:
    value = np.tanh(x)
    return value, 1 - value**2


_FUNCTIONS: Mapping[str, Callable[[Any], tuple[Any, Any]]] = {
    "exp": _exp,
    "log": lambda x: (np.log(x), np.divide(1, x)),
    # A log(10) of float64 would limit the extended precision in which a fit is refined.
    "log10": lambda x: (np.log10(x), np.divide(1, x * np.log(np.longdouble(10)))),
    "sqrt": _sqrt,
    "sin": lambda x: (np.sin(x), np.cos(x)),
    "cos": lambda x: (np.cos(x), -np.sin(x)),
    "tan": _tan,
    "arcsin": lambda x: (np.arcsin(x), np.divide(1, np.sqrt(1 - x * x))),
    "arccos": lambda x: (np.arccos(x), np.divide(-1, np.sqrt(1 - x * x))),
    "arctan": lambda x: (np.arctan(x), np.divide(1, 1 + x * x)),
    "sinh": lambda x: (np.sinh(x), np.cosh(x)),
    "cosh": lambda x: (np.cosh(x), np.sinh(x)),
    "tanh": _tanh,
    "abs": lambda x: (np.abs(x), np.sign(x)),
}
"""Each gives the value and the derivative."""
