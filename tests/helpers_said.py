"""The sentences that code says to people, read from its source: every text of more than a word."""

from __future__ import annotations

import ast
import itertools
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

UNKNOWN = "Q"
"""Stands in a sentence for what is known only when it is said."""
_FOR_FILES = {"complain", "add"}
_A_SENTENCE = re.compile(r"[a-z]{2}")


def sentences(path: Path, *, without_problems: bool = False) -> Iterator[tuple[int, str]]:
    """Yield line and text; without what a plan finds wrong in files, where that is asked for."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    left = {each.value for each in ast.walk(tree) if isinstance(each, ast.Expr)}  # docstrings
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            left |= {*ast.walk(node)} - {node}
        if without_problems and _is_of_a_problem(node):
            left |= {*ast.walk(node)}
    for node in ast.walk(tree):
        if isinstance(node, (ast.Constant, ast.JoinedStr)) and node not in left:
            for text in _said(node):
                if " " in text.strip() and _A_SENTENCE.search(text):
                    yield node.lineno, text


def _is_of_a_problem(node: ast.AST) -> bool:
    match node:
        case ast.Call(func=ast.Attribute(attr=name)):
            return name in _FOR_FILES
        case ast.Assign(targets=[ast.Name(id=name)]):
            return name in ("message", "hint") or name.isupper()
        case ast.Call(func=ast.Name(id="refused")):  # of a file
            return True
        case ast.Call(func=ast.Name(id="Field")):  # told by the schema
            return True
        case ast.FunctionDef(name="do" | "where"):  # of a step: what it raises, as the engine does
            return True
    return False


def _said(node: ast.AST) -> list[str]:
    """Return a literal in all that it may be."""
    match node:
        case ast.Constant(value=str(text)):
            return [text]
        case ast.JoinedStr(values=values):
            return ["".join(parts) for parts in itertools.product(*map(_said, values))]
        case ast.FormattedValue(value=ast.IfExp(body=body, orelse=other)):
            return [*_said(body), *_said(other)]
        case ast.FormattedValue(value=ast.Constant() | ast.JoinedStr() as value):
            return _said(value)
    return [UNKNOWN]
