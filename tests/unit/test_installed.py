"""What is remembered of the installed plugins is never of another environment than this one."""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import sys
import time
from importlib.machinery import PathFinder
from zipfile import ZipFile

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rigrunner.registry import installed as module
from rigrunner.registry.installed import Installed, installed

LONG_AGO_S = 60.0


@pytest.fixture
def own_finders(monkeypatch):
    """Python's own finders alone: importlib_metadata (of dask) puts its own in their place."""
    others = [each for each in sys.meta_path if each is not PathFinder]
    kept = [each for each in others if not hasattr(each, "find_distributions")]
    monkeypatch.setattr(sys, "meta_path", [*kept, PathFinder])
    known = importlib.metadata.MetadataPathFinder.find_distributions
    monkeypatch.setattr(PathFinder, "find_distributions", known, raising=False)


@pytest.fixture
def lab(tmp_path, monkeypatch, own_finders):  # noqa: ARG001  (it is used as it stands)
    """An environment with one provider, whose files are old enough to be trusted."""
    site, memory = tmp_path / "site", tmp_path / "cache" / "installed.json"
    monkeypatch.setattr(sys, "path", [str(site)])
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(module, "_memory", lambda: memory)
    add(site, "ours", "1.0", "[rigrunner]\nours = ours.hooks\n")
    add(site, "other", "3.1", "[console_scripts]\nother = other:main\n")
    return site


def add(site, name, version, entry_points, age_s=LONG_AGO_S):
    folder = site / f"{name}-{version}.dist-info"
    folder.mkdir(parents=True, exist_ok=True)
    write(folder / "METADATA", f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n", age_s)
    write(folder / "entry_points.txt", entry_points, age_s)
    importlib.invalidate_caches()
    return folder


def write(path, text, age_s=LONG_AGO_S):
    path.write_text(text)
    moment = time.time() - age_s
    os.utime(path, (moment, moment))


def forbid_scan(monkeypatch):
    def scanned(**_):
        raise AssertionError("all distributions were read")

    monkeypatch.setattr(module, "entry_points", scanned)


OURS = Installed("ours", "ours.hooks", "1.0")


@pytest.mark.usefixtures("lab")
def test_what_was_found_is_remembered(monkeypatch):
    assert installed() == (OURS,)
    forbid_scan(monkeypatch)
    assert installed() == (OURS,)


def test_a_provider_that_is_added_is_found(lab):
    installed()
    add(lab, "press", "0.2", "[rigrunner]\npress = press:hooks\n")
    assert installed() == (OURS, Installed("press", "press:hooks", "0.2"))


def test_a_provider_that_is_removed_is_gone(lab):
    folder = add(lab, "press", "0.2", "[rigrunner]\npress = press\n")
    assert len(installed()) == 2
    for file in folder.iterdir():
        file.unlink()
    folder.rmdir()
    importlib.invalidate_caches()
    assert installed() == (OURS,)


@pytest.mark.parametrize(
    ("file", "text", "found"),
    [
        ("entry_points.txt", "[rigrunner]\nours = ours.else\n", ("ours", "ours.else", "1.0")),
        (
            "METADATA",
            "Metadata-Version: 2.1\nName: ours\nVersion: 1.1\n",
            ("ours", "ours.hooks", "1.1"),
        ),
    ],
)
def test_a_file_that_is_changed_in_its_place_is_read_again(lab, file, text, found):
    installed()
    write(lab / "ours-1.0.dist-info" / file, text, age_s=LONG_AGO_S - 1)
    assert installed() == (Installed(*found),)


def test_entry_points_that_a_distribution_comes_to_have_are_found(lab):
    file = lab / "other-3.1.dist-info" / "entry_points.txt"
    file.unlink()
    assert installed() == (OURS,)
    write(file, "[rigrunner]\nlate = late\n")
    assert installed() == (Installed("late", "late", "3.1"), OURS)


def test_another_path_is_another_environment(lab, tmp_path, monkeypatch):
    installed()
    add(tmp_path / "more", "press", "0.2", "[rigrunner]\npress = press\n")
    monkeypatch.setattr(sys, "path", [str(lab), str(tmp_path / "more")])
    assert [each.name for each in installed()] == ["ours", "press"]


def test_what_has_just_changed_is_not_trusted_yet(lab, monkeypatch):
    add(lab, "press", "0.2", "[rigrunner]\npress = press\n", age_s=0.0)
    assert len(installed()) == 2
    forbid_scan(monkeypatch)
    with pytest.raises(AssertionError, match="all distributions"):
        installed()


def test_where_an_archive_is_searched_nothing_is_remembered(lab, tmp_path, monkeypatch):
    with ZipFile(tmp_path / "lib.zip", "w") as archive:
        archive.writestr("press-0.2.dist-info/METADATA", "Name: press\nVersion: 0.2\n")
        archive.writestr("press-0.2.dist-info/entry_points.txt", "[rigrunner]\npress = press\n")
    monkeypatch.setattr(sys, "path", [str(lab), str(tmp_path / "lib.zip")])
    assert [each.name for each in installed()] == ["ours", "press"]
    assert not module._memory().exists()


@pytest.mark.usefixtures("lab")
def test_where_another_finder_knows_distributions_nothing_is_remembered(monkeypatch):
    class Finder(importlib.metadata.DistributionFinder):
        def find_spec(self, *_):
            return None

        def find_distributions(self, *_):
            return iter(())

    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, Finder()])
    assert installed() == (OURS,)
    assert not module._memory().exists()


@pytest.mark.usefixtures("lab")
def test_nothing_is_written_where_python_writes_nothing(monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert installed() == (OURS,)
    assert not module._memory().exists()


@pytest.mark.usefixtures("lab")
def test_a_place_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(module, "_memory", lambda: tmp_path / "file" / "installed.json")
    assert installed() == (OURS,)


@pytest.mark.usefixtures("lab")
@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    spoiled=st.binary(max_size=200)
    | st.sampled_from(
        [
            b"[]",
            b"null",
            b'{"key": 1}',
            b'{"key": "KEY", "installed": 5}',
            b'{"key": "KEY", "installed": [5]}',
            b'{"key": "KEY", "installed": [{"name": "x"}]}',
            b'{"key": "KEY", "installed": [{"name": 1, "place": [], "version": null}]}',
        ]
    ),
    cut=st.integers(0, 400),
)
def test_a_spoiled_memory_is_made_anew(spoiled, cut):
    assert installed() == (OURS,)
    memory = module._memory()
    whole = memory.read_bytes()
    key = whole.split(b'"')[3]
    for content in (spoiled.replace(b"KEY", key), whole[: cut % len(whole)]):
        memory.write_bytes(content)
        assert installed() == (OURS,)
        assert memory.read_bytes() == whole


@pytest.mark.usefixtures("own_finders")
def test_this_environment_is_remembered_as_it_is(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(module, "_memory", lambda: tmp_path / "installed.json")
    scanned = module._found()
    assert {"rigrunner_plugins", "rigrunner_reports"} <= {each.name for each in scanned}
    assert installed() == scanned
    assert installed() == scanned
