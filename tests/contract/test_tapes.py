"""Every device that can be tried without an instrument is recorded on tape and replayed."""

from __future__ import annotations

import threading

import pytest

from rigrunner.api.devices import DeviceContext, Readable, Settable, Streaming
from rigrunner.clock import SimulatedClock, WallClock
from rigrunner.registry import load_registry
from rigrunner.tape import RecordedTape, ReplayedTape, TapedFile, TapedPlugin, TapeManifest
from unit.rigrunner_plugins.devices.helpers_opcua import DRIVE, Bench

REGISTRY = load_registry()
FAULTY = {
    "plugin": "swing_tester_sim",
    "settings": {"seed": 3},
    "faults": [{"kind": "spikes", "extent": "0.5 N·m"}, {"kind": "nan", "calls": [2]}],
}
BY_NAME = {"swing_tester_ode": {"seed": 3}, "swing_tester_sim": {"seed": 3}, "fault": FAULTY}
TRIALS = {
    name: BY_NAME.get(name) or REGISTRY.find("device", name).record.trial
    for name in REGISTRY.names("device")
}
TRIED = {name: settings for name, settings in TRIALS.items() if settings}


def answers_of(device):
    """Use every ability of a device; return all its answers."""
    answers = [device.connect(5.0)]
    names = [info.name for info in device.channels]
    if isinstance(device, Readable):
        answers.append(device.read(names))
        answers += [device.read([name]) for name in names]
    if isinstance(device, Settable):
        for info in device.drives:
            device.set(info.name, info.safe_value + 0.25 * (info.maximum - info.safe_value))
            answers.append(device.read_back(info.name))
    if isinstance(device, Streaming):
        streamed = [info.name for info in device.channels if info.streams]
        for block in device.stream(streamed, 0.35, threading.Event()):
            samples = {name: values.tobytes() for name, values in block.channels.items()}
            answers.append((block.rate_hz, block.first_sample, block.monotonic_s, samples))
    answers += [device.make_safe(), device.make_safe()]
    device.close()
    device.close()
    return [repr(answer) for answer in answers]


def test_wired_devices_are_tried():
    wired = {name for name in TRIALS if REGISTRY.find("device", name).record.wired}
    assert {"visa", "modbus", "serial_ascii", "composite", "fault"} <= set(TRIED)
    assert wired == set(TRIED) & wired | {"opcua"}  # which has its own test below


def taped_and_played(name, settings, folder, gone):
    """Record a device, call `gone`, replay the tape; return the answers of both."""
    clock = SimulatedClock() if REGISTRY.is_simulated(name, settings) else WallClock()
    context = DeviceContext("it", clock, folder)
    plugin = TapedPlugin(plugin=name, provider="", settings_sha256="")
    manifest = TapeManifest(
        program="", began_utc=clock.utc(), station=TapedFile(id="", sha256=""),
        devices={"it": plugin},
    )  # fmt: skip
    with RecordedTape(folder / "tape") as tape:
        tape.begin(manifest)
        recorded = answers_of(REGISTRY.make_device(name, settings, context, tape))
    assert tape.notes() == ()
    gone()
    with ReplayedTape(folder / "tape") as replayed_tape:
        replayed = answers_of(REGISTRY.make_device(name, settings, context, replayed_tape))
        assert replayed_tape.notes() == ()
    return recorded, replayed


@pytest.mark.parametrize("name", TRIED)
def test_replay_gives_the_recorded_answers(name, tmp_path, monkeypatch):
    def gone():
        monkeypatch.setattr("socket.socket.connect", refuse_connection)
        monkeypatch.setattr("serial.Serial.open", refuse_connection)

    recorded, replayed = taped_and_played(name, TRIED[name], tmp_path, gone)
    assert replayed == recorded


def test_replay_gives_the_answers_of_an_opc_ua_server(tmp_path):
    bench = Bench(tmp_path).start()
    channels = {"torque": {"node": "ns=2;s=Torque", "unit": "N·m"}}
    settings = {"endpoint": bench.endpoint, "channels": channels, "drives": {"frequency": DRIVE}}
    recorded, replayed = taped_and_played("opcua", settings, tmp_path, bench.stop)
    assert replayed == recorded


def refuse_connection(*_):
    raise AssertionError("an instrument was asked")
