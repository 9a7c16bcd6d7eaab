"""What `rigrunner new` writes and refuses, and the names that it gives."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_cli import call
from rigrunner.api.errors import ExitCode, UsageError
from rigrunner.registry import load_registry, with_drop_ins
from rigrunner.tools.new_plugin import KINDS, make_drop_in, make_package, new_plugin

REGISTRY = load_registry()
ALL_KINDS = (*KINDS, "compensation")
"""Rigrunner's own kinds, and one of a package."""
NAMES = ["x", "spring_scale", "abcdefghij_klmnopqrst_uvwxyz12"]
"""The shortest, a usual one, and the longest."""


@pytest.fixture(params=ALL_KINDS)
def kind(request):
    return request.param


def test_own_kinds_are_listed_in_the_help():
    words = re.search(r"KIND is (.*?), or a kind", " ".join(call("new", "--help").out.split()))[1]
    assert re.split(", | or ", words) == list(KINDS)


def test_new_drop_in_is_a_working_plugin(kind, tmp_path):
    files = make_drop_in(new_plugin(kind, "spring_scale", REGISTRY), tmp_path, REGISTRY)
    assert files == ["spring_scale.py"]
    registry = with_drop_ins(REGISTRY, tmp_path)
    assert registry.disabled == ()
    assert registry.find(KINDS.get(kind, kind), "spring_scale").record.help.startswith(
        "Spring scale"
    )


def test_readme_explains_the_use_of_its_kind(kind):
    """Each kind has a place in a procedure, station or command; only a report names `--format`."""
    readme = new_plugin(kind, "spring_scale", REGISTRY).texts()["README.md"]
    assert "As made, it " in readme
    assert ("`rigrunner report RUN --format spring_scale`" in readme) == (kind == "report")


BEARING_WORDS = re.compile(r"bearing|torque|swing|mandrel|no.load|N·m|Hz", re.IGNORECASE)


@pytest.mark.parametrize("kind", KINDS)
def test_files_of_own_kinds_do_not_mention_bearings(kind):
    for file, text in new_plugin(kind, "spring_scale", REGISTRY).texts().items():
        assert BEARING_WORDS.findall(text) == [], file


@pytest.mark.parametrize("name", NAMES)
def test_new_package_passes_ruff_for_any_name_length(kind, name, tmp_path):
    folder = tmp_path / "package"
    files = make_package(new_plugin(kind, name, REGISTRY), folder, REGISTRY)
    assert sorted(files) == sorted(
        str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()
    )
    ruff = shutil.which("ruff") or f"{sys.prefix}/bin/ruff"
    for command in ([ruff, "check", "--no-cache"], [ruff, "format", "--no-cache", "--diff"]):
        result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert result.returncode == 0, result.stdout + result.stderr


def test_device_with_simulator_takes_less_than_40_lines():
    """All lines of the module that are not blank are counted, docstrings included."""
    text = new_plugin("device", "spring_scale", REGISTRY).module()
    assert sum(bool(line.strip()) for line in text.splitlines()) < 40
    classes = [node.name for node in ast.parse(text).body if isinstance(node, ast.ClassDef)]
    assert classes == ["SimulatedSpringScale", "SpringScale"]


@pytest.mark.parametrize("name", ["polynomial", "aicc"])
def test_name_of_a_registered_plugin_is_refused(name, tmp_path):
    with pytest.raises(UsageError, match=f"there is a fit '{name}' already, of rigrunner_plugins"):
        make_package(new_plugin("fit", name, REGISTRY), tmp_path / "new", REGISTRY)
    assert not (tmp_path / "new").exists()


def test_name_of_an_installed_package_is_refused(tmp_path):
    with pytest.raises(UsageError, match="there is a package rigrunner_plugins already"):
        make_package(new_plugin("device", "plugins", REGISTRY), tmp_path / "new", REGISTRY)


@pytest.mark.parametrize(
    ("kind", "words"), [("fit", "a fit"), ("outlier-rule", "an outlier-rule"), ("unit", "a unit")]
)
def test_name_of_a_drop_in_in_the_folder_is_refused(kind, words, tmp_path):
    assert call("new", kind, "lab_line", "--drop-in", "--folder", tmp_path).code == ExitCode.PASS
    (tmp_path / "lab_line.py").rename(tmp_path / "other.py")
    result = call("new", kind, "lab_line", "--drop-in", "--folder", tmp_path)
    assert result.code == ExitCode.USAGE
    assert f"there is {words} 'lab_line' already, of" in result.err
    assert not (tmp_path / "lab_line.py").exists()


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("Spring-Scale", "such as 'spring_scale'"),
        ("springScale", "such as 'spring_scale'"),
        ("spring__scale", "such as 'spring_scale'"),
        ("../scale", "such as 'scale'"),
        ("2nd_scale", ""),
        ("class", ""),
        ("yes", ""),
        ("", ""),
        ("größe", ""),
    ],
)
def test_invalid_name_is_refused_with_a_suggestion(name, hint, tmp_path):
    with pytest.raises(UsageError, match="cannot be the name of a plugin") as caught:
        make_package(new_plugin("device", name, REGISTRY), tmp_path / "new", REGISTRY)
    assert caught.value.hint == hint
    assert not (tmp_path / "new").exists()


def test_too_long_name_is_refused(tmp_path):
    with pytest.raises(UsageError, match="has 31 characters, expected at most 30"):
        make_package(new_plugin("device", "a" * 31, REGISTRY), tmp_path / "new", REGISTRY)


@pytest.mark.parametrize(
    ("kind", "name", "bound"),
    [("outlier-rule", "rejection", "Rejection"), ("importer", "column", "Column")],
)
def test_name_that_makes_a_duplicate_class_is_refused(kind, name, bound, tmp_path):
    with pytest.raises(UsageError, match=f"would make a class {bound}"):
        make_drop_in(new_plugin(kind, name, REGISTRY), tmp_path, REGISTRY)


@given(kind=st.sampled_from(ALL_KINDS), name=st.text("abcSX09_-. é'\n\"{}", max_size=8))
@settings(max_examples=150, derandomize=True, deadline=None)
def test_any_name_is_refused_or_makes_valid_files(kind, name):
    plugin = new_plugin(kind, name, REGISTRY)
    with tempfile.TemporaryDirectory() as folder:
        try:
            files = make_package(plugin, Path(folder) / "new", REGISTRY)
        except UsageError:
            assert not (Path(folder) / "new").exists()
            return
        assert all((Path(folder) / "new" / file).is_file() for file in files)
    assert name.isidentifier()
    texts = plugin.texts()
    assert tomllib.loads(texts["pyproject.toml"])["project"]["name"] == plugin.project
    for file in files:
        if file.endswith(".py"):
            ast.parse(texts[file])


def test_existing_files_are_not_overwritten(tmp_path):
    folder = tmp_path / "scale"
    assert call("new", "device", "scale", "--folder", folder).code == ExitCode.PASS
    (folder / "README.md").write_text("mine")
    (folder / "pyproject.toml").unlink()
    result = call("new", "device", "scale", "--folder", folder)
    assert result.code == ExitCode.USAGE
    assert "has a README.md already, and 5 more" in result.err
    assert (folder / "README.md").read_text() == "mine"
    assert not (folder / "pyproject.toml").exists()


def test_unknown_kind_lists_the_kinds():
    result = call("new", "devise", "scale")
    assert result.code == ExitCode.USAGE
    assert "got the kind 'devise', expected one" in result.err
    assert "there are: device, fit, outlier-rule," in result.err
    assert "unit, compensation" in result.err


def test_new_files_and_next_commands_are_printed(tmp_path):
    result = call("new", "device", "scale", "--folder", tmp_path / "a b")
    assert result.out.splitlines()[0] == f"cd '{tmp_path / 'a b'}'"
    assert "rigrunner check-plugin scale" in result.out
    assert "tests/test_scale.py" in result.err
