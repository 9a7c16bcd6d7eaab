"""Measures of the structure of a package, counted from its source, to compare packages.

    python tests/benchmarks/structure.py FOLDER [FOLDER ...]

It prints a row of a Markdown table for each folder with Python files:

- lines and files;
- the share of functions and methods that are private (`_name`) and used in only one place;
- modules under 100 lines that only one module imports, a sibling in the same folder;
- the share of lines that are imports, and that are comments.
"""

from __future__ import annotations

import ast
import io
import sys
import tokenize
from collections import Counter, defaultdict
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

SMALL = 100
HEAD = (
    "| package | lines | files | private, used once | small modules for one sibling |"
    " import lines | comment lines |\n|---|---:|---:|---:|---:|---:|---:|"
)


@dataclass(frozen=True)
class Module:
    """A file of a package."""

    name: str
    """Dotted, with the package."""
    text: str
    is_package: bool

    @cached_property
    def tree(self) -> ast.Module:
        """Its syntax tree."""
        return ast.parse(self.text)

    @property
    def lines(self) -> int:
        """Number of lines."""
        return len(self.text.splitlines())

    @property
    def folder(self) -> str:
        """The package that it is in."""
        return self.name if self.is_package else self.name.rpartition(".")[0]

    @cached_property
    def imported(self) -> set[str]:
        """The dotted names that it imports: modules and their members."""
        names: set[str] = set()
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                start = node.module or ""
                if node.level:
                    above = self.folder.split(".")[: len(self.folder.split(".")) - node.level + 1]
                    start = ".".join([*above, *([start] if start else [])])
                names |= {start, *(f"{start}.{alias.name}" for alias in node.names)}
        return names

    @property
    def import_lines(self) -> int:
        """Number of lines of import statements."""
        nodes = (
            node for node in ast.walk(self.tree) if isinstance(node, ast.Import | ast.ImportFrom)
        )
        return sum((node.end_lineno or node.lineno) - node.lineno + 1 for node in nodes)

    @property
    def comment_lines(self) -> int:
        """Number of lines with a comment, except marks for tools."""
        tokens = tokenize.generate_tokens(io.StringIO(self.text).readline)
        comments = (token.string.lstrip("# ") for token in tokens if token.type == tokenize.COMMENT)
        return sum(not comment.startswith(("noqa", "type: ", "pragma")) for comment in comments)

    @property
    def functions(self) -> tuple[int, int]:
        """Numbers of functions and methods, and of private ones used in only one place."""
        kinds = ast.FunctionDef | ast.AsyncFunctionDef
        names = [node.name for node in ast.walk(self.tree) if isinstance(node, kinds)]
        private = {name for name in names if name.startswith("_") and not name.startswith("__")}
        uses = Counter(
            node.id if isinstance(node, ast.Name) else node.attr
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Name | ast.Attribute)
        )
        return len(names), sum(uses[name] == 1 for name in private)


def modules_of(folder: Path) -> list[Module]:
    """Return the modules of a package."""
    modules = []
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(folder.parent).with_suffix("").parts
        is_package = parts[-1] == "__init__"
        name = ".".join(parts[:-1] if is_package else parts)
        modules.append(Module(name, path.read_text(encoding="utf-8"), is_package))
    return modules


def for_one_sibling(modules: list[Module]) -> int:
    """Return the number of small modules imported by only one module, of the same folder."""
    importers: dict[str, list[Module]] = defaultdict(list)
    names = {module.name for module in modules}
    for module in modules:
        for name in module.imported & names - {module.name}:
            importers[name].append(module)
    return sum(
        not module.is_package
        and module.lines < SMALL
        and [importer.folder for importer in importers[module.name]] == [module.folder]
        for module in modules
    )


def row(folder: Path) -> str:
    """Return the row of a package."""
    modules = modules_of(folder)
    lines = sum(module.lines for module in modules)
    functions = sum(module.functions[0] for module in modules)
    once = sum(module.functions[1] for module in modules)
    shares = (
        once / functions,
        sum(module.import_lines for module in modules) / lines,
        sum(module.comment_lines for module in modules) / lines,
    )
    private, imports, comments = (f"{share:.1%}" for share in shares)
    cells = (
        folder.name,
        f"{lines:,}",
        len(modules),
        private,
        for_one_sibling(modules),
        imports,
        comments,
    )
    return f"| {' | '.join(map(str, cells))} |"


def main(folders: list[str]) -> None:
    """Print the table."""
    sys.stdout.write("\n".join([HEAD, *(row(Path(folder)) for folder in folders)]) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
