"""Every device that can be tried without an instrument is taped, and played back without one."""

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


def used(device):
    """Use a device in every way that it has; return all that it said."""
    told = [device.connect(5.0)]
    names = [info.name for info in device.channels]
    if isinstance(device, Readable):
        told.append(device.read(names))
        told += [device.read([name]) for name in names]
    if isinstance(device, Settable):
        for info in device.drives:
            device.set(info.name, info.safe_value + 0.25 * (info.maximum - info.safe_value))
            told.append(device.read_back(info.name))
    if isinstance(device, Streaming):
        streamed = [info.name for info in device.channels if info.streams]
        for block in device.stream(streamed, 0.35, threading.Event()):
            samples = {name: values.tobytes() for name, values in block.channels.items()}
            told.append((block.rate_hz, block.first_sample, block.monotonic_s, samples))
    told += [device.make_safe(), device.make_safe()]
    device.close()
    device.close()
    return [repr(each) for each in told]


def test_those_that_talk_to_instruments_are_tried():
    wired = {name for name in TRIALS if REGISTRY.find("device", name).record.wired}
    assert {"visa", "modbus", "serial_ascii", "composite", "fault"} <= set(TRIED)
    assert wired == set(TRIED) & wired | {"opcua"}  # which has a test of its own below


def taped_and_played(name, settings, folder, gone):
    """Record a device, let its instrument be `gone`, and play it back; return what both said."""
    clock = SimulatedClock() if REGISTRY.is_simulated(name, settings) else WallClock()
    context = DeviceContext("it", clock, folder)
    plugin = TapedPlugin(plugin=name, provider="", settings_sha256="")
    manifest = TapeManifest(
        program="", began_utc=clock.utc(), station=TapedFile(id="", sha256=""),
        devices={"it": plugin},
    )  # fmt: skip
    with RecordedTape(folder / "tape") as tape:
        tape.begin(manifest)
        told = used(REGISTRY.make_device(name, settings, context, tape))
    assert tape.notes() == ()
    gone()
    with ReplayedTape(folder / "tape") as played:
        again = used(REGISTRY.make_device(name, settings, context, played))
        assert played.notes() == ()
    return told, again


@pytest.mark.parametrize("name", TRIED)
def test_what_it_said_is_said_again_without_it(name, tmp_path, monkeypatch):
    def gone():
        monkeypatch.setattr("socket.socket.connect", _asked)
        monkeypatch.setattr("serial.Serial.open", _asked)

    told, again = taped_and_played(name, TRIED[name], tmp_path, gone)
    assert again == told


def test_what_an_opc_ua_server_said_is_said_again_without_it(tmp_path):
    bench = Bench(tmp_path).start()
    channels = {"torque": {"node": "ns=2;s=Torque", "unit": "N·m"}}
    settings = {"endpoint": bench.endpoint, "channels": channels, "drives": {"frequency": DRIVE}}
    told, again = taped_and_played("opcua", settings, tmp_path, bench.stop)
    assert again == told


def _asked(*_):
    raise AssertionError("an instrument was asked")
