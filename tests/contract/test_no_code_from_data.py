"""Data are never code: no shipped module can execute a file's content or use a network."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted(
    path for folder in ("runner", "plugins", "reports") for path in (ROOT / folder).rglob("*.py")
)
UNPICKLERS = {
    "pickle",
    "cPickle",
    "marshal",
    "shelve",
    "dill",
    "cloudpickle",
    "joblib",
    "jsonpickle",
}
NETWORK = {
    "socket", "ssl", "http", "urllib", "ftplib", "smtplib", "xmlrpc", "requests", "httpx",
    "aiohttp",
}  # fmt: skip
KNOWN = {
    "runner/rigrunner_panel/process/channel.py": {"pickle"},
    "runner/rigrunner_panel/serve.py": {"socket"},
    "runner/rigrunner_panel/web/security.py": {"socket"},
    "plugins/rigrunner_plugins/devices/modbus/opening.py": {"socket"},
    "runner/rigrunner/api/ports.py": {"socket"},
    "runner/rigrunner/rig_state/addresses.py": {"socket"},  # one host has several names
    "plugins/rigrunner_plugins/listeners/answers.py": {"socket"},  # the type of what it reads
    "plugins/rigrunner_plugins/listeners/webhook.py": {"http", "socket", "ssl"},
    "plugins/rigrunner_plugins/listeners/mail.py": {"smtplib", "ssl"},
    "runner/rigrunner/run/rig_lock.py": {"socket"},  # the name of this machine
    "runner/rigrunner_testing/device/recovery.py": {"socket"},  # an instrument on loopback
}
"""Exceptions: imports that only these modules may have. Processes of a panel exchange objects
over their own pipes; the panel listens where it is configured, and knows this machine's names;
instruments are connected, and absent people notified, at the address that the station names."""
PARSES = "urllib.parse"
"""Splits addresses and connects to none."""
RUNNING = {"eval", "exec", "compile", "__import__"}
LOADS_PLUGINS = ROOT / "runner/rigrunner/registry/loading.py"


def imported_names(nodes):
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level and node.module != PARSES:
            yield (node.module or "").split(".")[0]


def called_names(nodes):
    for node in nodes:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            yield node.func.id


def keywords(nodes):
    for node in nodes:
        if isinstance(node, ast.keyword) and isinstance(node.value, ast.Constant):
            yield node.arg, node.value.value


def nodes_of(source):
    return list(ast.walk(ast.parse(source)))


@pytest.fixture(scope="module")
def modules():
    """Return the nodes of each module, walked once: it takes long."""
    return {path: nodes_of(path.read_text(encoding="utf-8")) for path in SOURCES}


def test_modules_are_found(modules):
    assert len(modules) > 300
    assert LOADS_PLUGINS in modules


@pytest.mark.parametrize(
    ("find", "forbidden"),
    [(imported_names, UNPICKLERS | NETWORK), (called_names, RUNNING)],
    ids=["imports", "calls"],
)
def test_no_module_can_execute_data(find, forbidden, modules):
    uses = {
        (path.relative_to(ROOT).as_posix(), name)
        for path, nodes in modules.items()
        for name in forbidden & set(find(nodes))
    }
    assert not {(file, name) for file, name in uses if name not in KNOWN.get(file, ())}


def test_no_shell_and_no_pickled_arrays(modules):
    arguments = {(path.name, pair) for path, nodes in modules.items() for pair in keywords(nodes)}
    assert not [
        argument
        for argument in arguments
        if argument[1] in {("shell", True), ("allow_pickle", True)}
    ]


def test_only_one_module_loads_code_by_path(modules):
    loaders = {path for path, nodes in modules.items() if "importlib" in set(imported_names(nodes))}
    by_path = {
        path for path in loaders if "spec_from_file_location" in path.read_text(encoding="utf-8")
    }
    assert by_path == {LOADS_PLUGINS}


def test_allowed_imports_still_exist(modules):
    for file, names in KNOWN.items():
        assert names <= set(imported_names(modules[ROOT / file])), file


def test_forbidden_code_is_detected():
    nodes = nodes_of("import pickle\nfrom marshal import loads\neval('1')\nf(shell=True)")
    assert set(imported_names(nodes)) == {"pickle", "marshal"}
    assert "eval" in set(called_names(nodes))
    assert ("shell", True) in set(keywords(nodes))
