#!/usr/bin/env python3
"""Draws the layers of Rigrunner, and lists its packages, from the code itself.

    python docs/images/architecture.py docs

The layers are those of the import contracts in `pyproject.toml`, the arrows the imports in the
source. It writes `images/architecture.svg`, and the tables in `architecture.md` below the mark.
"""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from dataclasses import dataclass
from functools import cache, cached_property
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[2]
OURS = ROOT / "runner/rigrunner"
PLUGINS = {
    "rigrunner_bearings": ROOT / "plugins/rigrunner_bearings",
    "rigrunner_plugins": ROOT / "plugins/rigrunner_plugins",
    "rigrunner_reports": ROOT / "reports/rigrunner_reports",
}
ABOVE = "rigrunner_"
"""The prefix of the packages that build on the core."""
MARK = "<!-- below: made by docs/images/architecture.py -->\n"
SUBPACKAGES = "## Subpackages\n"
WIDTH, BAND, BOX, LEFT = 1180, 78, 34, 16
PLUGINS_X = 1000  # where the column of plugins and reports begins
INSIDE = PLUGINS_X - 40 - LEFT
ASIDE = {
    "tape": 0.19, "engine": 0.24, "procedure": 0.3, "station": 0.13, "interlock": 0.13,
    "spreadsheet": 0.08, "signal": 0.245, "ending": 0.41, "hdf5_reading": 0.59, "blas": 0.755,
    "printable": 0.92,
}  # fmt: skip
"""Horizontal place of boxes that would hide lines in the middle; others share a layer evenly."""
GAP, LANE = 24, 7  # between the boxes of a layer, and between lines that pass there
Boxes = dict[str, tuple[float, float, float]]
Line = tuple[str, str]
INK, LINE, FILL, BAND_FILL, PLUGIN_FILL = "#1f2933", "#7b8794", "#ffffff", "#f0f4f8", "#fff7e6"


@dataclass(frozen=True)
class Package:
    """A package, or a top-level module, of a layer."""

    name: str
    path: Path

    @cached_property
    def files(self) -> list[Path]:
        """Its modules."""
        single = self.path.with_suffix(".py")
        return [single] if single.exists() else sorted(self.path.rglob("*.py"))

    @property
    def summary(self) -> str:
        """The first line of its docstring."""
        start = next(path for path in self.files if path.stem in {"__init__", self.name})
        return _summary(start)

    @cached_property
    def imports(self) -> set[str]:
        """The parts of rigrunner that it imports, without itself."""
        return {part for path in self.files for part in _imported(path)} - {self.name}


def layers() -> list[list[str]]:
    """Return the layers of the contracts, the top first: packages on the core, and the core's."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    lists = (
        contract["layers"]
        for contract in contracts
        if contract["type"] == "layers"
        and ("containers" in contract or OURS.name in contract["layers"])
    )
    return [
        re.split(r" [:|] ", layer) for names in lists for layer in names if layer != "rigrunner"
    ]


def packages() -> dict[str, Package]:
    """Return all parts of rigrunner by name, and the plugins and reports that ship."""
    own = {
        name: Package(name, (OURS.parent if name.startswith(ABOVE) else OURS) / name)
        for layer in layers()
        for name in layer
    }
    return own | {name: Package(name, path) for name, path in PLUGINS.items()}


def arrows(parts: dict[str, Package]) -> list[tuple[str, str]]:
    """Return who imports whom, without what follows: a to c, where a to b to c leads there too."""
    below: dict[str, set[str]] = {}

    def reach(name: str) -> set[str]:
        if name not in below:
            imports = parts[name].imports
            below[name] = imports.union(*map(reach, imports))
        return below[name]

    return [
        (name, target)
        for name, part in parts.items()
        for target in sorted(part.imports)
        if not any(target in reach(other) for other in part.imports - {target})
    ]


def drawing() -> str:
    """Return the SVG."""
    parts, rows = packages(), layers()
    boxes = _places(rows)
    lines = arrows(parts)
    height = BAND * len(rows) + 16
    body = [
        f'<rect x="{LEFT}" y="{16 + BAND * row}" width="{INSIDE}" height="{BOX + 16}" rx="8"'
        f' fill="{BAND_FILL}"/>'
        for row in range(len(rows))
    ]
    routes = _routes(boxes, lines)
    body += [_arrow(boxes, lines, each, routes[each]) for each in lines]
    body += [_box(parts[name], place) for name, place in boxes.items()]
    body.append(_plugins_caption(boxes))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}"'
        f' font-family="sans-serif" role="img">\n<title>The layers of Rigrunner</title>\n'
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7"'
        f' markerHeight="7" orient="auto"><path d="M0 0 8 4 0 8z" fill="{LINE}"/></marker></defs>\n'
        f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>\n'
        + "\n".join(body)
        + "\n</svg>\n"
    )


def table() -> str:
    """Return the table of all packages, the top layer first."""
    lines = ["| package | what it is | imports |", "|---|---|---|"]
    for name, part in packages().items():
        imports = ", ".join(f"`{each}`" for each in sorted(part.imports)) or "none"
        lines.append(f"| `{name}` | {part.summary} | {imports} |")
    return "\n".join(lines) + "\n"


def subpackages_table() -> str:
    """Return the table of all subpackages, each with the siblings that it imports."""
    lines = ["| subpackage | what it is | imports beside it |", "|---|---|---|"]
    for part in packages().values():
        for start in part.files:
            if start.stem == "__init__" and start.parent != part.path:
                imports = ", ".join(f"`{each}`" for each in _siblings(start.parent)) or "none"
                lines.append(f"| `{_dotted(start.parent, part)}` | {_summary(start)} | {imports} |")
    return "\n".join(lines) + "\n"


def page(text: str) -> str:
    """Return the page with its tables made again."""
    head, mark, _ = text.partition(MARK)
    if not mark:
        raise SystemExit(f"the page has no line {MARK.strip()}")
    return f"{head}{mark}\n{table()}\n{SUBPACKAGES}\n{subpackages_table()}"


def _dotted(subpackage: Path, part: Package) -> str:
    return ".".join((part.name, *subpackage.relative_to(part.path).parts))


def _siblings(subpackage: Path) -> list[str]:
    """Return the names of the subpackages of the same parent that a subpackage imports."""
    root = next(
        each
        for each in (OURS.parent, ROOT / "plugins", ROOT / "reports")
        if subpackage.is_relative_to(each)
    )
    parent = ".".join(subpackage.parent.relative_to(root).parts) + "."
    beside = {each.parent.name for each in subpackage.parent.glob("*/__init__.py")} - {
        subpackage.name
    }
    used = {
        name.removeprefix(parent).split(".")[0]
        for path in subpackage.rglob("*.py")
        for name in _names(path)
        if name.startswith(parent)
    }
    return sorted(used & beside)


def _summary(path: Path) -> str:
    """Return the first line of a module's docstring."""
    return (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").partition("\n")[0]


def _imported(path: Path) -> set[str]:
    names = [name.split(".") for name in _names(path) if name.startswith("rigrunner")]
    parts = {name[0] if name[0].startswith(ABOVE) else name[1] for name in names if len(name) > 1}
    return {part for part in parts if not part.startswith("__v")}  # __version__ is a text


@cache
def _names(path: Path) -> set[str]:
    """Return the dotted names of what a module imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module == "rigrunner":
            names |= {f"rigrunner.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
    return names


def _places(rows: list[list[str]]) -> Boxes:
    """Return left, top and width of each box."""
    places: Boxes = {}
    for row, names in enumerate(rows):
        step = INSIDE / len(names)
        width = min(step - GAP, 150)
        for column, name in enumerate(names):
            middle = INSIDE * ASIDE[name] if name in ASIDE else step * (column + 0.5)
            places[name] = (LEFT + middle - width / 2, 24 + BAND * row, width)
    for row, name in enumerate(PLUGINS, len(rows) - 5):
        places[name] = (PLUGINS_X, 24 + BAND * row, WIDTH - PLUGINS_X - 16)
    return places


def _ends(boxes: Boxes, lines: list[Line], line: Line) -> tuple[float, float]:
    """Return where a line leaves its box, and where it reaches the other."""
    start, end = line
    first = _port(boxes, start, [e for s, e in lines if s == start], end)
    return first, _port(boxes, end, [s for s, e in lines if e == end], start)


def _routes(boxes: Boxes, lines: list[Line]) -> dict[Line, list[tuple[float, float]]]:
    """Return x and y where each line passes a layer between its ends: beside boxes."""
    tops = sorted({top for _, top, _ in boxes.values()})
    taken: dict[float, list[float]] = {top: [] for top in tops}
    routes: dict[Line, list[tuple[float, float]]] = {}
    for line in sorted(lines, key=lambda each: (boxes[each[1]][1] - boxes[each[0]][1], each)):
        x, x2 = _ends(boxes, lines, line)
        between = [top for top in tops if boxes[line[0]][1] < top < boxes[line[1]][1]]
        routes[line] = []
        for left, top in zip(range(len(between), 0, -1), between, strict=True):
            free = _free(boxes, top, taken[top])
            x = min(free, key=lambda each: abs(each - x - (x2 - x) / (left + 1)))
            taken[top].append(x)
            routes[line].append((x, top))
    return routes


def _free(boxes: Boxes, top: float, taken: list[float]) -> list[float]:
    """Return where a layer has room for one more line."""
    here = [(left - 5, left + width + 5) for left, y, width in boxes.values() if y == top]
    return [
        x
        for x in range(LEFT, PLUGINS_X - 20, 2)
        if not any(first < x < last for first, last in here)
        and all(abs(x - other) > LANE for other in taken)
    ]


def _arrow(boxes: Boxes, lines: list[Line], line: Line, route: list[tuple[float, float]]) -> str:
    start, end = line
    x1, x2 = _ends(boxes, lines, line)
    y1, y2 = boxes[start][1] + BOX, boxes[end][1] - 1
    path = f"M{x1:.1f} {y1:.1f}"
    if boxes[start][1] == boxes[end][1]:  # a neighbour: below both boxes
        path += f"C{x1:.1f} {y1 + 24:.1f} {x2:.1f} {y1 + 24:.1f} {x2:.1f} {y1 + 1:.1f}"
    else:
        for x, y in [*route, (x2, y2)]:
            middle = (y1 + y) / 2
            path += f"C{x1:.1f} {middle:.1f} {x:.1f} {middle:.1f} {x:.1f} {y:.1f}"
            x1, y1 = x, y + BOX
            path += f"V{y1:.1f}" if y != y2 else ""
    how = f'fill="none" stroke="{LINE}" stroke-width="1.3" marker-end="url(#tip)"'
    return f'<path d="{path}" {how}/>'


def _port(boxes: Boxes, name: str, others: list[str], other: str) -> float:
    """Return where on a box's edge the line to another box ends: side by side, as those stand."""
    others = sorted(others, key=lambda each: boxes[each][0])
    left, _, width = boxes[name]
    return left + width * (others.index(other) + 1) / (len(others) + 1)


def _box(part: Package, place: tuple[float, float, float]) -> str:
    left, top, width = place
    fill = PLUGIN_FILL if part.name in PLUGINS else FILL
    return (
        f'<g><title>{escape(part.summary)}</title><rect x="{left:.1f}" y="{top}"'
        f' width="{width:.1f}" height="{BOX}" rx="5" fill="{fill}" stroke="{INK}"/>'
        f'<text x="{left + width / 2:.1f}" y="{top + 22}" text-anchor="middle" font-size="15"'
        f' font-weight="600" fill="{INK}">{part.name}</text></g>'
    )


def _plugins_caption(boxes: Boxes) -> str:
    """Return the caption above the plugins: how they are found."""
    left, top, width = boxes[next(iter(PLUGINS))]
    middle = left + width / 2
    return "\n".join(
        f'<text x="{middle:.1f}" y="{top - 34 + 16 * row}" text-anchor="middle" font-size="12"'
        f' fill="{INK}">{text}</text>'
        for row, text in enumerate(("found by the registry,", "through entry points:"))
    )


def main(folder: Path) -> None:
    """Write the drawing and the table."""
    (folder / "images/architecture.svg").write_text(drawing(), encoding="utf-8")
    text = (folder / "architecture.md").read_text(encoding="utf-8")
    (folder / "architecture.md").write_text(page(text), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
