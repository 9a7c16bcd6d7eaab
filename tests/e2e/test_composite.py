"""A role made of several instruments, from the station file to the sealed run."""

from __future__ import annotations

import numpy as np
import pytest

from helpers_workflow import quick_procedure, run, station_file
from rigrunner.api.errors import ExitCode, InvalidFileError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure
from rigrunner.run.prepare import plan_run
from rigrunner.runfile import read
from rigrunner.steps.measure import Measure
from rigrunner.yamlfile import parse
from rigrunner_bearings.api.torque import TorqueDetails

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
SETTINGS = ("devices", "tester", "settings")
QUICK = ("over: $frequencies", "over: [8 Hz, 15 Hz]")


@pytest.fixture
def station(tmp_path):
    (tmp_path / "plugins").mkdir()
    (tmp_path / "plugins" / "room_thermometer.py").write_text(ROOM)
    return station_file(tmp_path, (PLAIN, PARTS), ("\nrig:\n", "\nplugins: plugins\n\nrig:\n"))


def problems(procedure, station):
    with pytest.raises(InvalidFileError) as caught:
        plan_run(procedure, station, load_registry(), SimulatedClock())
    return "\n".join(str(problem) for problem in caught.value.problems)


def test_composite_records_the_same_as_one_device(tmp_path, station):
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep", QUICK)
    parts = run(procedure, tmp_path / "parts", station=station)
    whole = run(procedure, tmp_path / "whole")
    assert parts.error is None
    by_parts, as_one = read(parts.folder), read(whole.folder)
    assert len(by_parts.recordings) == len(as_one.recordings) == 2
    for part_recording, recording in zip(by_parts.recordings, as_one.recordings, strict=True):
        for name in ("tester.angle", "tester.torque"):
            assert np.array_equal(part_recording.channels[name], recording.channels[name])
        assert part_recording.conditions["tester.temperature"] == 294.65
        assert part_recording.conditions["tester.load"] == pytest.approx(0.0, abs=20.0)
    assert by_parts.header.provenance["device tester/room"] == "Therm T1 R-7"
    assert "SIM-0001 (simulated)" in by_parts.header.provenance["device tester/rig"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("plugin: room_thermometer", "plugin: room_thermo", (":26:24:", "did you mean")),
        ("{seed: 1}", "{sed: 1}", (":25:52:", "unknown key 'sed'")),
        ("load: rig.load\n", "load: rig.lod\n", (":24:", "the part 'rig' has no channel 'lod'")),
        ("angle: rig.angle", "angle: rigg.angle", (":24:", "belongs to no part")),
        ("angle: rig.angle", "angle: angle", (":28:16:", "is not of the form part.name")),
    ],
)
def test_problem_of_a_part_is_reported_with_its_place(tmp_path, station, old, new, told):
    place, message = told
    text = station.read_text()
    assert old in text
    station.write_text(text.replace(old, new, 1))
    output = problems(quick_procedure(tmp_path, "no_load_inertia_sweep"), station)
    assert message in output
    assert place in output, output


def test_channel_that_does_not_stream_cannot_be_recorded(tmp_path, station):
    recorded = ("channels: [tester.angle, tester.torque]", "channels: [tester.temperature]")
    output = problems(quick_procedure(tmp_path, "no_load_inertia_sweep", recorded), station)
    assert "tester.temperature cannot be recorded: it is read as a single value" in output
    assert "as a condition" in output


def test_channel_that_does_not_stream_is_averaged_by_reading(tmp_path, station):
    measured = (
        "- record: {channels: [tester.angle, tester.torque], cycles: 30}",
        "- measure: {name: room, channels: [tester.temperature], duration: 1 s}",
    )
    procedure = tmp_path / "p.yaml"
    text = find_procedure("no_load_inertia_sweep").read_text(encoding="utf-8")
    assert measured[0] in text
    procedure.write_text(text.replace(*measured).partition("\nanalysis:")[0], encoding="utf-8")
    planned = plan_run(procedure, station, load_registry(), SimulatedClock())
    (first, *_) = [s.action for s in planned.plan.steps if isinstance(s.action, Measure)]
    assert first.sample_rate_hz is None
    assert first.duration_s == 1.0


def test_source_of_each_channel_is_known(tmp_path, station):
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep")
    registry = plan_run(procedure, station, load_registry(), SimulatedClock()).registry
    settings = parse(station.read_text(encoding="utf-8"), "s").part(SETTINGS)
    assert registry.source("composite", settings, "torque") == ("swing_tester_sim", {"seed": 1})
    assert registry.source("composite", settings, "temperature") == ("room_thermometer", {})
    assert not registry.is_simulated("composite", settings)  # not all of its parts are


HALVES = """\
from dataclasses import replace

from rigrunner.api.hooks import DeviceRecord, hookimpl
from rigrunner.api.settings import Settings

api_version = 1
_rigs = {}


class HalfSettings(Settings):
    seed: int


class Half:
    # One simulated tester that two instruments record: the encoder what the bridge does.
    non_blocking = True

    def __init__(self, inner, streamed, role):
        self._inner = inner
        self._streamed = streamed
        self._begins = role.endswith("bridge")
        for name in set(dir(inner)) - set(dir(self)):
            setattr(self, name, getattr(inner, name))

    def stream(self, channels, duration_s, stop):
        if self._begins:
            whole = self._inner.stream(("angle", "torque"), duration_s, stop)
            self._streamed[:] = list(whole)
        for block in self._streamed:
            at_s = block.first_sample / block.rate_hz
            part = {name: block.channels[name] for name in channels}
            yield replace(block, monotonic_s=at_s, channels=part)


def make(settings, context):
    key = (id(context.clock), context.role.partition("/")[0])
    if key not in _rigs:
        still = {"speed_jitter": "0 %", "seed": settings.seed}
        _rigs[key] = context.make("swing_tester_sim", still), []
    return Half(*_rigs[key], context.role)


@hookimpl
def rigrunner_devices():
    return [
        DeviceRecord(name="half", help="Half.", settings=HalfSettings, factory=make, simulated=True)
    ]
"""
TWO_CLOCKS = """\
    plugin: composite
    settings:
      parts:
        bridge: {{plugin: half, settings: {{seed: 1}}}}
        encoder: {{plugin: half, settings: {{seed: 1}}}}
      channels:
        torque: bridge.torque
        angle: encoder.angle
        load: bridge.load
        temperature: bridge.temperature
      drives: {{frequency: bridge.frequency, load: bridge.load}}
      clocks: {{latency: {latency}}}
"""


def two_clocks(folder, latency):
    """Run both procedures on two instruments of unknown latency; return the loaded run."""
    (folder / "plugins").mkdir()
    (folder / "plugins" / "halves.py").write_text(HALVES)
    parts = TWO_CLOCKS.format(latency=latency)
    station = station_file(folder, (PLAIN, parts), ("\nrig:\n", "\nplugins: plugins\n\nrig:\n"))
    no_load = quick_procedure(folder, "no_load_inertia_sweep")
    bare = run(no_load, folder / "runs", station=station)
    assert bare.error is None
    loaded = quick_procedure(folder, "starting_torque_1000n")
    return run(loaded, folder / "runs", station=station, no_load=bare.folder)


@pytest.mark.thorough
def test_poorly_aligned_clocks_give_no_result(tmp_path):
    done = two_clocks(tmp_path, "10 ms")
    assert done.error is None
    recording = read(done.folder).recordings[0]
    # Nothing but the latency is unknown: two rectangular distributions of 10 ms, 10/sqrt(6).
    assert recording.conditions["tester.angle_alignment_u"] == pytest.approx(0.01 / np.sqrt(6))
    assert recording.units["tester.angle_alignment_u"] == "s"
    assert recording.conditions["tester.angle_clock_rate"] == pytest.approx(0.0, abs=1e-6)
    compensation = TorqueDetails.of(done.result).compensations["template_inverse"]
    assert "two clocks, aligned to 4.1 ms" in compensation.not_applicable
    assert done.result.headline is None
    assert TorqueDetails.of(done.result).compensations["paper_peak"].points  # it needs no angle
    assert done.exit_code == ExitCode.UNDECIDED
    page = (done.folder / "report.html").read_text(encoding="utf-8")
    assert "clock alignment" in page
    assert "two clocks, aligned to 4.1 ms" in page


@pytest.mark.thorough
def test_well_aligned_clocks_give_the_result_of_one_clock(tmp_path):
    done = two_clocks(tmp_path, "0.02 ms")
    assert done.error is None
    compensation = TorqueDetails.of(done.result).compensations["template_inverse"]
    assert compensation.not_applicable == ""
    assert compensation.checks[-1].ok
    for point in compensation.points:
        assert any(c.name == "alignment of the clocks" and c.u > 0 for c in point.components)
    assert done.result.headline.value == pytest.approx(0.7262, abs=2 * done.result.headline.u)
