"""Third-party plugins install against our wheel, type-check, pass their tests and run.

The environment has our wheel and theirs, and borrows all other packages from the testing one.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import pytest

from helpers_docs import ROOT, code_blocks, matches
from rigrunner.registry import load_registry
from rigrunner.tools.new_plugin import KINDS, new_plugin

STRANGER = Path(__file__).parent / "stranger"
WORDS = (*KINDS, "compensation")
REGISTRY = load_registry()
PLUGINS = {word: new_plugin(word, f"authors_{word.replace('-', '_')}", REGISTRY) for word in WORDS}
pytestmark = pytest.mark.thorough
HAS_HATCHLING = find_spec("hatchling") is not None
QUIETLY = ["-q", "--no-deps", *(["--no-build-isolation"] if HAS_HATCHLING else [])]
"""Build tools are not installed again for each package where the testing environment has them."""
WITHOUT = {"PYTHONPATH", "MYPYPATH", "PYTEST_ADDOPTS", "COLUMNS"}


@dataclass(frozen=True)
class Author:
    """A folder with a package of each kind, and an environment in which all are installed."""

    folder: Path
    bin: Path

    def run(self, *words, cwd=None):
        """Run a program of the environment; return its result."""
        kept = {name: value for name, value in os.environ.items() if name not in WITHOUT}
        ours = Path(sys.executable).parent  # where mypy, pytest and ruff are, which it shares
        path = os.pathsep.join(map(str, (self.bin, ours, os.environ["PATH"])))
        return subprocess.run(
            [self.bin / words[0], *words[1:]],
            cwd=cwd or self.folder,
            env=kept | {"PATH": path, "MYPY_CACHE_DIR": str(self.folder / "mypy")},
            capture_output=True,
            text=True,
            check=False,
        )

    def package(self, word):
        """Return the folder of a package."""
        return self.folder / PLUGINS[word].project


def output_of(done):
    assert done.returncode == 0, f"{done.args}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def pip(*words):
    done = subprocess.run(
        [sys.executable, "-m", "pip", "--disable-pip-version-check", *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
    )
    output_of(done)


SCRIPTS = {
    "pip": 'exec {outer} -m pip --disable-pip-version-check --python {own} "$@"',
    "pytest": 'exec {own} -m pytest "$@"',
    "mypy": 'exec {own} -m mypy "$@"',
}
"""Programs of borrowed packages, made to see what is installed here."""


@pytest.fixture(scope="session")
def author(made_once) -> Author:
    """Make the environment, once for all workers."""
    return author_in(made_once("author", lambda folder: install(author_in(folder))))


def author_in(folder) -> Author:
    scripts = sysconfig.get_path("scripts", "venv", {"base": str(folder / "env")})
    return Author(folder, Path(scripts))


def install(author) -> None:
    folder, environment = author.folder, author.folder / "env"
    venv.create(environment, symlinks=True)
    site = Path(sysconfig.get_path("purelib", "venv", {"base": str(environment)}))
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    shutil.copytree(STRANGER, folder / "stranger")
    pip("wheel", *QUIETLY, "-w", folder, ROOT)
    (wheel,) = folder.glob("rigrunner-*.whl")
    python = author.bin / "python"
    pip("--python", python, "install", *QUIETLY, wheel)
    for name, line in SCRIPTS.items():
        (author.bin / name).write_text(
            f"#!/bin/sh\n{line}\n".format(outer=sys.executable, own=python)
        )
        (author.bin / name).chmod(0o755)
    for word, plugin in PLUGINS.items():
        output_of(author.run("rigrunner", "new", word, plugin.name))
    projects = [author.package(word) for word in PLUGINS]
    pip("--python", python, "install", *QUIETLY, *projects)


def test_environment_has_the_wheel_and_not_the_sources(author):
    code = "import rigrunner, rigrunner_plugins; print(rigrunner.__file__)"
    shown = output_of(author.run("python", "-c", code))
    assert shown.startswith(str(author.folder / "env"))


@pytest.mark.parametrize("word", WORDS)
def test_new_package_passes_its_own_tests(author, word):
    done = author.run("python", "-m", "pytest", "-q", "-rs", cwd=author.package(word))
    assert " passed" in output_of(done)


def test_new_and_third_party_plugins_pass_strict_type_checks(author):
    parts = [author.package(word) / part for word in PLUGINS for part in ("src", "tests")]
    done = author.run("python", "-m", "mypy", "--strict", *parts, "stranger")
    assert "no issues found" in output_of(done)


def test_type_checker_finds_a_broken_contract(author):
    """The wheel carries its types: without py.typed everything would pass."""
    wrong = (
        "from rigrunner.api.driver import Driver\n"
        "class Press(Driver):\n"
        "    def get(self, channel: str) -> str:\n"
        "        return 'much'\n"
    )
    (author.folder / "wrong.py").write_text(wrong)
    done = author.run("python", "-m", "mypy", "--strict", "wrong.py")
    assert done.returncode == 1
    assert "wrong.py:3" in done.stdout
    assert "incompatible with return type" in done.stdout


def test_new_plugins_are_listed_with_their_version(author):
    listed = json.loads(output_of(author.run("rigrunner", "plugins", "--json")))
    found = {plugin["name"]: (plugin["kind"], plugin["version"]) for plugin in listed}
    for plugin in PLUGINS.values():
        assert found[plugin.name] == (plugin.kind, "0.1.0")


def test_run_uses_the_new_device(author):
    words = ["example/procedure.yaml", "--station", "example/station.yaml", "--unattended"]
    output_of(author.run("rigrunner", "run", *words, cwd=author.package("device")))
    shown = output_of(author.run("rigrunner", "runs", "--json", cwd=author.package("device")))
    (run,) = json.loads(shown)
    assert run["outcome"] == "completed"


def test_wheel_loads_a_third_party_plugin(author):
    code = (
        "from importlib.metadata import EntryPoint\n"
        "from rigrunner.registry import load_registry\n"
        "names = {'rigrunner_bearings': 'rigrunner_bearings.hooks', 'stranger': 'stranger'}\n"
        "found = load_registry([EntryPoint(*each, 'rigrunner') for each in names.items()])\n"
        "theirs = {each.kind for each in found.plugins if each.provider.name == 'stranger'}\n"
        "print(sorted(theirs), found.disabled)\n"
    )
    shown = output_of(author.run("python", "-c", code))
    new_kinds = {each.kind for each in PLUGINS.values()} - {"step"}
    kinds = sorted([*new_kinds, "certificate_format", "event_sink", "study_format"])
    assert shown.strip() == f"{kinds} ()"


def test_new_plugins_pass_every_check_of_the_kit(author):
    """In one process, which imports their dependencies only once."""
    calls = [["check-plugin", plugin.name, "--kind", plugin.kind] for plugin in PLUGINS.values()]
    code = f"from rigrunner.cli.main import main; print('CODES', [main(each) for each in {calls}])"
    printed = output_of(author.run("python", "-c", code))
    assert printed.count(", 0 fail, ") == len(calls)
    assert printed.endswith(f"CODES {[0] * len(calls)}\n")


TUTORIAL = ROOT / "docs/tutorial/first-device-plugin.md"
LONGEST_S = 180
"""Processor time of all commands of the tutorial; the rest of its ten minutes is reading."""


def test_tutorial_works_unchanged_in_its_time(author, tmp_path):
    """Each block in the folder in which the last one ended, as in a reader's shell."""
    folder, output, start_s = tmp_path, "", programs_processor_s()
    for block in code_blocks(TUTORIAL):
        where = f"{TUTORIAL.name}:{block.line}"
        if block.file:
            (folder / block.file).write_text(block.code, encoding="utf-8")
        elif block.language == "text":
            assert matches(block.code, output), f"{where} does not match\n{output}"
        else:
            assert block.language == "sh", where
            code = f"{{\n{block.code}}} 2>&1; pwd > {tmp_path}/pwd"
            done = author.run("/bin/bash", "-euo", "pipefail", "-c", code, cwd=folder)
            output = output_of(done)
            folder = Path((tmp_path / "pwd").read_text().strip())
    assert 1 < programs_processor_s() - start_s < LONGEST_S


def programs_processor_s():
    """Return the processor time of the started programs that have ended."""
    used = os.times()
    return used.children_user + used.children_system


def test_tutorial_states_the_right_number_of_lines():
    (module,) = (block for block in code_blocks(TUTORIAL) if block.file.endswith("__init__.py"))
    lines = sum(bool(line.strip()) for line in module.code.splitlines())
    assert f"{lines} non-blank lines" in TUTORIAL.read_text(encoding="utf-8")
    assert lines < 40
