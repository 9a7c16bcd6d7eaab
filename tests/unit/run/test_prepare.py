import pytest

from helpers_tester import procedure_file, station_file
from rigrunner.api.errors import InvalidFileError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.run.prepare import plan_run

pytestmark = pytest.mark.usefixtures("tester")

READINGS = """\
rigrunner: procedure/2
id: T-READ
revision: A
title: Readings
uses: {tester: tester}
main:
  - measure: {channels: [tester.torque]}
analysis:
  - readings: {of: tester.torque, result: {name: torque, unit: N·m}}
"""
LIMITED = f"{READINGS}acceptance: {{limits: [{{of: torque, max: 9 N·m, source: sheet}}]}}\n"


def problems_of(procedure, station):
    with pytest.raises(InvalidFileError) as caught:
        plan_run(procedure, station, load_registry(), SimulatedClock())
    return {problem.field: problem.message for problem in caught.value.problems}


def test_all_problems_are_reported_together(tmp_path):
    procedure = procedure_file(
        tmp_path,
        "loaded",
        ("parameters:\n  load: 1000 N", "parameters:\n  load: 1000 Hz"),
        ("channel: tester.torque", "channel: tester.torqe"),
        ("{of: torque, max", "{of: torqe, max"),
        ("rule: guard_band_u", "rule: guard_bandu"),
    )
    problems = problems_of(procedure, station_file(tmp_path))
    assert set(problems) == {
        "setup[2].zero.channel",
        "main[0].set.tester.load",
        "acceptance.limits[0].of",
        "acceptance.rule",
    }


def test_problems_of_procedure_and_station_are_reported_together(tmp_path):
    procedure = procedure_file(tmp_path, "idle", ("uses:", "usses:"))
    station = station_file(tmp_path, ("serial: TQ-01", "serial: [7]"))
    fields = set(problems_of(procedure, station))
    assert any("usses" in field for field in fields)
    assert "instruments[0].serial" in fields


def test_unknown_device_plugin_is_the_only_problem(tmp_path):
    station = station_file(tmp_path, ("tester_of_tests", "tester_of_testsm"))
    procedure = procedure_file(tmp_path, "idle")
    assert set(problems_of(procedure, station)) == {"devices.tester.plugin"}


def test_missing_channels_of_invalid_device_are_not_reported(tmp_path):
    station = tmp_path / "station.yaml"
    station.write_text(
        "rigrunner: station/1\nid: bench\ntitle: A bench\ndevices:\n"
        "  tester: {type: tester, plugin: tester_of_tests, settings: {sed: 1}}\n",
        encoding="utf-8",
    )
    procedure = tmp_path / "readings.yaml"
    procedure.write_text(READINGS, encoding="utf-8")
    assert set(problems_of(procedure, station)) == {"devices.tester.settings.sed"}


@pytest.mark.parametrize(
    ("name", "hint", "more"),
    [("torqe", "did you mean 'torque'? there are: ", []), ("xyz", "there are: ", [True])],
)
def test_instrument_of_a_channel_that_its_device_lacks_is_named(tmp_path, name, hint, more):
    station = station_file(tmp_path, ("channel: tester.torque", f"channel: tester.{name}"))
    lines = station.read_text(encoding="utf-8").splitlines()
    line = next(number for number, text in enumerate(lines, 1) if f"tester.{name}" in text)
    procedure = tmp_path / "limited.yaml"
    procedure.write_text(LIMITED, encoding="utf-8")
    with pytest.raises(InvalidFileError) as caught:
        plan_run(procedure, station, load_registry(), SimulatedClock())
    problem, *others = caught.value.problems
    assert (problem.location.file, problem.location.line) == (str(station), line)
    assert problem.field == "instruments[0].channel"
    assert problem.message == f"the device in the role 'tester' has no channel '{name}'"
    assert problem.hint == f"{hint}angle, torque, load, temperature, frequency"
    # Where it is known which channel is meant, it does not lack an instrument too.
    assert ["there is no instrument" in other.message for other in others] == more


def test_instrument_may_be_of_a_drive(tmp_path):
    station = station_file(tmp_path, ("channel: tester.torque", "channel: tester.frequency"))
    procedure = procedure_file(tmp_path, "idle")
    plan_run(procedure, station, load_registry(), SimulatedClock())


def faulty_station(folder, settings):
    plugin, old = "plugin: tester_of_tests", "settings: {seed: 1}"
    return station_file(folder, (plugin, "plugin: fault"), (old, f"settings: {settings}"))


@pytest.mark.parametrize(
    ("settings", "field", "message"),
    [
        ("{plugin: tester_of_test}", "settings.plugin", "there is no device 'tester_of_test'"),
        (
            "{plugin: tester_of_tests, settings: {sed: 1}}",
            "settings.settings.sed",
            "unknown key 'sed'",
        ),
        (
            "{plugin: tester_of_tests, faults: [{kind: nan, channel: torq}]}",
            "settings",
            "fault 1 (nan): the device has no channel 'torq'",
        ),
    ],
)
def test_wrapped_device_is_checked_like_others(tmp_path, settings, field, message):
    station = faulty_station(tmp_path, settings)
    problems = problems_of(procedure_file(tmp_path, "idle"), station)
    assert set(problems) == {f"devices.tester.{field}"}
    assert message in problems[f"devices.tester.{field}"]


def test_wrapper_is_simulated_if_its_device_is():
    registry = load_registry()
    wrapped = {"plugin": "tester_of_tests"}
    assert registry.is_simulated("fault", wrapped)
    assert registry.is_simulated("fault", {"plugin": "fault", "settings": wrapped})
