"""A lab folder consists of the files of a package and of those of every lab."""

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
    """Return a function that makes the lab of an oven from files, and returns its registry."""
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


def test_lab_folder_has_its_own_and_the_common_files(oven, tmp_path):
    files = {"station.yaml": STATION, "procedures__heat.yaml": PROCEDURE}
    registry = oven(README_md="An oven.", **files)
    assert make_lab(tmp_path / "lab", registry) == ["procedures/heat.yaml"]
    assert (tmp_path / "lab/station.yaml").read_text() == STATION
    assert (tmp_path / "lab/letterhead/letterhead.yaml").is_file()
    assert not (tmp_path / "lab/plugins").exists()


def test_common_files_do_not_mention_bearings(oven, tmp_path):
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


def test_no_installed_lab_is_an_error(tmp_path):
    with pytest.raises(UsageError, match="expected one of: none is installed"):
        make_lab(tmp_path / "lab", Registry([]))


def test_choice_among_several_labs_is_required(oven, tmp_path):
    shipped = [plugin for plugin in load_registry().plugins if plugin.kind == "lab"]
    registry = Registry([*oven(README_md="An oven.").plugins, *shipped])
    with pytest.raises(UsageError, match="expected one of: bearings, oven") as caught:
        make_lab(tmp_path / "lab", registry)
    assert "--lab" in caught.value.hint
    make_lab(tmp_path / "lab", registry, "oven")
    assert (tmp_path / "lab/README.md").read_text() == "An oven."


def test_unknown_lab_is_reported(tmp_path):
    result = call("init", tmp_path / "lab", "--lab", "bearing")
    assert result.code not in {ExitCode.PASS, ExitCode.BUG}
    assert "there is no lab 'bearing'" in result.err
    assert "bearings" in result.err


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
def test_conformance_kit_fails_an_incomplete_lab(oven, name, files, message):
    lab_checks = {check.name: check for check in checks("lab")}
    finding = examine_one(subject("lab", "oven", registry=oven(**files)), lab_checks[name])
    assert finding.state is State.FAIL
    assert message in finding.text
