"""The public API: its pages match the source, every name is explained, every hook is used."""

from __future__ import annotations

import ast
import importlib.util
import re
import shutil
import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest

from helpers_docs import ROOT
from rigrunner import api
from rigrunner.api.hooks import API_VERSION, OLDEST_API_VERSION, HookSpecs
from rigrunner.registry import Registry, load_registry

PAGES = ROOT / "docs/reference"
HOOKS = [name for name in vars(HookSpecs) if name.startswith("rigrunner_")]
REGENERATE = "python docs/reference/api_pages.py docs/reference"


@pytest.fixture(scope="module")
def api_pages():
    spec = importlib.util.spec_from_file_location("api_pages", PAGES / "api_pages.py")
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "api_pages", module)  # its dataclasses look there
        spec.loader.exec_module(module)
        yield module


@pytest.fixture(scope="module")
def generated(api_pages, tmp_path_factory):
    folder = tmp_path_factory.mktemp("reference")
    for name in ("hooks.md", "api.md"):
        shutil.copy(PAGES / name, folder)
    api_pages.main(folder)
    return folder


@pytest.mark.parametrize("name", ["hooks.md", "api.md", "api.txt"])
def test_pages_match_the_source(generated, name):
    """The API changed? Decide by docs/reference/api.md whether API_VERSION is raised."""
    made, committed = ((folder / name).read_text("utf-8") for folder in (generated, PAGES))
    differing = sorted(set(made.splitlines()) ^ set(committed.splitlines()))
    assert made == committed, f"'{REGENERATE}' writes it; lines that differ: {differing}"


@pytest.mark.parametrize("name", ["hooks.md", "api.md"])
def test_every_public_name_is_explained(name):
    unexplained = [
        line for line in (PAGES / name).read_text("utf-8").splitlines() if line.endswith("|  |")
    ]
    assert unexplained == []


def test_snapshot_has_all_signatures(api_pages):
    source = (
        "LIMIT: float = 2.0\n"
        "_hidden = 1\n"
        "from x import imported\n"
        "@dataclass(frozen=True)\n"
        "class Press(Driver):\n"
        "    force_n: float\n"
        "    _own: int = 0\n"
        "    def __init__(self, force_n: float) -> None: ...\n"
        "    @property\n"
        "    def safe(self) -> bool: ...\n"
        "    def push(self, *, hard: bool = True) -> None: ...\n"
        "def load(path: Path, /, *names: str) -> Press: ...\n"
    )
    names = api_pages.defined(ast.parse(source).body)
    assert [line for name in names for line in api_pages.signatures(name, "")] == [
        "LIMIT: float = 2.0",
        "@dataclass(frozen=True) class Press(Driver)",
        "Press.__init__(self, force_n: float) -> None",
        "Press.force_n: float",
        "@property Press.safe(self) -> bool",
        "Press.push(self, *, hard: bool=True) -> None",
        "load(path: Path, /, *names: str) -> Press",
    ]


def test_all_public_names_can_be_imported(api_pages):
    package, exported = api_pages.kit()
    everything = {module.name: module.names for module in api_pages.public_modules()}
    for module, names in (everything | {package.name: exported}).items():
        imported = importlib.import_module(module)
        assert [name.name for name in names if not hasattr(imported, name.name)] == [], module
    assert {"rigrunner.api.hooks", "rigrunner.signal.blocks"} <= set(everything)
    assert exported


def test_facade_matches_its_stub():
    stub = ast.parse((ROOT / "runner/rigrunner/api/__init__.pyi").read_text("utf-8"))
    declared = {
        alias.name: node.module
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert sorted(declared) == api.__all__ == sorted(set(api.__all__))
    for name, module in declared.items():
        assert getattr(api, name) is getattr(importlib.import_module(module), name), name
    assert set(api.__all__) <= set(dir(api))
    with pytest.raises(AttributeError, match="has no attribute 'Setings'"):
        _ = api.Setings
    with pytest.raises(ImportError, match="cannot import name 'Setings'"):
        exec("from rigrunner.api import Setings")  # noqa: S102  (what an author may type)


def test_importing_from_the_facade_loads_no_numpy():
    declared = "from rigrunner.api import ChannelInfo, DeviceRecord, Driver, Settings, hookimpl"
    loaded = (
        "import sys, rigrunner.api;"
        "assert not [m for m in sys.modules if m.startswith('rigrunner.api.')];"
        f"{declared}; assert 'numpy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", loaded], check=True)


DEEPER = re.compile(r"^\s*(?:from|import) rigrunner\.api\.\w+.*$", re.MULTILINE)
TOOLS = "runner/rigrunner/tools"
OF_AUTHORS = [
    path
    for pattern in (
        *(f"{TOOLS}/plugin_template/**/*.jinja", "plugins/rigrunner_bearings/lab/**/*.py"),
        "plugins/rigrunner_bearings/plugin_template/*.jinja",
        *("docs/how-to/*.md", "docs/tutorial/*.md", "tests/e2e/stranger/*.py"),
    )
    for path in sorted(ROOT.glob(pattern))
]


def test_examples_for_authors_import_only_the_facade():
    deeper = {
        path.name: imports
        for path in OF_AUTHORS
        if (imports := DEEPER.findall(path.read_text("utf-8")))
    }
    assert deeper == {}
    assert {"device.py.jinja", "__init__.py", "write-a-device-plugin.md"} <= {
        path.name for path in OF_AUTHORS
    }


def test_shipped_plugins_import_facade_names_from_the_facade():
    deeper = [
        f"{path}: {alias.name}"
        for folder in ("plugins", "reports")
        for path in sorted((ROOT / folder).rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("rigrunner.api.")
        for alias in node.names
        if alias.name in api.__all__
        and getattr(api, alias.name) is getattr(importlib.import_module(node.module), alias.name)
    ]
    assert deeper == []


def test_each_hook_belongs_to_one_kind():
    assert sorted(kind.hook for kind in Registry([]).kinds) == sorted(HOOKS)


def test_each_hook_is_documented_with_its_record():
    text = (PAGES / "hooks.md").read_text("utf-8")
    rows = re.findall(r"^\| `(rigrunner_\w+)` \| \[`(\w+)`\]", text, re.MULTILINE)
    assert [hook for hook, _ in rows] == HOOKS
    assert set(re.findall(r"^## (\w+)$", text, re.MULTILINE)) == {
        "PluginRecord", *(record for _, record in rows)
    }  # fmt: skip


def test_each_hook_is_implemented_by_a_plugin(monkeypatch):
    """A shipped one, or the stranger's plugin in the tests."""
    monkeypatch.syspath_prepend(str(ROOT / "tests/e2e"))
    ours = load_registry()
    stranger = EntryPoint("stranger", "stranger", "rigrunner")
    bearings = EntryPoint("rigrunner_bearings", "rigrunner_bearings.hooks", "rigrunner")
    strangers = load_registry([bearings, stranger])
    assert strangers.disabled == ()
    kinds, only_ours = {kind.name for kind in ours.kinds}, {"kind", "lab", "step"}
    stranger_kinds = {
        plugin.kind for plugin in strangers.plugins if plugin.provider.name == "stranger"
    }
    assert stranger_kinds == kinds - only_ours
    assert only_ours <= {plugin.kind for plugin in ours.plugins}
    assert kinds - {plugin.kind for plugin in ours.plugins} <= {"event_sink", "unit"}


def test_oldest_api_version_is_not_newer():
    assert 1 <= OLDEST_API_VERSION <= API_VERSION
