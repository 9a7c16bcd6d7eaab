"""From the text of a formula to its tree; loads without numpy.

Python's own parser reads the text, but nothing of it is ever run: first every character and word
is looked at, then each node of the parsed tree is translated or refused. What is left are numbers,
known names, + - * / ** and the functions below, with a limit to length and depth.
"""

from __future__ import annotations

import ast
import keyword
import re
import unicodedata
from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING, NoReturn

from rigrunner.api.errors import TextError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

FUNCTIONS = (
    "exp", "log", "log10", "sqrt", "sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh",
    "cosh", "tanh", "abs",
)  # fmt: skip
"""Of one number each; angles are in rad."""
OF_SEVERAL = {"atan2": 2, "min": 0, "max": 0, "mean": 0}
"""Functions of so many numbers; 0: of any number of them. atan2(y, x) is the angle of (x, y)."""
ALIASES = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "ln": "log"}
"""Other names of functions."""
CONSTANTS = {"pi": 3.141592653589793}
LONGEST = 2000
"""Characters of a formula."""
DEEPEST = 100
"""Operations within operations; a sum of terms counts one for each."""
LARGEST_POWER = 100
"""Of numbers up to 1000 such a power is still a finite double."""

_KNOWN_FUNCTIONS = (*FUNCTIONS, *OF_SEVERAL, *ALIASES)
_DEPTH_HINT = f"at most {DEEPEST} operations are nested"
_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "**",
}
_NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_WORD = re.compile(rf"(?P<number>{_NUMBER})|(?P<name>[A-Za-z]\w*)|(?P<sign>[-+*/(),])|\s", re.ASCII)
_INSTEAD = {
    "^": "**", "[": "(", "]": ")", "{": "(", "}": ")", "\N{MIDDLE DOT}": "*",
    "\N{MULTIPLICATION SIGN}": "*", "\N{DIVISION SIGN}": "/", "\N{MINUS SIGN}": "-", "²": "**2",
    "³": "**3",
}  # fmt: skip


class ExpressionError(TextError):
    """A text is not a formula that is allowed here."""


@dataclass(frozen=True)
class Number:
    """A number as it stands in the formula."""

    value: float
    column: int


@dataclass(frozen=True)
class Name:
    """A quantity of the formula."""

    name: str
    column: int


@dataclass(frozen=True)
class Operation:
    """One of FUNCTIONS or OF_SEVERAL, '+', '-', '*', '/' or '**'; '-' of one is its negative."""

    function: str
    operands: tuple[Node, ...]
    column: int


Node = Number | Name | Operation
"""Each with the column of the text, from 1, where it begins."""


@dataclass(frozen=True)
class Expression:
    """A formula that was read."""

    text: str
    root: Node

    def names(self) -> frozenset[str]:
        """Return the names of the quantities in it."""
        return frozenset(node.name for node in _nodes(self.root) if isinstance(node, Name))


def parse(text: str, names: Collection[str]) -> Expression:
    """Return the formula of a text that uses no other quantities than `names`.

    Raises ExpressionError with the column for anything else.
    """
    if len(text) > LONGEST:
        raise ExpressionError(
            f"the formula has {len(text)} characters",
            column=LONGEST + 1,
            hint=f"at most {LONGEST} are read",
        )
    _refuse_words(text)
    blank = re.sub(r"\s", " ", text)
    formula = blank.lstrip()
    begin = len(blank) - len(formula)
    try:
        # "?" stands for an empty text, so that it has a SyntaxError too.
        tree = ast.parse(formula or "?", mode="eval")
    except (RecursionError, MemoryError):
        raise ExpressionError("the formula is nested too deeply", hint=_DEPTH_HINT) from None
    except SyntaxError as error:
        if "nested" in error.msg:  # Python has a limit of its own for parentheses
            raise ExpressionError("the formula is nested too deeply", hint=_DEPTH_HINT) from None
        column = begin + (error.offset or len(text) + 1)
        _refuse(text, min(column, len(text) + 1), "is not understood here")
    reading = _Reading(text, begin + 1, frozenset(names))
    return Expression(text, reading.node(tree.body, 0))


def parse_any(text: str) -> Expression:
    """Return the formula of a text with any names of quantities; raise ExpressionError."""
    words = {match["name"] for match in _WORD.finditer(text) if match["name"]}
    return parse(text, words - set(_KNOWN_FUNCTIONS) - set(CONSTANTS))


def _nodes(node: Node) -> Iterator[Node]:
    yield node
    if isinstance(node, Operation):
        for operand in node.operands:
            yield from _nodes(operand)


def _refuse(text: str, column: int, what: str, hint: str = "") -> NoReturn:
    """Raise the error for what stands at a column, counted from 1."""
    match = re.match(r"\w+|.|$", text[column - 1 :], re.DOTALL)
    shown = f"'{match[0][:20]}'" if match and match[0] else "the end"
    raise ExpressionError(f"column {column}: {shown} {what}", column=column, hint=hint)


def _refuse_words(text: str) -> None:
    """Raise ExpressionError for the first word that no formula has; only ASCII is left."""
    position = 0
    while position < len(text):
        word = _WORD.match(text, position)
        if word is None:
            _refuse_character(text, position)
        after = text[word.end() : word.end() + 1]
        # Python would read 0x1F, 1_000 and 2j as numbers.
        if word["number"] and (after.isalnum() or after in ("_", ".")):
            _refuse(text, word.end() + 1, "follows a number", "write * between them")
        if word["name"] and keyword.iskeyword(word["name"]):
            _refuse(text, position + 1, "is a reserved word, not the name of a quantity")
        position = word.end()


def _refuse_character(text: str, position: int) -> NoReturn:
    character = text[position]
    if character in _INSTEAD:
        _refuse(text, position + 1, "is not allowed", f"write {_INSTEAD[character]}")
    name = unicodedata.name(character, f"U+{ord(character):04X}")
    shown = f" '{character}'" if character.isprintable() else ""
    raise ExpressionError(
        f"column {position + 1}: the character{shown} ({name}) is not allowed",
        column=position + 1,
        hint="expected letters a to z and A to Z, digits, _ . , + - * / ( )",
    )


@dataclass(frozen=True)
class _Reading:
    """Translates the nodes that are allowed."""

    text: str
    first: int
    """The column where the parsed text begins."""
    names: frozenset[str]

    def node(self, node: ast.expr, depth: int) -> Node:
        column = node.col_offset + self.first
        if depth > DEEPEST:
            raise ExpressionError(
                f"column {column}: nested too deeply", column=column, hint=_DEPTH_HINT
            )
        match node:
            case ast.Constant():
                return self._number(node, column)
            case ast.Name():
                return self._name(node.id, column)
            case ast.UnaryOp(op=ast.UAdd()):
                return self.node(node.operand, depth + 1)
            case ast.UnaryOp(op=ast.USub()):
                return Operation("-", (self.node(node.operand, depth + 1),), column)
            case ast.BinOp():
                return self._binary(node, depth)
            case ast.Call(func=ast.Name(id=name), keywords=[]):
                return self._call(name, node, column, depth)
        _refuse(self.text, column, f"begins a {type(node).__name__}, which no formula has")

    def _number(self, node: ast.Constant, column: int) -> Number:
        if not isinstance(node.value, int | float):  # True is an int, but is refused as a word
            _refuse(self.text, column, "is not a number")
        try:
            value = float(node.value)
        except OverflowError:
            value = inf
        if not isfinite(value):
            _refuse(self.text, column, "is too large a number")
        return Number(value, column)

    def _name(self, name: str, column: int) -> Node:
        if name in self.names:
            return Name(name, column)
        if name in CONSTANTS:
            return Number(CONSTANTS[name], column)
        if name in _KNOWN_FUNCTIONS:
            _refuse(self.text, column, "is a function", f"write {name}(...)")
        names = sorted(self.names | set(CONSTANTS))
        hint = did_you_mean(name, names, f"known are {', '.join(names)}", cutoff=0.5)
        _refuse(self.text, column, "is not known", hint)

    def _binary(self, node: ast.BinOp, depth: int) -> Node:
        column = node.col_offset + self.first
        sign = _OPERATORS.get(type(node.op))
        if sign is None:
            _refuse(self.text, column, "begins an operation that is not allowed", "+ - * / ** are")
        left, right = self.node(node.left, depth + 1), self.node(node.right, depth + 1)
        if sign == "**":
            self._refuse_power(right)
        return Operation(sign, (left, right), column)

    def _refuse_power(self, exponent: Node) -> None:
        nodes = list(_nodes(exponent))
        for node in nodes:
            if isinstance(node, Number) and node.value > LARGEST_POWER:
                allowed = f"-{LARGEST_POWER} to {LARGEST_POWER}"
                _refuse(self.text, node.column, f"is a power out of range ({allowed})")
        if not any(isinstance(node, Name) for node in nodes):
            for node in nodes:
                if isinstance(node, Operation) and node.function == "**":
                    _refuse(self.text, node.column, "is a power of numbers within a power")

    def _call(self, name: str, node: ast.Call, column: int, depth: int) -> Node:
        if name not in _KNOWN_FUNCTIONS:
            what = "is a quantity, not a function" if name in self.names else "is not a function"
            functions = ", ".join(_KNOWN_FUNCTIONS)
            hint = did_you_mean(name, _KNOWN_FUNCTIONS, f"functions are {functions}")
            _refuse(self.text, column, what, hint)
        name = ALIASES.get(name, name)
        count, arity = len(node.args), OF_SEVERAL.get(name, 1)
        if count < 1 or (arity and count != arity):
            expected = ("at least one number", "one number", "two numbers")[arity]
            _refuse(self.text, column, f"takes {expected}, not {count}")
        operands = tuple(self.node(arg, depth + 1) for arg in node.args)
        return Operation(name, operands, column)
