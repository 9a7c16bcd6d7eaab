"""The kind of quantity of each part of a model, and the first part that does not fit.

A temperature or a power level is a point on a scale; the difference of two points is another kind:
20 °C - 15 °C is 5 K, and 13 dBm - 10 dBm is 3 dB. So a channel or constant in °C can be subtracted
from another or shifted by kelvins, but not multiplied or added. A product needs a difference, such
as (t - t0), or the thermodynamic temperature, which is the difference from -273.15 °C. A level in
dB is a number, as 10*log10(P/P0) is, but no ratio in %.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, NoReturn

from rigrunner.api import QuantityError, unit
from rigrunner.api.units import exponents_of, kind_of, of_difference, si_symbol, with_article
from rigrunner.signal.expression.syntax import CONSTANTS, Name, Number, Operation

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.signal.expression.syntax import Node

_SECOND, _ANGLE = 2, 7
"""Positions of time and angle among the exponents."""
_PLAIN = (Fraction(0),) * 8
_ANGLES = {"arcsin", "arccos", "arctan"}
TURNS = "between 1/s and rad/s is 2*pi"
_SIGNS = {"+": "added to", "-": "subtracted from"}


@dataclass(frozen=True)
class Kind:
    """The kind of a part of a model: exponents of base units, and what these do not show."""

    exponents: tuple[Fraction, ...] = _PLAIN
    scale: str = ""
    """The kind of a point on a scale, such as temperature; '' of a difference of two, and of what
    has no scale."""
    is_level: bool = False
    """Whether it is a number in dB."""

    @classmethod
    def of_unit(cls, symbol: str, *, is_channel: bool = False) -> Kind:
        """Return the kind of values in a unit; a temperature channel gives points on a scale."""
        unit_ = unit(symbol)
        is_point = of_difference(unit_.dimension) != unit_.dimension or (
            unit_.dimension == "temperature" and (is_channel or bool(unit_.offset))
        )
        return cls(
            tuple(map(Fraction, exponents_of(unit_.dimension))),
            unit_.dimension if is_point else "",
            unit_.dimension == "level",
        )

    @property
    def difference(self) -> Kind:
        """Return the kind of the difference of two points on its scale."""
        return Kind.of_unit(si_symbol(of_difference(self.scale)))

    @property
    def words(self) -> str:
        """Return the kind in words: 'a voltage', 'a number', 'a difference of temperatures'."""
        if self.scale or self.is_level:
            return with_article(self.scale or "level")
        if not any(self.exponents):
            return "a number"
        if self == DIFFERENCE:
            return "a difference of temperatures"
        if any(exponent.denominator != 1 for exponent in self.exponents):
            return "a quantity with broken powers of its unit"
        try:
            return with_article(kind_of(tuple(int(exponent) for exponent in self.exponents)))
        except QuantityError:
            return "a quantity of no known unit"

    @property
    def is_number(self) -> bool:
        """Return whether it is a plain number or an angle."""
        return not self.scale and not any(_without_angle(self))

    def fits(self, other: Kind) -> bool:
        """Return whether both are of one kind.

        rad is a number, but 1/s is not rad/s: frequency and angular velocity differ by 2 pi.
        """
        is_alike = self.scale == other.scale and _without_angle(self) == _without_angle(other)
        return is_alike and not self.is_a_turn_off(other)

    def is_a_turn_off(self, other: Kind) -> bool:
        """Return whether the two differ as a frequency and an angular velocity do."""
        if _without_angle(self) != _without_angle(other):
            return False
        only_time = not any(
            power for place, power in enumerate(self.exponents) if place not in {_SECOND, _ANGLE}
        )
        turns = abs(self.exponents[_ANGLE] - other.exponents[_ANGLE])
        return only_time and bool(self.exponents[_SECOND]) and turns == 1


DIFFERENCE = Kind(tuple(map(Fraction, exponents_of("temperature"))))
_RADIAN = Kind(tuple(map(Fraction, exponents_of("angle"))))


class KindError(Exception):
    """A part of a model has the wrong kind; holds the part and the reason."""

    def __init__(self, node: Node, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.node, self.message, self.hint = node, message, hint


def kind_of_node(node: Node, kinds: Mapping[str, Kind]) -> Kind:
    """Return the kind of a formula; raise KindError for the first part that does not fit."""
    if isinstance(node, Number):
        # pi stands for half a turn, so that 2*pi*f is an angular velocity and f alone is none.
        return _RADIAN if node.value == CONSTANTS["pi"] else Kind()
    if isinstance(node, Name):
        return kinds[node.name]
    operand_kinds = [kind_of_node(operand, kinds) for operand in node.operands]
    return _RULES.get(node.function, _of_a_number)(node, operand_kinds)


def formula_text(node: Node) -> str:
    """Return a part of a model as text, with the parentheses that it needs."""
    if isinstance(node, Number):
        return "pi" if node.value == CONSTANTS["pi"] else f"{node.value:.6g}"
    if isinstance(node, Name):
        return node.name
    parts = [formula_text(operand) for operand in node.operands]
    if node.function not in _RANKS:
        return f"{node.function}({', '.join(parts)})"
    rank = _RANKS[node.function]
    if len(parts) == 1:
        return f"-{_bracketed(node.operands[0], parts[0], rank)}"
    left = _bracketed(node.operands[0], parts[0], rank + (node.function == "**"))
    right = _bracketed(node.operands[1], parts[1], rank + (node.function in {"-", "/"}))
    sign = {"**": "^"}.get(node.function, f" {node.function} ")
    return f"{left}{sign}{right}"


_RANKS = {"+": 1, "-": 1, "*": 2, "/": 2, "**": 3}


def _bracketed(node: Node, text: str, rank: int) -> str:
    low = isinstance(node, Operation) and _RANKS.get(node.function, 9) < rank
    return f"({text})" if low else text


def _clip(node: Node) -> str:
    text = formula_text(node)
    return text if len(text) <= 30 else f"{text[:29]}…"  # noqa: PLR2004  (for a message)


def _without_angle(kind: Kind) -> tuple[Fraction, ...]:
    # The angle is the last of the exponents.
    return kind.exponents[:_ANGLE]


def _sum(node: Operation, kinds: list[Kind]) -> Kind:
    if len(kinds) == 1:
        _refuse_points(node, kinds)
        return kinds[0]
    (first, second), (left, right) = kinds, node.operands
    if first.scale and first.scale == second.scale:
        if node.function == "-":
            return first.difference
        are = "temperatures" if first.scale == "temperature" else "power levels"
        message = f"'{_clip(right)}' is added to '{_clip(left)}', and both are {are}"
        shift = si_symbol(of_difference(first.scale))
        _refuse(right, message, f"add a difference, in {shift}; for several use mean(...)")
    for point, other in ((first, second), (second, first)):
        shifts = point.scale and other.fits(point.difference)
        if shifts and (node.function == "+" or point is first):
            return point
    if not first.fits(second):
        doing = _SIGNS[node.function]
        hint = TURNS if first.is_a_turn_off(second) else ""
        _refuse(
            right,
            f"'{_clip(right)}', {second.words}, is {doing} '{_clip(left)}', {first.words}",
            hint,
        )
    return replace(first, is_level=first.is_level or second.is_level)


def _product(node: Operation, kinds: list[Kind]) -> Kind:
    _refuse_points(node, kinds)
    first, second = kinds
    sign = 1 if node.function == "*" else -1
    powers = zip(first.exponents, second.exponents, strict=True)
    is_level = first.is_level != second.is_level and (sign > 0 or first.is_level)
    is_level = is_level and first.is_number and second.is_number
    return Kind(tuple(a + sign * b for a, b in powers), is_level=is_level)


def _power(node: Operation, kinds: list[Kind]) -> Kind:
    _refuse_points(node, kinds)
    base, exponent = kinds
    if not exponent.is_number:
        right = _clip(node.operands[1])
        _refuse(node.operands[1], f"the power '{right}' is {exponent.words}; expected a number")
    if not any(base.exponents):
        return Kind()
    value = _constant_value(node.operands[1])
    if value is None:
        left = _clip(node.operands[0])
        _refuse(
            node,
            f"'{left}', {base.words}, has a power that is not written as a number",
            "divide it by a constant of its kind first",
        )
    return Kind(tuple(power * value for power in base.exponents))


def _constant_value(node: Node) -> Fraction | None:
    """Return the value of an exponent made of numbers only."""
    if isinstance(node, Number):
        return Fraction(node.value).limit_denominator(1000)
    if isinstance(node, Name):
        return None
    parts = [_constant_value(operand) for operand in node.operands]
    result: Fraction | None = None
    match node.function, parts:
        case "-", [Fraction() as value]:
            result = -value
        case "/", [Fraction() as above, Fraction() as below] if below:
            result = above / below
        case "+", [Fraction() as one, Fraction() as other]:
            result = one + other
        case "-", [Fraction() as one, Fraction() as other]:
            result = one - other
        case "*", [Fraction() as one, Fraction() as other]:
            result = one * other
    return result


def _root(node: Operation, kinds: list[Kind]) -> Kind:
    _refuse_points(node, kinds)
    return Kind(tuple(power / 2 for power in kinds[0].exponents))


def _alike(node: Operation, kinds: list[Kind]) -> Kind:
    if node.function in {"abs", "atan2"}:
        _refuse_points(node, kinds)
    for operand, kind in zip(node.operands[1:], kinds[1:], strict=True):
        if not kinds[0].fits(kind):
            first = f"'{_clip(node.operands[0])}', {kinds[0].words}"
            _refuse(
                operand,
                f"'{_clip(operand)}', {kind.words}, is in {node.function}(...) together with"
                f" {first}",
            )
    if node.function == "atan2":
        return _RADIAN
    return replace(kinds[0], is_level=any(kind.is_level for kind in kinds))


def _of_a_number(node: Operation, kinds: list[Kind]) -> Kind:
    _refuse_points(node, kinds)
    (kind,) = kinds
    if not kind.is_number:
        message = f"'{_clip(node.operands[0])}' is {kind.words}; {node.function} takes a number"
        message += " or an angle" if node.function in {"sin", "cos", "tan"} else ""
        _refuse(node.operands[0], message, "divide it by a constant of its kind")
    return _RADIAN if node.function in _ANGLES else Kind()


def _refuse_points(node: Operation, kinds: list[Kind]) -> None:
    for operand, kind in zip(node.operands, kinds, strict=True):
        if kind.scale:
            text = f"'{_clip(operand)}' is {kind.words} on a scale; here a difference is needed"
            _refuse(operand, text, _HINTS[kind.scale])


_HINTS = {
    "temperature": "write (t - t0) with a constant t0 in °C; the thermodynamic temperature is the"
    " difference from -273.15 °C",
    "power level": "write (a - number(0, dBm)), which is in dB; the power is number(1, mW) *"
    " 10^((a - number(0, dBm))/10)",
}
"""What gives a difference, by the kind of scale."""


def _refuse(node: Node, message: str, hint: str = "") -> NoReturn:
    raise KindError(node, message, hint)


_RULES = {
    "+": _sum,
    "-": _sum,
    "*": _product,
    "/": _product,
    "**": _power,
    "sqrt": _root,
    **dict.fromkeys(("min", "max", "mean", "abs", "atan2"), _alike),
}
"""The rule for the operand kinds of each operation; all others take a number."""
