from __future__ import annotations

import shutil

import pytest

from helpers_tester import STATION
from rigrunner.api.errors import InvalidFileError
from rigrunner.api.hooks import DeviceRecord
from rigrunner.clock import SimulatedClock, WallClock
from rigrunner.registry import Plugin, Provider, Registry, load_registry
from rigrunner.run.lab_plugins import lab_registry
from rigrunner.run.planning import clock_for, planned_run
from rigrunner.station import parse_station
from rigrunner.tools.labfolder import make_lab

TEXT = STATION.read_text(encoding="utf-8")
REAL = "devices:\n  balance: {type: balance, plugin: real_balance}\n"


def record(name, *, simulated):
    def factory(settings, context):
        raise NotImplementedError

    record = DeviceRecord(name=name, help="", factory=factory, simulated=simulated)
    return Plugin("device", record, Provider("lab", ""))


REGISTRY = Registry(
    [record("tester_of_tests", simulated=True), record("real_balance", simulated=False)]
)


@pytest.mark.parametrize(
    ("text", "realtime", "kind"),
    [
        (TEXT, False, SimulatedClock),
        (TEXT, True, WallClock),
        (TEXT.replace("devices:\n", REAL), False, WallClock),
        (TEXT.replace("tester_of_tests", "no_such_plugin"), False, WallClock),
    ],
    ids=["simulated", "realtime", "one real device", "unknown plugin"],
)
def test_only_fully_simulated_station_runs_in_simulated_time(text, realtime, kind):
    station = parse_station(text, "test").model
    assert isinstance(clock_for(station, REGISTRY, realtime=realtime), kind)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    make_lab(folder, load_registry())
    return folder


def test_simulated_drop_in_keeps_simulated_time(lab):
    procedure, station = lab / "procedures" / "room_temperature.yaml", lab / "station.yaml"
    assert isinstance(planned_run(procedure, station).clock, SimulatedClock)
    assert isinstance(planned_run(procedure, station, realtime=True).clock, WallClock)


def test_plugins_of_station_are_loaded_only_with_it(lab):
    assert "room_thermometer" in lab_registry(str(lab / "station.yaml")).names("device")
    assert "room_thermometer" not in lab_registry(None).names("device")


def test_problems_of_both_files_are_reported_together(lab, tmp_path):
    procedure, station = tmp_path / "p.yaml", tmp_path / "s.yaml"
    text = (lab / "procedures" / "room_temperature.yaml").read_text(encoding="utf-8")
    procedure.write_text(text.replace("title:", "titel:"), encoding="utf-8")
    station.write_text(TEXT.replace("title:", "titel:"), encoding="utf-8")
    with pytest.raises(InvalidFileError) as caught:
        planned_run(procedure, station)
    files = {problem.location.file for problem in caught.value.problems}
    assert files == {str(procedure), str(station)}


def test_code_of_lab_plugins_runs_once(lab, tmp_path):
    folder = tmp_path / "lab"
    shutil.copytree(lab, folder)
    plugin = next(p for p in (folder / "plugins").glob("*.py") if not p.name.startswith("_"))
    runs = tmp_path / "runs.txt"
    count = f"\nwith open({str(runs)!r}, 'a') as file:\n    file.write('x')\n"
    plugin.write_text(plugin.read_text(encoding="utf-8") + count, encoding="utf-8")
    planned_run(folder / "procedures" / "room_temperature.yaml", folder / "station.yaml")
    assert runs.read_text(encoding="utf-8") == "x"
