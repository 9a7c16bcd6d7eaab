"""The lab folder for bearings is complete, and existing files are never overwritten."""

from __future__ import annotations

import json

import pytest

from helpers_thorough import first
from rigrunner.api.errors import UsageError
from rigrunner.procedure import load_procedure
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure
from rigrunner.station import load_station
from rigrunner.tools.labfolder import make_lab

FILES = {
    *("README.md", ".gitignore", "station.yaml", "station.schema.json", "letterhead/README.md"),
    ".gitattributes",
    *("plugins/room_thermometer.py", "procedures/procedure.schema.json"),
    *("procedures/no_load_inertia_sweep.yaml", "procedures/starting_torque_1000n.yaml"),
    *("letterhead/letterhead.yaml", "letterhead/logo.svg", "letterhead/letterhead.schema.json"),
    *("procedures/room_temperature.yaml", "plugins/torque_table.py"),
    *("reports/README.md", "reports/example_order.yaml", "reports/order.schema.json"),
}


@pytest.fixture
def lab(tmp_path):
    make_lab(tmp_path / "lab", load_registry())
    return tmp_path / "lab"


def files(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_lab_has_all_needed_files(lab):
    assert files(lab) == FILES
    assert load_station(lab / "station.yaml").model.plugins == "plugins"
    for path in (lab / "procedures").glob("*.yaml"):
        load_procedure(path)


def test_shipped_procedures_are_copied_unchanged(lab):
    for name in ("no_load_inertia_sweep", "starting_torque_1000n"):
        copy = lab / "procedures" / f"{name}.yaml"
        assert copy.read_bytes() == find_procedure(name).read_bytes()


def test_every_yaml_file_names_an_existing_schema(lab):
    for path in lab.rglob("*.yaml"):
        first = path.read_text(encoding="utf-8").splitlines()[0]
        target = first.removeprefix("# yaml-language-server: $schema=")
        assert (path.parent / target).is_file()


def test_schemas_include_plugins_of_lab_folder(lab):
    schema = json.loads((lab / "station.schema.json").read_text(encoding="utf-8"))
    plugins = schema["$defs"]["DeviceBinding"]["properties"]["plugin"]["enum"]
    assert {"room_thermometer", "swing_tester_sim"} <= set(plugins)
    assert "mean" in schema["$defs"]["RoomThermometerSettings"]["properties"]


@pytest.mark.parametrize("name", first(3, sorted(FILES)))
def test_nothing_is_written_if_one_file_exists(tmp_path, name):
    mine = tmp_path / "lab" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    with pytest.raises(UsageError, match=rf"has a {name} already.*files are never overwritten"):
        make_lab(tmp_path / "lab", load_registry())
    assert mine.read_text() == "mine"
    assert files(tmp_path / "lab") == {name}


def test_nothing_is_written_through_broken_link(tmp_path):
    lab, target = tmp_path / "lab", tmp_path / "elsewhere.md"
    lab.mkdir()
    (lab / "README.md").symlink_to(target)
    with pytest.raises(UsageError, match=r"README\.md: File exists"):
        make_lab(lab, load_registry())
    assert not target.exists()


def test_other_files_are_kept(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    assert make_lab(tmp_path, load_registry())
    assert files(tmp_path) == FILES | {"notes.txt"}


@pytest.mark.parametrize("name", ["lab", "lab/plugins"])
def test_file_in_place_of_folder_is_named_in_error(tmp_path, name):
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("a file")
    with pytest.raises(UsageError, match=f"{name}.*: (Not a directory|File exists)"):
        make_lab(tmp_path / "lab", load_registry())
