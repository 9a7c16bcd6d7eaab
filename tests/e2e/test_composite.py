"""A role made of several instruments, from the station file to the sealed run."""

from __future__ import annotations

import numpy as np
import pytest

from helpers_workflow import quick_procedure, run, station_file
from rigrunner.api.errors import InvalidFileError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.runfile import read
from rigrunner.workflow.prepare import plan_run

PLAIN = """\
    plugin: swing_tester_sim
    settings: {seed: 1}
"""
PARTS = """\
    plugin: composite
    settings:
      parts:
        rig: {plugin: swing_tester_sim, settings: {seed: 1}}
        room: {plugin: room_thermometer}
      channels:
        angle: rig.angle
        torque: rig.torque
        load: rig.load
        temperature: room.temperature
      drives: {frequency: rig.frequency, load: rig.load}
"""
ROOM = """\
from rigrunner.api.devices import ChannelInfo, Identity
from rigrunner.api.hooks import DeviceRecord, hookimpl

api_version = 1

class Room:
    channels = (ChannelInfo("temperature", "K", "Room temperature"),)
    drives = ()
    non_blocking = False

    def connect(self, timeout_s):
        return Identity("Therm", "T1", "R-7")

    def make_safe(self):
        return {}

    def close(self):
        pass

    def read(self, channels):
        return dict.fromkeys(channels, 294.65)


@hookimpl
def rigrunner_devices():
    return [DeviceRecord(name="room_thermometer", help="Room.", factory=lambda *_: Room())]
"""
QUICK = ("over: $frequencies", "over: [8 Hz, 15 Hz]")


@pytest.fixture
def station(tmp_path):
    (tmp_path / "plugins").mkdir()
    (tmp_path / "plugins" / "room_thermometer.py").write_text(ROOM)
    return station_file(tmp_path, (PLAIN, PARTS), ("\nrig:\n", "\nplugins: plugins\n\nrig:\n"))


def problems(procedure, station):
    with pytest.raises(InvalidFileError) as caught:
        plan_run(procedure, station, load_registry(), SimulatedClock())
    return "\n".join(str(each) for each in caught.value.problems)


def test_a_run_on_parts_records_what_the_same_rig_records_as_one(tmp_path, station):
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep", QUICK)
    parts = run(procedure, tmp_path / "parts", station=station)
    whole = run(procedure, tmp_path / "whole")
    assert parts.error is None
    found, wanted = read(parts.folder), read(whole.folder)
    assert len(found.recordings) == len(wanted.recordings) == 2
    for mine, theirs in zip(found.recordings, wanted.recordings, strict=True):
        for name in ("tester.angle", "tester.torque"):
            assert np.array_equal(mine.channels[name], theirs.channels[name])
        assert mine.conditions["tester.temperature"] == 294.65
        assert mine.conditions["tester.load"] == pytest.approx(0.0, abs=20.0)
    assert found.header.provenance["device tester/room"] == "Therm T1 R-7"
    assert "SIM-0001 (simulated)" in found.header.provenance["device tester/rig"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("plugin: room_thermometer", "plugin: room_thermo", (":25:24:", "did you mean")),
        ("{seed: 1}", "{sed: 1}", (":24:52:", "unknown key 'sed'")),
        ("load: rig.load\n", "load: rig.lod\n", (":23:", "the part 'rig' has no channel 'lod'")),
        ("angle: rig.angle", "angle: rigg.angle", (":23:", "is of no part")),
        ("angle: rig.angle", "angle: angle", (":27:16:", "is not of the form part.name")),
    ],
)
def test_what_is_wrong_with_a_part_is_told_where_it_stands(tmp_path, station, old, new, told):
    place, message = told
    text = station.read_text()
    assert old in text
    station.write_text(text.replace(old, new, 1))
    found = problems(quick_procedure(tmp_path, "no_load_inertia_sweep"), station)
    assert message in found
    assert place in found, found


def test_a_channel_of_a_part_that_does_not_stream_is_no_column_of_a_recording(tmp_path, station):
    recorded = ("channels: [tester.angle, tester.torque]", "channels: [tester.temperature]")
    told = problems(quick_procedure(tmp_path, "no_load_inertia_sweep", recorded), station)
    assert "tester.temperature cannot be recorded: it is read as a single value" in told
    assert "as a condition" in told
