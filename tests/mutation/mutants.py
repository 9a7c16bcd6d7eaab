"""Small changes of a module's syntax tree, each of which should make a test fail.

Code without effect on results is not changed: annotations, decorators, texts, and code that only a
type checker reads.
"""

from __future__ import annotations

import ast
import random
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

_BOUNDARY = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
_NEGATED = {
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
_ARITHMETIC = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
_UNCHANGED_FIELDS = {"annotation", "returns", "decorator_list", "type_comment", "msg"}
LONGEST = 70
"""Maximum characters of code in the name of a mutant."""


@dataclass(frozen=True)
class Mutant:
    """One change of one file, located by its node in the tree and named by the changed code."""

    path: str
    """Relative to the root of the sources, with '/'."""
    scope: str
    """The function or class that it is in, such as 'ConnectedDrive.move'."""
    operator: str
    old: str
    new: str
    lines: tuple[int, int]
    """The first and the last line whose tests are run."""
    node: int
    variant: int

    @property
    def change(self) -> str:
        """Return its name in a list of equivalent mutants, which does not depend on its line."""
        return f"{self.scope}: {self.old} -> {self.new}"


@dataclass(frozen=True)
class _Site:
    """A node that can be changed, its place in the tree, and its statement."""

    node: ast.AST
    parent: ast.AST
    field: str
    index: int | None
    scope: tuple[str, ...]
    statement: ast.stmt
    known_names: frozenset[str]
    """Names that have a value before this statement of a function."""

    def replace(self, new: ast.AST) -> None:
        """Put another node in its place."""
        if self.index is None:
            setattr(self.parent, self.field, new)
        else:
            getattr(self.parent, self.field)[self.index] = new


def mutants_of(root: Path, path: Path) -> list[Mutant]:
    """Return all mutants of a file."""
    source = path.read_text(encoding="utf-8")
    mutants, counts = [], dict[tuple[str, str, str], int]()
    for number, site in enumerate(_sites(ast.parse(source))):
        for variant, (operator, new) in enumerate(_variants(site)):
            texts = _short_code(site.node), _short_code(new)
            scope = ".".join(site.scope) or "module"
            counts[scope, *texts] = count = counts.get((scope, *texts), 0) + 1
            lines = _lines(site)
            change = f"{texts[1]} #{count}" if count > 1 else texts[1]
            relative = path.relative_to(root).as_posix()
            mutants.append(
                Mutant(relative, scope, operator, texts[0], change, lines, number, variant)
            )
    return mutants


def sample(root: Path, paths: Iterable[Path], count: int, seed: int) -> list[Mutant]:
    """Return a random sample of mutants; the same for the same sources and seed."""
    mutants = [mutant for path in sorted(paths) for mutant in mutants_of(root, path)]
    chosen = random.Random(seed).sample(mutants, min(count, len(mutants)))  # noqa: S311  (no secret)
    return sorted(chosen, key=attrgetter("path", "lines", "node", "variant"))


def mutated(mutant: Mutant, source: str) -> ast.Module:
    """Return the changed tree."""
    tree = ast.parse(source)
    site = next(site for number, site in enumerate(_sites(tree)) if number == mutant.node)
    _, new = list(_variants(site))[mutant.variant]
    site.replace(ast.copy_location(new, site.node))
    return ast.fix_missing_locations(tree)


def _short_code(node: ast.AST) -> str:
    text = " ".join(ast.unparse(node).split())
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _lines(site: _Site) -> tuple[int, int]:
    """Return the lines of a simple statement, or of the changed part of a compound one."""
    body = getattr(site.statement, "body", None)
    if body is None:
        return site.statement.lineno, site.statement.end_lineno or site.statement.lineno
    if isinstance(site.node, ast.ExceptHandler):
        return site.node.lineno, site.node.end_lineno or site.node.lineno
    is_header = site.node is site.statement  # the test of an if or while
    last = body[0].lineno - 1 if is_header else site.node.end_lineno
    first = site.statement.lineno if is_header else site.node.lineno
    return first, max(first, last or first)


def _sites(tree: ast.Module) -> Iterator[_Site]:
    """Yield all nodes that may be changed, always in the same order."""
    yield from _walk(tree, (), None, set())


def _walk(
    parent: ast.AST, scope: tuple[str, ...], statement: ast.stmt | None, known_names: set[str]
) -> Iterator[_Site]:
    for field, value in ast.iter_fields(parent):
        if field in _UNCHANGED_FIELDS:
            continue
        is_list = isinstance(value, list)
        for index, node in enumerate(value if is_list else [value]):
            if not isinstance(node, ast.AST) or _has_no_effect(node):
                continue
            node_scope, nearest_statement, names = scope, statement, known_names
            if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.AsyncFunctionDef):
                node_scope, names = (*scope, node.name), set[str]()
            if isinstance(node, ast.stmt):
                nearest_statement = node
            if nearest_statement is not None:
                position, before = index if is_list else None, frozenset(known_names)
                yield _Site(node, parent, field, position, node_scope, nearest_statement, before)
            yield from _walk(node, node_scope, nearest_statement, names)
            if isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign | ast.For):
                known_names.update(_names(node))


def _names(statement: ast.stmt) -> Iterator[str]:
    for node in ast.walk(statement):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id


def _has_no_effect(node: ast.AST) -> bool:
    match node:
        case ast.JoinedStr() | ast.Import() | ast.ImportFrom():
            return True
        case ast.If(test=ast.Name(id="TYPE_CHECKING")):
            return True
        case ast.Expr(value=ast.Constant()):
            return True
        case ast.Assign(targets=[ast.Name(id="__all__" | "__slots__")]):
            return True
        case ast.Call(func=ast.Name(id="TypeVar")):
            return True
    return False


def _variants(site: _Site) -> Iterator[tuple[str, ast.AST]]:
    """Yield the replacements of a node, each with the name of the change."""
    node = site.node
    yield from _expression_variants(node)
    yield from _statement_variants(node, site.known_names)
    yield from _condition_variants(node)
    in_filter = isinstance(site.parent, ast.comprehension) and site.field == "ifs"
    if in_filter and not isinstance(node, ast.Compare | ast.UnaryOp):
        yield "negated condition", ast.UnaryOp(ast.Not(), node)


def _expression_variants(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    match node:
        case ast.Compare():
            yield from _comparison_variants(node)
        case ast.BinOp(left, operator, right) if type(operator) in _ARITHMETIC:
            if not any(map(_is_text, (left, right))):
                yield "arithmetic", ast.BinOp(left, _ARITHMETIC[type(operator)](), right)
        case ast.UnaryOp(ast.Not(), operand):
            yield "not left out", operand
        case ast.UnaryOp(ast.USub(), operand):
            yield "sign", operand
        case ast.BoolOp(operator, values):
            opposite = ast.And() if isinstance(operator, ast.Or) else ast.Or()
            yield "and/or", ast.BoolOp(opposite, values)
            for index in range(len(values)):
                remaining = [*values[:index], *values[index + 1 :]]
                yield (
                    "condition left out",
                    remaining[0] if len(remaining) == 1 else ast.BoolOp(operator, remaining),
                )
        case ast.Constant(value):
            yield from (("constant", ast.Constant(number)) for number in _other_numbers(value))


def _comparison_variants(node: ast.Compare) -> Iterator[tuple[str, ast.AST]]:
    for index, operator in enumerate(node.ops):
        for name, table in (("boundary", _BOUNDARY), ("negated comparison", _NEGATED)):
            if type(operator) in table:
                operators = [*node.ops[:index], table[type(operator)](), *node.ops[index + 1 :]]
                yield name, ast.Compare(node.left, operators, node.comparators)


def _other_numbers(value: object) -> tuple[bool | float, ...]:
    """Return replacements of a constant: a limit that is only doubled might still be met."""
    match value:
        case bool():
            return (not value,)
        case int():
            return (value + 1,)
        case float():
            return (value * 100 if value else 1.0,)
    return ()


def _statement_variants(
    node: ast.AST, known_names: frozenset[str]
) -> Iterator[tuple[str, ast.AST]]:
    match node:
        case ast.Expr(ast.Call()):
            yield "call removed", ast.Pass()
        case ast.Raise():
            yield "raise removed", ast.Pass()
        case ast.Return(ast.expr() as value) if not _is_none(value):
            yield "value not returned", ast.Return(ast.Constant(None))
        case ast.Assign(targets) if all(_has_value(target, known_names) for target in targets):
            yield "assignment removed", ast.Pass()
        case ast.AugAssign(target, operator, value):
            yield "assignment removed", ast.Pass()
            if type(operator) in _ARITHMETIC and not _is_text(value):
                yield "arithmetic", ast.AugAssign(target, _ARITHMETIC[type(operator)](), value)
        case ast.ExceptHandler(type=ast.expr() as kind, name=name, body=body):
            if not (isinstance(kind, ast.Name) and kind.id == "BaseException"):
                wide = ast.Name("BaseException", ast.Load())
                yield "except widened", ast.ExceptHandler(wide, name, body)


def _condition_variants(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    match node:
        case (
            ast.If(test=ast.Compare() | ast.UnaryOp(op=ast.Not()))
            | ast.While(test=ast.Compare() | ast.UnaryOp(op=ast.Not()) | ast.Constant())
            | ast.IfExp(test=ast.Compare() | ast.UnaryOp(op=ast.Not()))
        ):
            return  # the comparison itself is negated
        case ast.If(test, body, orelse):
            yield "branch swapped", ast.If(ast.UnaryOp(ast.Not(), test), body, orelse)
        case ast.While(test, body, orelse):
            yield "branch swapped", ast.While(ast.UnaryOp(ast.Not(), test), body, orelse)
        case ast.IfExp(test, body, orelse):
            yield "branch swapped", ast.IfExp(test, orelse, body)


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str | bytes)
    )


def _is_none(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _has_value(target: ast.expr, known_names: frozenset[str]) -> bool:
    """Return whether the target has a value without the assignment."""
    match target:
        case ast.Name(name):
            return name in known_names
        case ast.Attribute() | ast.Subscript():
            return True
        case ast.Tuple(elements):
            return all(_has_value(element, known_names) for element in elements)
    return False
