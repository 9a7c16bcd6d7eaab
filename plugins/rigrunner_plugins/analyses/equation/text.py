"""From the text of a model to its equations. Loads without numpy.

    R = U / I * (1 + alpha*(t - t0))
    P = U * I

Each equation begins on a line of its own; a model of one may leave `R =` out. Later ones may use
what earlier ones define. `^` is a power, and `number(0, °C)` a number with its unit.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api import Quantity, parse_quantity
from rigrunner.api.member import NAME
from rigrunner.signal.expression.syntax import (
    ALIASES,
    CONSTANTS,
    FUNCTIONS,
    LONGEST,
    OF_SEVERAL,
    ExpressionError,
    parse,
)

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from rigrunner.signal.expression.syntax import Expression, Node

MOST_EQUATIONS = 30
RESERVED = {*FUNCTIONS, *OF_SEVERAL, *ALIASES, *CONSTANTS, "number"}
"""Names that no quantity may have."""
_BEGINS = re.compile(rf"^[ \t]*({NAME})[ \t]*=(?!=)", re.MULTILINE)
_QUANTITY = re.compile(r"\bnumber\(([^,()]{1,40}),((?:[^()]|\([^()]*\)){1,40})\)")


@dataclass(frozen=True)
class Equation:
    """One quantity and its formula."""

    name: str
    expression: Expression


@dataclass(frozen=True)
class Model:
    """The equations, in the order in which they are computed."""

    equations: tuple[Equation, ...]
    literals: Mapping[str, Quantity]
    """Numbers with units in the text, by the names that replace them in the formulas."""
    origins: tuple[int, ...]
    """For each character of the formulas, from 0, its column in the text, from 1."""

    def column(self, node: Node) -> int:
        """Return the column of the text where a part of a formula begins."""
        return self.origins[min(node.column, len(self.origins)) - 1]


def read(text: str, input_names: Collection[str], result_names: Collection[str]) -> Model:
    """Return the model of a text; raise ExpressionError with the column of the error.

    `input_names` are those of inputs and constants. A model without `name =` gives the only result.
    """
    if len(text) > LONGEST:
        raise ExpressionError(
            f"the model has {len(text)} characters", column=LONGEST + 1,
            hint=f"at most {LONGEST} are read",
        )  # fmt: skip
    formulas, origins, literals = _translate(text)
    beginnings = list(_BEGINS.finditer(formulas))
    if len(beginnings) > MOST_EQUATIONS:
        raise ExpressionError(f"it has {len(beginnings)} equations",
                              hint=f"expected at most {MOST_EQUATIONS}")  # fmt: skip
    equations: list[Equation] = []
    known_names = {*input_names, *literals}
    for name, at, start, end in _parts(formulas, beginnings, result_names, origins):
        if name in known_names or name in RESERVED:
            reason = "there already" if name in known_names else "a name of the language"
            column = origins[at]
            raise ExpressionError(f"column {column}: '{name}' is {reason}", column=column,
                                  hint="give it another name")  # fmt: skip
        try:
            # Blanks in place of the text before keep the columns of errors right.
            expression = parse(" " * start + formulas[start:end], known_names)
        except ExpressionError as error:
            raise _at_origin(error, origins) from None
        equations.append(Equation(name, expression))
        known_names.add(name)
    defined = {equation.name for equation in equations}
    missing = [name for name in result_names if name not in defined]
    if missing:
        raise ExpressionError(f"it gives no '{missing[0]}'", hint=f"write '{missing[0]} = ...'")
    return Model(tuple(equations), literals, origins)


def _parts(
    formulas: str,
    beginnings: list[re.Match[str]],
    result_names: Collection[str],
    origins: tuple[int, ...],
) -> list[tuple[str, int, int, int]]:
    """Return each name, its position, and the start and end of its formula."""
    if not beginnings:
        (only, *others) = result_names
        if others:
            names = ", ".join(result_names)
            hint = f"write a line 'name = ...' for each of {names}"
            raise ExpressionError("it does not say which result it gives", hint=hint)
        return [(only, formulas.find(only), 0, len(formulas))]
    first = len(formulas) - len(formulas.lstrip())
    if beginnings[0].start(1) > first:
        column = origins[first]
        raise ExpressionError(
            f"column {column}: a formula without a name", column=column, hint="write 'name = ...'"
        )
    ends = [beginning.start() for beginning in beginnings[1:]] + [len(formulas)]
    return [
        (beginning[1], beginning.start(1), beginning.end(), end)
        for beginning, end in zip(beginnings, ends, strict=True)
    ]


def _translate(text: str) -> tuple[str, tuple[int, ...], dict[str, Quantity]]:
    """Return the text in formula syntax, the origin of each character, and the quantities."""
    parts: list[str] = []
    origins: list[int] = []
    literals: dict[str, Quantity] = {}
    at = 0
    while at < len(text):
        match = _QUANTITY.match(text, at) if text[at] == "n" else None
        if match is not None:
            name = f"number_{len(literals) + 1}"
            literals[name] = _quantity(match, at + 1)
            parts.append(name)
            origins += [at + 1] * len(name)
            at = match.end()
            continue
        character = "**" if text[at] == "^" else text[at]
        parts.append(character)
        origins += [at + 1] * len(character)
        at += 1
    return "".join(parts), (*origins, len(text) + 1), literals


def _quantity(match: re.Match[str], column: int) -> Quantity:
    try:
        return parse_quantity(f"{match[1].strip()} {match[2].strip()}")
    except ValueError as error:
        message = getattr(error, "message", str(error))
        raise ExpressionError(f"column {column}: {message}", column=column,
                              hint="such as number(20, °C)") from None  # fmt: skip


def _at_origin(error: ExpressionError, origins: tuple[int, ...]) -> ExpressionError:
    """Return an error in the formulas as an error in the text."""
    column = origins[min(error.column, len(origins)) - 1]
    message = error.message.replace(f"column {error.column}: ", f"column {column}: ", 1)
    return ExpressionError(message, column=column, hint=error.hint)
