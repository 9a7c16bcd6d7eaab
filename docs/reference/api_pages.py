#!/usr/bin/env python3
"""Writes what stands in this folder of the public API, from its source: three files.

    python docs/reference/api_pages.py docs/reference

The tables of `hooks.md` and `api.md`, below their marks, and `api.txt`: every public name with its
signature, so that a change of the API is seen as one in review. Nothing is imported.
"""

from __future__ import annotations

import ast
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

SOURCE = Path(__file__).resolve().parents[2] / "runner"
PLUGINS = SOURCE.parent / "plugins"
FACADE = SOURCE / "rigrunner/api/__init__.py"
"""Its names are those of its stub, defined in the modules beside it."""
MARK = "<!-- below: made by docs/reference/api_pages.py -->\n"
WIDTH = 100
LONGEST_VALUE = 60
Definition = ast.ClassDef | ast.FunctionDef | ast.Assign | ast.AnnAssign


@dataclass(frozen=True)
class Name:
    """A public name with where it is defined, and the docstring that follows it."""

    name: str
    node: Definition
    text: str

    @property
    def summary(self) -> str:
        """The first sentence of its docstring."""
        return first_sentence(self.text)


@dataclass(frozen=True)
class Module:
    """A module of the source."""

    path: Path

    @cached_property
    def tree(self) -> ast.Module:
        """Its syntax tree."""
        return ast.parse(self.path.read_text(encoding="utf-8"))

    @property
    def name(self) -> str:
        """How it is imported."""
        root = SOURCE if self.path.is_relative_to(SOURCE) else PLUGINS
        parts = self.path.relative_to(root).with_suffix("").parts
        return ".".join(part for part in parts if part != "__init__")

    @property
    def exported(self) -> list[str]:
        """What `__all__` lists."""
        for node in self.tree.body:
            if isinstance(node, ast.Assign) and _targets(node) == ["__all__"]:
                return list(ast.literal_eval(node.value))
        return []

    @property
    def names(self) -> list[Name]:
        """The public names that it defines, in its own order, or that it exports as a package."""
        if not self.exported:
            return list(defined(self.tree.body))
        inside = sorted(self.path.parent.rglob("*.py"))
        everywhere = [name for path in inside for name in defined(Module(path).tree.body)]
        by_name = {each.name: each for each in reversed(everywhere)}
        return [by_name[name] for name in self.exported]


def public_modules() -> list[Module]:
    """Return the modules of the three packages that have names.

    A package in them that has `__all__` stands for its modules.
    """
    core = (SOURCE / "rigrunner/api", SOURCE / "rigrunner/signal")
    folders = (*core, PLUGINS / "rigrunner_bearings/api")
    modules = [Module(path) for folder in folders for path in sorted(folder.rglob("*.py"))]
    packages = {module.path.parent for module in modules if module.exported}
    public = [
        module
        for module in modules
        if module.exported
        or not (module.path.name.startswith("_") or module.path.parent in packages)
    ]
    return [module for module in public if module.names]


def kit() -> tuple[Module, list[Name]]:
    """Return `rigrunner_testing`, and what it exports from wherever it is defined."""
    package = Module(SOURCE / "rigrunner_testing/__init__.py")
    return package, package.names


def facade() -> list[tuple[Module, Name]]:
    """Return what `rigrunner.api` itself gives, each with the module or package that defines it."""
    stub = ast.parse(FACADE.with_suffix(".pyi").read_text(encoding="utf-8"))
    where = {module.name: module for module in public_modules()}
    names = []
    for node in stub.body:
        if isinstance(node, ast.ImportFrom) and node.module:
            by_name = {each.name: each for each in where[node.module].names}
            names += [(where[node.module], by_name[alias.name]) for alias in node.names]
    return sorted(names, key=lambda each: each[1].name)


def defined(body: list[ast.stmt]) -> Iterator[Name]:
    """Yield the public names that statements define."""
    for node, after in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            if not node.name.startswith("_"):
                yield Name(node.name, node, ast.get_docstring(node) or "")
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            for target in _targets(node):
                if not target.startswith("_"):
                    yield Name(target, node, _string(after))


def first_sentence(text: str) -> str:
    """Return the first sentence of a docstring, on one line."""
    words = " ".join(text.partition("\n\n")[0].split())
    head, stop, _ = words.partition(". ")
    return head + "." if stop else words


def signatures(name: Name, prefix: str) -> Iterator[str]:
    """Yield one line for a name, and of a class one for each public member."""
    node, full = name.node, f"{prefix}{name.name}"
    if isinstance(node, ast.FunctionDef):
        yield f"{_decorators(node)}{full}{_arguments(node)}"
    elif isinstance(node, ast.ClassDef):
        bases = ", ".join(ast.unparse(each) for each in (*node.bases, *node.keywords))
        yield f"{_decorators(node)}class {full}({bases})"
        for member in node.body:
            if isinstance(member, ast.FunctionDef) and member.name in {"__init__", "__call__"}:
                yield f"{full}.{member.name}{_arguments(member)}"
        for member_name in defined(node.body):
            yield from signatures(member_name, f"{full}.")
    else:
        annotation = f": {ast.unparse(node.annotation)}" if isinstance(node, ast.AnnAssign) else ""
        value = f" = {_short(node.value)}" if node.value is not None else ""
        yield f"{full}{annotation}{value}"


def api_text() -> str:
    """Return the whole snapshot."""
    package, exported = kit()
    listed = [(module.name, module.names) for module in public_modules()]
    parts = ["\n".join(["# rigrunner.api", *(name.name for _, name in facade())])]
    for module, names in (*listed, (package.name, exported)):
        lines = [line for name in names for line in signatures(name, "")]
        parts.append("\n".join([f"# {module}", *lines]))
    return "\n\n".join(parts) + "\n"


def api_page() -> str:
    """Return the tables of the public names."""
    package, exported = kit()
    listed = [(module, module.names) for module in public_modules()]
    rows = [
        f"| `{name.name}` | {_cell(name.summary or _value(name.node))} | `{module.name}` |"
        for module, name in facade()
    ]
    head = "| name | what it is | defined in |\n|---|---|---|\n"
    return (
        f"## `rigrunner.api`\n\n{head}"
        + "\n".join(rows)
        + "\n\n"
        + "\n".join(
            f"## `{module.name}`\n\n{_intro(module)}\n\n{_table(names)}"
            for module, names in (*listed, (package, exported))
        )
    )


def hooks_page() -> str:
    """Return the list of hooks, and the fields of each record."""
    names = {name.name: name for name in Module(SOURCE / "rigrunner/api/hooks.py").names}
    specs = names["HookSpecs"].node
    assert isinstance(specs, ast.ClassDef)  # noqa: S101  (it is one)
    hooks = [(hook, record_of(hook.node)) for hook in defined(specs.body)]
    rows = [
        f"| `{hook.name}` | [`{record}`](#{record.lower()}) | {names[record].summary} |"
        for hook, record in hooks
    ]
    head = "| hook | record | what it is |\n|---|---|---|\n"
    records = ["PluginRecord", *(record for _, record in hooks)]
    sections = [f"## {record}\n\n{_record(names[record])}" for record in records]
    return head + "\n".join(rows) + "\n\n" + "\n".join(sections)


def record_of(hook: Definition) -> str:
    """Return the record that a hook's annotation names: Iterable[DeviceRecord]."""
    returns = hook.returns if isinstance(hook, ast.FunctionDef) else None
    assert isinstance(returns, ast.Subscript)  # noqa: S101  (every hook returns records)
    return ast.unparse(returns.slice)


def written(page: Path, made: str) -> None:
    """Replace what stands below the mark of a page."""
    head, mark, _ = page.read_text(encoding="utf-8").partition(MARK)
    if not mark:
        raise SystemExit(f"{page} has no line {MARK.strip()}")
    page.write_text(f"{head}{mark}\n{made}", encoding="utf-8")


def _record(record: Name) -> str:
    node = record.node
    assert isinstance(node, ast.ClassDef)  # noqa: S101  (a record is one)
    rows = [
        f"| `{each.name}` | `{_cell(ast.unparse(each.node.annotation))}` |"
        f" {_default(each.node)} | {_cell(each.text)} |"
        for each in defined(node.body)
        if isinstance(each.node, ast.AnnAssign)
    ]
    head = "| field | type | default | what it is |\n|---|---|---|---|\n"
    return f"{_paragraphs(record.text)}\n\n{head}" + "\n".join(rows) + "\n"


def _default(node: ast.AnnAssign) -> str:
    if node.value is None:
        return "required"
    if isinstance(node.value, ast.Call) and ast.unparse(node.value.func) == "field":
        return "empty"
    return f"`{ast.unparse(node.value)}`"


def _intro(module: Module) -> str:
    text = ast.get_docstring(module.tree) or ""
    return _paragraphs(text.partition("\n\n")[0])


def _paragraphs(text: str) -> str:
    return "\n\n".join(" ".join(part.split()) for part in text.split("\n\n"))


def _table(names: list[Name]) -> str:
    rows = [f"| `{_head(name)}` | {_cell(name.summary or _value(name.node))} |" for name in names]
    return "| name | what it is |\n|---|---|\n" + "\n".join(rows) + "\n"


def _head(name: Name) -> str:
    if not isinstance(name.node, ast.FunctionDef):
        return name.name
    arguments = name.node.args
    named = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    return f"{name.name}({', '.join(each.arg for each in named)})"


def _value(node: Definition) -> str:
    value = node.value if isinstance(node, ast.Assign | ast.AnnAssign) else None
    return f"`{_short(value)}`" if value is not None else ""


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _short(node: ast.expr) -> str:
    text = ast.unparse(node)
    return text if len(text) <= LONGEST_VALUE else f"{text[: LONGEST_VALUE - 3]}..."


def _arguments(node: ast.FunctionDef) -> str:
    returns = f" -> {ast.unparse(node.returns)}" if node.returns is not None else ""
    return f"({ast.unparse(node.args)}){returns}"


def _decorators(node: ast.ClassDef | ast.FunctionDef) -> str:
    return "".join(f"@{ast.unparse(each)} " for each in node.decorator_list)


def _targets(node: ast.Assign | ast.AnnAssign) -> list[str]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    return [each.id for each in targets if isinstance(each, ast.Name)]


def _string(node: ast.stmt | None) -> str:
    """Return the docstring that a statement is, if it is one."""
    if not isinstance(node, ast.Expr) or not isinstance(node.value, ast.Constant):
        return ""
    return node.value.value if isinstance(node.value.value, str) else ""


def main(folder: Path) -> None:
    """Write the three files."""
    written(folder / "hooks.md", hooks_page())
    written(folder / "api.md", api_page())
    (folder / "api.txt").write_text(api_text(), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
