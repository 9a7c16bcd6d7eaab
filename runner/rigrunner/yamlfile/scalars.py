"""The values of unquoted scalars: the core schema of YAML 1.2, without its ambiguous forms."""

from __future__ import annotations

import math
import re

_CONSTANTS: dict[str, bool | None] = {
    "": None, "~": None, "null": None, "Null": None, "NULL": None,
    "true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False,
}  # fmt: skip
_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_LEADING_ZERO = re.compile(r"[-+]?0+[0-9]")
_MAX_DIGITS = 40


class ScalarError(ValueError):
    """A scalar that has two possible meanings, or none."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint


def read_plain(text: str) -> bool | float | str | None:
    """Return the value of an unquoted scalar. Raises ScalarError where it is ambiguous."""
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if _NOT_FINITE.fullmatch(text):
        raise ScalarError(f"{text} is not a number to work with", "write a finite number")
    if _FLOAT.fullmatch(text):
        return _number(text)
    return text


def _number(text: str) -> float:
    if len(text) > _MAX_DIGITS:
        raise ScalarError(f"a number of {len(text)} characters", "put it in quotes if it is a text")
    if _LEADING_ZERO.match(text):
        hint = f"write {_stripped(text)} for the number, or '{text}' in quotes for the text"
        raise ScalarError(f"{text} has a leading zero", hint)
    value = int(text) if _INTEGER.fullmatch(text) else float(text)
    if not math.isfinite(value):
        raise ScalarError(f"{text} is too large a number", "write a smaller number")
    return value


def _stripped(text: str) -> str:
    sign = text[0] if text[0] in "+-" else ""
    return sign + re.sub("^0+(?=[0-9])", "", text.removeprefix(sign))
