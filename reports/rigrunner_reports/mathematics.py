"""Equations as MathML, which browsers show and print."""

from __future__ import annotations

import re
import unicodedata
from typing import TYPE_CHECKING

from markupsafe import Markup, escape

from rigrunner.signal.expression.syntax import CONSTANTS, Name, Number, Operation, parse_any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.findings import Formula
    from rigrunner.signal.expression.syntax import Node

_SHOWN = {"arcsin": "arcsin", "arccos": "arccos", "arctan": "arctan", "log": "ln", "log10": "lg"}
_RANK = {"+": 1, "-": 1, "*": 2, "/": 4, "**": 3}
"""Precedence of an operation; a fraction needs no parentheses."""
_SIGN = {"+": "+", "-": "\N{MINUS SIGN}", "*": "\N{DOT OPERATOR}"}


def equation(formula: Formula) -> Markup:
    """Return `symbol = text` as MathML, with the text in `alttext`."""
    root = parse_any(formula.text).root
    left = _name(formula.symbol)
    right = _node(root, formula.quantities)
    alt = escape(f"{formula.symbol} = {formula.text}")
    return Markup(f'<math display="block" alttext="{alt}">{left}<mo>=</mo>{right}</math>')  # noqa: S704  (made of escaped parts)


def _node(node: Node, quantities: Mapping[str, str]) -> Markup:
    if isinstance(node, Number):
        return (
            _row("mi", "\N{GREEK SMALL LETTER PI}")
            if node.value == CONSTANTS["pi"]
            else _number(node.value)
        )
    if isinstance(node, Name):
        if node.name in quantities:
            return _row("mtext", quantities[node.name])
        return _name(node.name)
    return _operation(node, quantities)


def _operation(node: Operation, quantities: Mapping[str, str]) -> Markup:
    parts = [_node(operand, quantities) for operand in node.operands]
    if node.function in _RANK:
        return _arithmetic(node, parts)
    if node.function == "sqrt":
        return _join("msqrt", *parts)
    if node.function == "abs":
        return _join("mrow", _row("mo", "|"), *parts, _row("mo", "|"))
    name = _row("mi", _SHOWN.get(node.function, node.function))
    listed = Markup("<mo>,</mo>").join(parts)
    return _join("mrow", name, _row("mo", "("), listed, _row("mo", ")"))


def _arithmetic(node: Operation, parts: list[Markup]) -> Markup:
    if node.function == "/":
        return _join("mfrac", *map(_group, parts))
    if node.function == "**":
        base = _bracket(node.operands[0], parts[0], _RANK["/"] + 1)
        return _join("msup", _group(base), _group(parts[1]))
    sign, rank = _row("mo", _SIGN[node.function]), _RANK[node.function]
    if len(parts) == 1:
        return _join("mrow", sign, _bracket(node.operands[0], parts[0], _RANK["*"]))
    left = _bracket(node.operands[0], parts[0], rank)
    right = _bracket(node.operands[1], parts[1], rank + (node.function == "-"))
    return _join("mrow", left, sign, right)


def _bracket(node: Node, part: Markup, rank: int) -> Markup:
    binds = 9
    if isinstance(node, Operation):
        is_sign = node.function == "-" and len(node.operands) == 1
        binds = _RANK["+"] if is_sign else _RANK.get(node.function, 9)
    if binds >= rank:
        return part
    return _join("mrow", _row("mo", "("), part, _row("mo", ")"))


def _name(name: str) -> Markup:
    """Return a name as a symbol: `t_R` with an index, `alpha` as its letter."""
    first, _, index = name.partition("_")
    if numbered := re.fullmatch(r"([A-Za-z]+)([0-9]+)", name):
        first, index = numbered.groups()
    symbol = _row("mi", _letter(first))
    if not index:
        return symbol
    parts = ",".join(_letter(part) for part in index.split("_"))
    return _join("msub", symbol, _row("mtext", parts))


def _letter(name: str) -> str:
    """Return the Greek letter with that name, or the name."""
    case = "SMALL" if name.islower() else "CAPITAL"
    spelled = "lamda" if name.lower() == "lambda" else name
    try:
        return unicodedata.lookup(f"GREEK {case} LETTER {spelled}")
    except KeyError:
        return name


def _number(value: float) -> Markup:
    digits, _, exponent = f"{value:.12g}".partition("e")
    if not exponent:
        return _row("mn", digits)
    power = _join(
        "msup", _row("mn", "10"), _row("mn", str(int(exponent)).replace("-", "\N{MINUS SIGN}"))
    )
    return _join("mrow", _row("mn", digits), _row("mo", _SIGN["*"]), power)


def _group(part: Markup) -> Markup:
    return _join("mrow", part)


def _row(tag: str, text: str) -> Markup:
    return Markup(f"<{tag}>{escape(text)}</{tag}>")  # noqa: S704  (escaped)


def _join(tag: str, *parts: Markup) -> Markup:
    return Markup(f"<{tag}>{Markup().join(parts)}</{tag}>")  # noqa: S704  (parts are markup)
