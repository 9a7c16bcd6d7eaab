import pytest

from helpers_workflow import quick_procedure, station_file
from rigrunner.api.errors import InvalidFileError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.run.prepare import plan_run


def problems_of(procedure, station):
    with pytest.raises(InvalidFileError) as caught:
        plan_run(procedure, station, load_registry(), SimulatedClock())
    return {problem.field: problem.message for problem in caught.value.problems}


def test_all_problems_are_told_at_once_whatever_finds_them(tmp_path):
    procedure = quick_procedure(
        tmp_path,
        "starting_torque_1000n",
        ("parameters:\n  load: 1000 N", "parameters:\n  load: 1000 Hz"),
        ("channel: tester.torque", "channel: tester.torqe"),
        ("- template_inverse", "- template_invers"),
    )
    found = problems_of(procedure, station_file(tmp_path))
    assert set(found) == {
        "setup[4].zero.channel",
        "main[0].set.tester.load",
        "analysis[0].swing_torque.compensations[1]",
        "analysis[0].swing_torque.primary",
    }


def test_both_files_are_read_before_anything_is_told(tmp_path):
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep", ("uses:", "usses:"))
    station = station_file(tmp_path, ("mandrel: M-01", "mandrel: 7"))
    fields = set(problems_of(procedure, station))
    assert any("usses" in field for field in fields)
    assert "rig.mandrel" in fields


def test_unknown_device_plugins_and_their_settings_stop_before_the_plan(tmp_path):
    station = station_file(tmp_path, ("swing_tester_sim", "swing_tester_simm"))
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep")
    assert set(problems_of(procedure, station)) == {"devices.tester.plugin"}


def faulty_station(folder, settings):
    plugin, old = "plugin: swing_tester_sim", "settings: {seed: 1}"
    return station_file(folder, (plugin, "plugin: fault"), (old, f"settings: {settings}"))


@pytest.mark.parametrize(
    ("settings", "field", "message"),
    [
        ("{plugin: swing_testr_sim}", "settings.plugin", "there is no device 'swing_testr_sim'"),
        (
            "{plugin: swing_tester_sim, settings: {sed: 1}}",
            "settings.settings.sed",
            "unknown key 'sed'",
        ),
        (
            "{plugin: swing_tester_sim, faults: [{kind: nan, channel: torq}]}",
            "settings",
            "fault 1 (nan): the device has no channel 'torq'",
        ),
    ],
)
def test_a_wrapped_device_is_checked_as_any_other(tmp_path, settings, field, message):
    station = faulty_station(tmp_path, settings)
    found = problems_of(quick_procedure(tmp_path, "no_load_inertia_sweep"), station)
    assert set(found) == {f"devices.tester.{field}"}
    assert message in found[f"devices.tester.{field}"]


def test_a_wrapper_is_simulated_if_what_it_wraps_is():
    registry = load_registry()
    wrapped = {"plugin": "swing_tester_sim"}
    assert registry.is_simulated("fault", wrapped)
    assert registry.is_simulated("fault", {"plugin": "fault", "settings": wrapped})
