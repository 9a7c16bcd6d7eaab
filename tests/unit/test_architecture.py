"""The architecture page matches the code."""

from __future__ import annotations

import ast
import re
import runpy
import tomllib
from itertools import pairwise
from xml.etree import ElementTree as ET

import pytest

from helpers_docs import ROOT

DOCS = ROOT / "docs"
REGENERATE = "python docs/images/architecture.py docs"
made = runpy.run_path(str(DOCS / "images/architecture.py"))
OF_BEARINGS = re.compile(r"swing|bearing|crank|no.load|compensation", re.IGNORECASE)
NAMES_BEARINGS = {
    "analysis/document.py": "keys of result/1, which every document of that format has",
    "api/partner_keys.py": "two partner runs have keys of their own in result/1",
    "api/certificate/evidence.py": "fields of certificates of 0.1.0",
    "api/certificate/method.py": "fields of certificates of 0.1.0",
    "api/certificate/results.py": "fields of certificates of 0.1.0",
    "certificate/content.py": "fills the fields of certificates of 0.1.0",
    "yamlfile/upgrade.py": "procedures of 0.1.0 have one analysis without a name",
}
"""Modules of the core that use words of bearings, each with its reason."""
OF_TORQUE = re.compile(r"(?<!tester[._])(?<!press\.)torque", re.IGNORECASE)
"""Except channels in examples: 'tester.torque', 'press.torque', in a file 'tester_torque'."""
FROM = re.compile(r"^ *from ([\w.]+) import (\([^)]*\)|.*)$", re.MULTILINE)
NAMES_TORQUE = {
    "api/__init__.py": "a field with a unit of torque",
    "api/calibration.py": "the register: a range of torque without `min` is symmetrical",
    "api/certificate/conformity.py": "fields of certificates of 0.1.0",
    "api/certificate/results.py": "fields of certificates of 0.1.0",
    "api/instruments.py": "the register: an entry without `measures` is of torque",
    "api/settings.py": "a field with a unit of torque",
    "api/unit_tables.py": "units of torque",
    "api/units.py": "units of torque",
    "documents/verifying/pages.py": "fields of certificates of 0.1.0",
    "yamlfile/upgrade.py": "procedures of 0.1.0 have limits of torque alone",
    "yamlfile/upgrade_register.py": "registers of 0.1.0 have keys of torque transducers alone",
}
"""Modules of the core that name torque, each with its reason."""


@pytest.mark.thorough
def test_drawing_matches_the_code():
    drawn = (DOCS / "images/architecture.svg").read_text(encoding="utf-8")
    assert drawn == made["drawing"](), REGENERATE


def test_no_line_of_the_drawing_crosses_a_box():
    boxes = made["_places"](made["layers"]())
    lines = made["arrows"](made["packages"]())
    hidden = [
        (line, name)
        for line, way in made["_routes"](boxes, lines).items()
        for x, top in way
        for name, (left, y, width) in boxes.items()
        if y == top and left <= x <= left + width
    ]
    assert hidden == []


def test_table_matches_the_code():
    text = (DOCS / "architecture.md").read_text(encoding="utf-8")
    assert text == made["page"](text), REGENERATE


def test_every_package_has_a_box_and_no_arrow_points_up():
    layer_of = {name: row for row, names in enumerate(made["layers"]()) for name in names}
    packages = {path.stem for path in (ROOT / "runner/rigrunner").glob("*.py")} | {
        path.parent.name for path in (ROOT / "runner/rigrunner").glob("*/__init__.py")
    }
    packages |= {path.parent.name for path in (ROOT / "runner").glob("rigrunner_*/__init__.py")}
    assert set(layer_of) == packages - {"__init__"}
    arrows = made["arrows"](made["packages"]())
    for start, end in arrows:
        if end in made["PLUGINS"]:
            continue
        assert layer_of.get(start, -1) <= layer_of[end], (start, end)
        assert (end, start) not in arrows


def test_plugins_and_reports_may_import_only_api_signal_and_plots():
    rules = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    forbidden = next(
        set(contract["forbidden_modules"])
        for contract in rules["importlinter"]["contracts"]
        if contract["name"].endswith("only rigrunner.api, rigrunner.signal and rigrunner.plots")
    )
    modules = {
        name if name.startswith("rigrunner_") else f"rigrunner.{name}"
        for row in made["layers"]()
        for name in row
    }
    used = {"rigrunner.api", "rigrunner.signal", "rigrunner.plots"}
    assert forbidden == modules - used - {"rigrunner.moved"}  # which the first two import


def test_arrows_cover_exactly_the_imports():
    parts = made["packages"]()
    arrows = made["arrows"](parts)

    def reached(name, without=None):
        reachable, pending = set(), [name]
        while pending:
            package = pending.pop()
            for start, end in arrows:
                if start == package and (start, end) != without and end not in reachable:
                    reachable.add(end)
                    pending.append(end)
        return reachable

    for name, part in parts.items():
        assert part.imports <= reached(name)
    for start, end in arrows:
        assert end not in reached(start, without=(start, end)), "it follows from others"


def test_imports_are_read_as_python_reads_them(tmp_path):
    (tmp_path / "part.py").write_text(
        "import rigrunner.engine\nfrom rigrunner.plan import a\nfrom rigrunner import rig\n"
        "from rigrunner import __version__\nimport numpy\n"
        "def late():\n    from rigrunner_panel.web import b\n"
    )
    part = made["Package"]("part", tmp_path / "part")
    assert part.imports == {"engine", "plan", "rig", "rigrunner_panel"}


def test_packages_export_only_what_others_use():
    """Except `api`, the kit and notebooks: their users are plugins and notebooks of others."""
    public = ("rigrunner.api", "rigrunner_testing", "rigrunner_fleet.notebook")
    used, handed_out = set(), {}
    for folder in ("runner", "plugins", "reports", "tests"):
        for path in (ROOT / folder).rglob("*.py"):
            package = ".".join(path.relative_to(ROOT / folder).parent.parts)
            text = re.sub(r" #.*", "", path.read_text(encoding="utf-8"))
            for module, names in FROM.findall(text):
                if module != package:
                    used |= {(module, name) for name in re.findall(r"(?<! as )\b\w+", names)}
            if path.stem == "__init__" and "\n__all__ = " in text:
                (listed,) = (
                    node.value
                    for node in ast.parse(text).body
                    if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
                )
                handed_out[package] = ast.literal_eval(listed)
    assert "rigrunner.runfile" in handed_out
    assert [
        f"{package}.{name}"
        for package, names in handed_out.items()
        for name in names
        if not package.startswith(public) and (package, name) not in used
    ] == []


def test_every_suppressed_check_states_its_reason():
    """In brackets after a `noqa`, as a comment after a `type: ignore`."""
    unexplained = re.compile(
        r"# noqa: [A-Z0-9, ]+$|# noqa(?!: [A-Z])|# type: ignore(\[[a-z-, ]+\])?$"
    )
    sources = [
        path
        for folder in ("runner", "plugins", "reports")
        for path in (ROOT / folder).rglob("*.py")
    ]
    found_lines = [
        f"{path.relative_to(ROOT)}:{number}"
        for path in sources
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if unexplained.search(line.rstrip())
    ]
    assert len(sources) > 500
    assert found_lines == []


def test_packages_are_listed_with_their_imports():
    rows = made["subpackages_table"]().splitlines()
    jobs = next(row for row in rows if row.startswith("| `rigrunner_panel.jobs` |"))
    assert jobs.endswith("| `process`, `view` |")
    assert any(row.startswith("| `rigrunner_plugins.devices.visa` |") for row in rows)


def test_the_drawing_has_a_box_for_each_package():
    root = ET.fromstring(made["drawing"]())  # noqa: S314  (generated just now)
    texts = {text.text for text in root.iter("{http://www.w3.org/2000/svg}text")}
    assert set(made["packages"]()) <= texts


def test_no_box_hides_another():
    boxes = made["_places"](made["layers"]())
    rows = {}
    for left, top, width in boxes.values():
        rows.setdefault(top, []).append((left, left + width))
    for row in map(sorted, rows.values()):
        assert all(end < begin for (_, end), (begin, _) in pairwise(row))


def test_page_without_the_marker_is_refused():
    with pytest.raises(SystemExit, match="has no line"):
        made["page"]("# Architecture\n")


@pytest.mark.parametrize(
    ("words", "reasons"), [(OF_BEARINGS, NAMES_BEARINGS), (OF_TORQUE, NAMES_TORQUE)]
)
def test_core_does_not_use_words_of_bearings(words, reasons):
    core = ROOT / "runner/rigrunner"
    modules = {
        path.relative_to(core).as_posix()
        for path in core.rglob("*.py")
        if words.search(path.read_text(encoding="utf-8"))
    }
    assert modules == set(reasons), "use another example, or move it to the bearings"
