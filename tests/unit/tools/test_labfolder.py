"""A lab folder is made of what a package brings, and of what every lab has."""

from __future__ import annotations

import re
import sys

import pytest

from helpers_cli import call
from rigrunner.api.errors import ExitCode, UsageError
from rigrunner.api.hooks import LabRecord
from rigrunner.registry import Plugin, Provider, Registry, load_registry
from rigrunner.tools.labfolder import make_lab
from rigrunner_testing import State, checks, examine_one, subject

STATION = """\
rigrunner: station/1
id: oven
title: An oven
devices: {oven: {type: oven, plugin: none}}
"""
PROCEDURE = """\
rigrunner: procedure/2
id: HEAT
revision: "1"
title: Heat
uses: {oven: oven}
main: [{note: {text: warm}}]
"""


@pytest.fixture
def oven(tmp_path, monkeypatch):
    """Give a package that brings the lab of an oven, and return its registry by the files in it."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(**files):
        folder = tmp_path / "oven_maker"
        (folder / "lab/procedures").mkdir(parents=True)
        (folder / "__init__.py").write_text("")
        for name, text in files.items():
            (folder / "lab" / name.replace("__", "/").replace("_md", ".md")).write_text(text)
        record = LabRecord(name="oven", help="An oven.", files="oven_maker:lab")
        return Registry([Plugin("lab", record, Provider("oven_maker", "1"))])

    yield make
    sys.modules.pop("oven_maker", None)


def test_it_has_its_own_files_and_what_every_lab_has(oven, tmp_path):
    files = {"station.yaml": STATION, "procedures__heat.yaml": PROCEDURE}
    registry = oven(README_md="An oven.", **files)
    assert make_lab(tmp_path / "lab", registry) == ["procedures/heat.yaml"]
    assert (tmp_path / "lab/station.yaml").read_text() == STATION
    assert (tmp_path / "lab/letterhead/letterhead.yaml").is_file()
    assert not (tmp_path / "lab/plugins").exists()


def test_another_lab_than_that_of_the_bearings_speaks_of_no_bearing(oven, tmp_path):
    make_lab(tmp_path / "lab", oven(README_md="An oven."))
    pages = [
        path
        for path in (tmp_path / "lab").rglob("*")
        if path.is_file() and not path.name.endswith(".schema.json")
    ]
    assert "example_order.yaml" in {path.name for path in pages}
    for path in pages:
        matches = re.findall("bearing|torque|swing|SSPB|aircraft", path.read_text(), re.IGNORECASE)
        assert matches == [], path


def test_without_a_lab_to_begin_with_it_says_so(tmp_path):
    with pytest.raises(UsageError, match="expected one of: none is installed"):
        make_lab(tmp_path / "lab", Registry([]))


def test_of_several_one_must_be_named(oven, tmp_path):
    shipped = [plugin for plugin in load_registry().plugins if plugin.kind == "lab"]
    registry = Registry([*oven(README_md="An oven.").plugins, *shipped])
    with pytest.raises(UsageError, match="expected one of: bearings, oven") as caught:
        make_lab(tmp_path / "lab", registry)
    assert "--lab" in caught.value.hint
    make_lab(tmp_path / "lab", registry, "oven")
    assert (tmp_path / "lab/README.md").read_text() == "An oven."


def test_a_lab_that_is_not_there_is_named(tmp_path):
    called = call("init", tmp_path / "lab", "--lab", "bearing")
    assert called.code not in {ExitCode.PASS, ExitCode.BUG}
    assert "there is no lab 'bearing'" in called.err
    assert "bearings" in called.err


@pytest.mark.parametrize(
    ("name", "files", "message"),
    [
        ("is_whole", {"station.yaml": STATION}, "it has no README.md"),
        ("is_whole", {"station.yaml": STATION, "README_md": "x"}, "it has no procedure"),
        (
            "can_be_run_at_once",
            {"station.yaml": STATION, "README_md": "x", "procedures__heat.yaml": PROCEDURE},
            "there is no device 'none'",
        ),
    ],
)
def test_the_kit_fails_one_that_is_broken(oven, name, files, message):
    lab_checks = {check.name: check for check in checks("lab")}
    finding = examine_one(subject("lab", "oven", registry=oven(**files)), lab_checks[name])
    assert finding.state is State.FAIL
    assert message in finding.text
