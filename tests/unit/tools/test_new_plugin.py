"""What `rigrunner new` writes, by which names, and what it refuses."""

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
WORDS = (*KINDS, "compensation")
"""Rigrunner's own kinds, and one that a package brings."""
NAMES = ["x", "spring_scale", "abcdefghij_klmnopqrst_uvwxyz12"]
"""The shortest, one as people write it, and the longest."""


@pytest.fixture(params=WORDS)
def word(request):
    return request.param


def test_every_kind_of_its_own_stands_in_the_help():
    words = re.search(r"KIND is (.*?), or a kind", " ".join(call("new", "--help").out.split()))[1]
    assert re.split(", | or ", words) == list(KINDS)


def test_a_drop_in_is_a_plugin_at_once(word, tmp_path):
    files = make_drop_in(new_plugin(word, "spring_scale", REGISTRY), tmp_path, REGISTRY)
    assert files == ["spring_scale.py"]
    registry = with_drop_ins(REGISTRY, tmp_path)
    assert registry.disabled == ()
    assert registry.find(KINDS.get(word, word), "spring_scale").record.help.startswith(
        "Spring scale"
    )


def test_the_readme_says_how_a_plugin_of_its_kind_is_used(word):
    """Each kind has a place in a procedure, a station or a command: of a report only its own."""
    readme = new_plugin(word, "spring_scale", REGISTRY).texts()["README.md"]
    assert "As made, it " in readme
    assert ("`rigrunner report RUN --format spring_scale`" in readme) == (word == "report")


OF_BEARINGS = re.compile(r"bearing|torque|swing|mandrel|no.load|N·m|Hz", re.IGNORECASE)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_made_of_a_kind_of_its_own_speaks_of_no_bearing(kind):
    for file, text in new_plugin(kind, "spring_scale", REGISTRY).texts().items():
        assert OF_BEARINGS.findall(text) == [], file


@pytest.mark.parametrize("name", NAMES)
def test_what_is_made_is_linted_and_formatted_whatever_the_name(word, name, tmp_path):
    folder = tmp_path / "package"
    files = make_package(new_plugin(word, name, REGISTRY), folder, REGISTRY)
    assert sorted(files) == sorted(
        str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()
    )
    ruff = shutil.which("ruff") or f"{sys.prefix}/bin/ruff"
    for command in ([ruff, "check", "--no-cache"], [ruff, "format", "--no-cache", "--diff"]):
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


def test_a_device_with_its_simulator_takes_less_than_40_lines():
    """All lines of the module that are not blank are counted, docstrings and all."""
    text = new_plugin("device", "spring_scale", REGISTRY).module()
    assert sum(bool(line.strip()) for line in text.splitlines()) < 40
    classes = [node.name for node in ast.parse(text).body if isinstance(node, ast.ClassDef)]
    assert classes == ["SimulatedSpringScale", "SpringScale"]


@pytest.mark.parametrize("name", ["polynomial", "aicc"])
def test_a_name_that_is_taken_is_refused(name, tmp_path):
    with pytest.raises(UsageError, match=f"there is a fit '{name}' already, of rigrunner_plugins"):
        make_package(new_plugin("fit", name, REGISTRY), tmp_path / "new", REGISTRY)
    assert not (tmp_path / "new").exists()


def test_a_package_that_is_installed_is_not_shadowed(tmp_path):
    with pytest.raises(UsageError, match="there is a package rigrunner_plugins already"):
        make_package(new_plugin("device", "plugins", REGISTRY), tmp_path / "new", REGISTRY)


@pytest.mark.parametrize(
    ("kind", "words"), [("fit", "a fit"), ("outlier-rule", "an outlier-rule"), ("unit", "a unit")]
)
def test_a_drop_in_of_the_same_folder_is_known(kind, words, tmp_path):
    assert call("new", kind, "lab_line", "--drop-in", "--folder", tmp_path).code == ExitCode.PASS
    (tmp_path / "lab_line.py").rename(tmp_path / "other.py")
    called = call("new", kind, "lab_line", "--drop-in", "--folder", tmp_path)
    assert called.code == ExitCode.USAGE
    assert f"there is {words} 'lab_line' already, of" in called.err
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
def test_what_cannot_be_a_name_is_refused(name, hint, tmp_path):
    with pytest.raises(UsageError, match="cannot be the name of a plugin") as caught:
        make_package(new_plugin("device", name, REGISTRY), tmp_path / "new", REGISTRY)
    assert caught.value.hint == hint
    assert not (tmp_path / "new").exists()


def test_a_name_that_is_too_long_is_refused(tmp_path):
    with pytest.raises(UsageError, match="has 31 characters, expected at most 30"):
        make_package(new_plugin("device", "a" * 31, REGISTRY), tmp_path / "new", REGISTRY)


@pytest.mark.parametrize(
    ("word", "name", "bound"),
    [("outlier-rule", "rejection", "Rejection"), ("importer", "column", "Column")],
)
def test_a_name_whose_class_is_called_like_another_is_refused(word, name, bound, tmp_path):
    with pytest.raises(UsageError, match=f"would make a class {bound}"):
        make_drop_in(new_plugin(word, name, REGISTRY), tmp_path, REGISTRY)


@given(word=st.sampled_from(WORDS), name=st.text("abcSX09_-. é'\n\"{}", max_size=8))
@settings(max_examples=150, derandomize=True, deadline=None)
def test_whatever_the_name_it_is_refused_or_all_that_is_made_can_be_read(word, name):
    plugin = new_plugin(word, name, REGISTRY)
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


def test_nothing_is_overwritten(tmp_path):
    folder = tmp_path / "scale"
    assert call("new", "device", "scale", "--folder", folder).code == ExitCode.PASS
    (folder / "README.md").write_text("mine")
    (folder / "pyproject.toml").unlink()
    called = call("new", "device", "scale", "--folder", folder)
    assert called.code == ExitCode.USAGE
    assert "has a README.md already, and 5 more" in called.err
    assert (folder / "README.md").read_text() == "mine"
    assert not (folder / "pyproject.toml").exists()


def test_a_kind_that_is_not_there_names_those_that_are():
    called = call("new", "devise", "scale")
    assert called.code == ExitCode.USAGE
    assert "got the kind 'devise', expected one" in called.err
    assert "there are: device, fit, outlier-rule," in called.err
    assert "unit, compensation" in called.err


def test_what_was_made_and_how_to_try_it_is_printed(tmp_path):
    called = call("new", "device", "scale", "--folder", tmp_path / "a b")
    assert called.out.splitlines()[0] == f"cd '{tmp_path / 'a b'}'"
    assert "rigrunner check-plugin scale" in called.out
    assert "tests/test_scale.py" in called.err
