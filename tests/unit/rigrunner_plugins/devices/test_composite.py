"""One role from several instruments: calls of each, and that none leaves another unsafe."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest

from helpers_devices import CHANNELS, DRIVES, FakeTester, Listener, plan_of, record, run
from rigrunner.api.calling import ThreadCaller
from rigrunner.api.devices import (
    Approaching,
    ChannelInfo,
    DeviceContext,
    Identity,
    Patience,
    Pausable,
    Readable,
    Settable,
    Streaming,
)
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner.api.events import MadeSafe
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.rig import Rig
from rigrunner.run.provenance import identities, is_simulated
from rigrunner.steps.set_drives import SetDrive
from rigrunner.yamlfile import parse, validate
from rigrunner_plugins.devices.composite.device import make
from rigrunner_plugins.devices.composite.settings import CompositeSettings

LOAD, FREQUENCY = DRIVES


class Daq(FakeTester):
    """Streams angle and torque; has no drives."""

    def __init__(self):
        super().__init__(channels=CHANNELS[:2], drives=(), drives_at={})


class Inverter:
    """Sets the frequency, and reads nothing."""

    channels = ()
    drives = (FREQUENCY,)
    non_blocking = True

    def __init__(self, before=lambda _: None, identity=None):
        self.before, self.calls, self.at = before, [], 3.0
        self.identity = identity or Identity("Volts", "V20", "I-1")

    def _call(self, call):
        self.calls.append(call)
        self.before(call)

    def connect(self, timeout_s):  # noqa: ARG002
        self._call("connect")
        return self.identity

    def make_safe(self):
        self._call("make_safe")
        self.at = 0.0
        return {"frequency": self.at}

    def close(self):
        self._call("close")

    def set(self, drive, value):
        self._call(f"set {drive} {value:g}")
        self.at = value

    def read_back(self, drive):
        self._call(f"read_back {drive}")
        return self.at


class Press(Inverter):
    """A press whose load, as the cell measures it, follows its set-point with a delay."""

    drives = (replace(LOAD, settle_s=1.0, rate_per_s=None),)

    def begin(self, drive, value):
        self._call(f"begin {drive} {value:g}")
        self.at = value

    def arrived(self, drive):
        self._call(f"arrived {drive}")
        return True

    def make_safe(self):
        self._call("make_safe")
        self.at = 0.0
        return {"load": self.at}


class Cell:
    """Reads the force on the press, which comes nearer with every reading."""

    channels = (ChannelInfo("force", "N", "Force"),)
    drives = ()
    non_blocking = True

    def __init__(self, press):
        self.press, self.force, self.calls = press, 0.0, []

    def connect(self, timeout_s):  # noqa: ARG002
        return Identity("Weigh", "W1", "C-1")

    def make_safe(self):
        self.calls.append("make_safe")
        return {}

    def close(self):
        self.calls.append("close")

    def read(self, channels):
        self.calls.append(f"read {','.join(channels)}")
        self.force += 0.7 * (self.press.at - self.force)
        return dict.fromkeys(channels, self.force)


class StreamingCard:
    """A card that streams and has no single readings."""

    channels = CHANNELS[:2]
    drives = ()
    non_blocking = True
    sample_rate_hz = 1000.0

    def __init__(self):
        daq = Daq()
        self.connect, self.close, self.make_safe = daq.connect, daq.close, daq.make_safe
        self.stream = daq.stream


SETTINGS = {
    "parts": {name: {"plugin": name} for name in ("daq", "inverter", "press", "cell")},
    "channels": {"torque": "daq.torque", "angle": "daq.angle", "load": "cell.force"},
    "drives": {
        "frequency": "inverter.frequency",
        "load": {"set": "press.load", "read_back": "cell.force"},
    },
}


class Bench:
    """A composite of four fakes."""

    def __init__(self, settings=None, answer_s=0.2, **others):
        press = others.pop("press", None) or Press()
        self.daq, self.inverter, self.press, self.cell = Daq(), Inverter(), press, Cell(press)
        for name, device in others.items():
            setattr(self, name, device)
        self.roles = []
        patience = Patience(connect_s=5.0, answer_s=answer_s)
        context = DeviceContext(
            "tester", SimulatedClock(), Path(), make=self.make, patience=patience
        )
        self.device = make(CompositeSettings.model_validate(settings or SETTINGS), context)

    def make(self, plugin, settings, /, part=""):  # noqa: ARG002
        self.roles.append(part)
        return getattr(self, plugin)

    def connected(self):
        self.device.connect(1.0)
        return self.device


def raising(call, error):
    def before(request):
        if request.startswith(call):
            raise error

    return before


def hanging(call, release):
    return lambda request: release.wait(60) if request.startswith(call) else None


def test_composite_has_the_abilities_of_its_parts():
    device = Bench().device
    for ability in (Readable, Settable, Approaching, Streaming, Pausable):
        assert isinstance(device, ability)
    cell_only = {"parts": {"cell": {"plugin": "cell"}}, "channels": {"load": "cell.force"}}
    device = Bench(cell_only).device
    assert isinstance(device, Readable)
    assert not any(isinstance(device, ability) for ability in (Settable, Streaming, Pausable))


def test_channels_and_drives_have_the_names_of_the_role():
    device = Bench().device
    assert [info.name for info in device.channels] == ["torque", "angle", "load"]
    assert [info.streams for info in device.channels] == [True, True, False]
    assert [info.name for info in device.drives] == ["frequency", "load"]
    assert [info.unit for info in device.drives] == ["Hz", "N"]
    assert device.drives[0].sets_cycle_frequency


def test_each_part_is_read_once():
    bench = Bench()
    values = bench.connected().read(["load", "torque", "angle"])
    assert list(values) == ["load", "torque", "angle"]
    assert bench.daq.calls == ["connect", "read torque,angle"]
    assert bench.cell.calls == ["read force"]


def test_identity_of_every_part_is_recorded():
    parts = identities({"tester": Bench().device.connect(1.0)})
    assert parts == {
        "device tester": "Rigrunner composite of daq, inverter, press, cell (simulated)",
        "device tester/daq": "Fakes tester 1 (simulated)",
        "device tester/inverter": "Volts V20 I-1",
        "device tester/press": "Volts V20 I-1",
        "device tester/cell": "Weigh W1 C-1",
    }
    real = Identity("NI", "9237", "77")
    bench = Bench()
    bench.daq.connect = lambda _: real
    assert not is_simulated(identities({"tester": bench.device.connect(1.0)}))


def test_drive_is_read_back_from_the_part_that_measures_it():
    device = Bench().connected()
    device.begin("load", 1000.0)
    assert not device.arrived("load")
    count = 0
    while not device.arrived("load"):
        count += 1
    assert count < 10
    assert device.read_back("load") == pytest.approx(1000.0, abs=30.0)


def test_tolerance_of_the_measured_value_can_be_set():
    source = {"set": "press.load", "read_back": "cell.force", "tolerance": "400 N"}
    drives = {**SETTINGS["drives"], "load": source}
    device = Bench({**SETTINGS, "drives": drives}).connected()
    assert device.drives[1].tolerance == 400.0
    device.begin("load", 1000.0)
    assert device.arrived("load")  # the cell shows 700 N at the first reading


def test_load_that_the_cell_does_not_measure_times_out():
    press = Press()
    bench = Bench(press=press, cell=Cell(Press()))
    bench.cell.press.at = 0.0
    device = bench.connected()
    with pytest.raises(DeviceTimeoutError, match=r"load reads back .* N after 1 s, set to 1000 N"):
        device.set("load", 1000.0)


def test_drive_is_not_set_beyond_its_limits():
    bench = Bench()
    device = bench.connected()
    with pytest.raises(DeviceRejectedError, match=r"load: 4000 N is out of range \(0 to"):
        device.begin("load", 4000.0)
    assert not [call for call in bench.press.calls if "begin" in call]


def test_engine_polls_the_composite():
    bench = Bench()
    rig = Rig({"tester": bench.device}, SimulatedClock())
    rig.connect()
    polls = []
    rig.set("tester", "load", 1000.0, meanwhile=lambda: polls.append(1))
    assert len(polls) > 1


def test_parts_are_made_safe_in_the_order_of_the_drives():
    bench = Bench()
    order = []
    for name in ("daq", "inverter", "press", "cell"):
        device_ = getattr(bench, name)
        make_safe = device_.make_safe
        device_.make_safe = lambda plain=make_safe, name=name: (order.append(name), plain())[1]
    device = bench.connected()
    device.set("load", 1000.0)
    safe = device.make_safe()
    assert order == ["inverter", "press", "daq", "cell"]
    assert safe["frequency"] == 0.0
    assert safe["load"] == pytest.approx(0.0, abs=30.0)


@pytest.mark.parametrize("error", [DeviceLostError("unplugged"), ValueError("a bug of the plugin")])
def test_part_that_fails_to_be_made_safe_does_not_stop_the_others(error):
    bench = Bench(inverter=Inverter(raising("make_safe", error)))
    device = bench.connected()
    device.set("load", 1000.0)
    with pytest.raises((DeviceLostError, DeviceRejectedError)) as raised:
        device.make_safe()
    assert bench.press.at == 0.0
    assert str(error) in str(raised.value)
    assert "frequency at 3 Hz, load at" in str(raised.value)


def test_part_that_reads_back_away_from_safe_is_reported():
    bench = Bench()
    bench.inverter.make_safe = lambda: {"frequency": 2.0}
    device = bench.connected()
    with pytest.raises(DeviceRejectedError, match="inverter: frequency reads back 2, safe is 0 Hz"):
        device.make_safe()
    assert bench.press.calls[-1] == "make_safe"


def test_drive_that_is_not_read_back_is_not_safe():
    bench = Bench()
    bench.inverter.make_safe = dict
    device = bench.connected()
    with pytest.raises(DeviceRejectedError, match="inverter: frequency reads back nan, safe is 0"):
        device.make_safe()


def test_hanging_part_does_not_stop_the_others_from_being_made_safe(monkeypatch):
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    release = threading.Event()
    inverter = Inverter(hanging("make_safe", release))
    inverter.non_blocking = False
    inverter.drives = (replace(FREQUENCY, rate_per_s=None),)
    bench = Bench(inverter=inverter)
    device = bench.connected()
    start_s = time.monotonic()
    with pytest.raises(DeviceTimeoutError, match="inverter: 'make safe' did not return"):
        device.make_safe()
    assert time.monotonic() - start_s < 10.0
    assert bench.press.calls[-1] == "make_safe"
    device.close()
    assert bench.press.calls[-1] == "close"
    release.set()


def test_part_that_hung_is_made_safe_from_a_new_thread(monkeypatch):
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    release = threading.Event()
    inverter = Inverter(hanging("set frequency 10", release))
    inverter.non_blocking = False
    bench = Bench(inverter=inverter)
    device = bench.connected()
    with pytest.raises(DeviceTimeoutError, match="inverter: 'set frequency' did not return"):
        device.begin("frequency", 10.0)
    with pytest.raises(DeviceLostError, match="inverter: cannot set frequency"):
        device.begin("frequency", 5.0)
    device.begin("frequency", 0.0)  # the safe value is set nevertheless
    assert inverter.at == 0.0
    with pytest.raises(DeviceRejectedError, match=r"inverter: 'set frequency' .* may still move"):
        device.make_safe()
    assert bench.press.calls[-1] == "make_safe"
    release.set()
    assert device.make_safe()["frequency"] == 0.0
    device.close()


def test_part_is_made_safe_again_after_a_late_set(monkeypatch):
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    release = threading.Event()

    def release_once_the_others_are_safe(request):
        if request == "make_safe":
            release.set()

    inverter = Inverter(hanging("set frequency 10", release))
    inverter.non_blocking = False
    bench = Bench(inverter=inverter, press=Press(release_once_the_others_are_safe))
    device = bench.connected()
    with pytest.raises(DeviceTimeoutError):
        device.begin("frequency", 10.0)
    monkeypatch.setattr(ThreadCaller, "grace_s", 5.0)
    assert device.make_safe()["frequency"] == 0.0
    assert inverter.at == 0.0
    assert inverter.calls.count("make_safe") == 2
    device.close()


def test_reading_continues_while_another_part_hangs(monkeypatch):
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    release = threading.Event()
    inverter = Inverter(hanging("read_back", release))
    inverter.non_blocking = False
    device = Bench(inverter=inverter).connected()
    with pytest.raises(DeviceTimeoutError, match="inverter: 'read back frequency'"):
        device.read_back("frequency")
    assert device.read(["torque"])
    release.set()
    device.close()


def test_all_parts_are_connected_or_none():
    press = Press(raising("connect", DeviceNotFoundError("nobody there")))
    bench = Bench(press=press)
    with pytest.raises(DeviceNotFoundError, match="press: nobody there"):
        bench.device.connect(1.0)
    assert bench.inverter.calls[-2:] == ["make_safe", "close"]
    assert bench.daq.calls[-2:] == ["make_safe", "close"]
    assert "make_safe" not in press.calls
    with pytest.raises(DeviceLostError, match="not connected"):
        bench.device.read(["torque"])


def test_energised_part_after_a_failed_connect_is_reported():
    press = Press(raising("connect", DeviceNotFoundError("nobody there")))
    inverter = Inverter(raising("make_safe", DeviceLostError("unplugged")))
    with pytest.raises(DeviceNotFoundError, match="nobody there; then inverter: unplugged"):
        Bench(press=press, inverter=inverter).device.connect(1.0)


def test_all_parts_are_closed_despite_a_failure():
    bench = Bench(inverter=Inverter(raising("close", DeviceLostError("unplugged"))))
    device = bench.connected()
    with pytest.raises(DeviceLostError, match="inverter: unplugged"):
        device.close()
    assert bench.cell.calls[-1] == bench.press.calls[-1] == "close"


def test_pause_stops_only_what_moves_in_cycles():
    bench = Bench()
    device = bench.connected()
    device.set("frequency", 10.0)
    device.set("load", 1000.0)
    device.pause()
    assert (bench.inverter.at, bench.press.at) == (0.0, 1000.0)
    device.resume()
    assert bench.inverter.at == 10.0


def test_channels_of_one_part_are_streamed_under_the_names_of_the_role():
    settings = {**SETTINGS, "channels": {"moment": "daq.torque", "load": "cell.force"}}
    device = Bench(settings).connected()
    blocks = list(device.stream(["moment"], 0.25, threading.Event()))
    assert sum(block.samples for block in blocks) == 250
    assert {tuple(block.channels) for block in blocks} == {("moment",)}


def test_channel_without_samples_cannot_be_recorded():
    with pytest.raises(DeviceRejectedError, match="load cannot be recorded"):
        Bench().connected().stream(["torque", "load"], 0.1, threading.Event())


def test_part_that_only_streams_is_read_as_a_short_mean():
    values = Bench(daq=StreamingCard()).connected().read(["torque"])
    assert values["torque"] == pytest.approx(-0.01 + 1e-6 * 49.5)


def test_part_that_only_streams_is_not_read_while_it_records():
    device = Bench(daq=StreamingCard()).connected()
    blocks = device.stream(["torque"], 1.0, threading.Event())
    next(blocks)
    with pytest.raises(DeviceRejectedError, match="daq: angle cannot be read while it records"):
        device.read(["angle"])
    blocks.close()
    assert device.read(["angle"])


def test_stream_conditions_of_a_part_have_the_names_of_the_role():
    conditions = {
        "torque_filter_delay": (0.003, "s"),
        "torque_raw_filter_delay": (0.001, "s"),
        "angle_filter_delay": (0.0, "s"),
    }
    daq = Daq()
    raw = ChannelInfo("torque_raw", "N·m", "")
    daq.channels, daq.stream_conditions = (*CHANNELS[:2], raw), lambda: conditions
    device = Bench({**SETTINGS, "channels": {"moment": "daq.torque"}}, daq=daq).connected()
    list(device.stream(["moment"], 0.1, threading.Event()))
    assert device.stream_conditions() == {"moment_filter_delay": (0.003, "s")}


def lost_after(blocks):
    def spoil(stream):
        yield from stream[:blocks]
        raise DeviceLostError("unplugged")

    return spoil


def test_part_lost_in_a_recording_ends_the_run_with_the_others_safe():
    bench = Bench()
    bench.daq.spoil = lost_after(1)
    bench.inverter.at, bench.press.at = 0.0, 0.0
    events = Listener()
    drives = ("load", 1000.0, "N"), ("frequency", 10.0, "Hz")
    plan = plan_of(
        setup=(), main=(*(SetDrive("tester", *drive) for drive in drives), record("001_10Hz"))
    )
    summary = run(bench.device, plan, critical=[events])
    assert isinstance(summary.error, DeviceLostError)
    assert "tester: daq: unplugged" in str(summary.error)
    assert (bench.inverter.at, bench.press.at) == (0.0, 0.0)
    (event,) = events.of(MadeSafe)
    assert event.problems == ()


def test_part_that_cannot_be_made_safe_leaves_the_rig_unsafe():
    inverter = Inverter(raising("make_safe", DeviceLostError("no answer")))
    bench = Bench(inverter=inverter)
    bench.daq.spoil = lost_after(1)
    events = Listener()
    plan = plan_of(setup=(), main=(SetDrive("tester", "frequency", 10.0, "Hz"), record("001")))
    summary = run(bench.device, plan, critical=[events])
    assert "daq: unplugged" in str(summary.error)
    event = events.of(MadeSafe)[-1]
    assert event.problems
    assert "inverter: no answer" in str(event)
    assert "make_safe" in bench.press.calls


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"channels": {"torque": "daq.torq"}}, "the part 'daq' has no channel 'torq'"),
        ({"drives": {"load": "press.force"}}, "the part 'press' has no drive 'force'"),
        ({"drives": {"load": {"set": "press.load", "read_back": "daq.angle"}}}, "set in N, but"),
        (
            {"drives": {"load": {**SETTINGS["drives"]["load"], "tolerance": "1 Hz"}}},
            "tolerance is '1 Hz', it is set in N",
        ),
    ],
)
def test_missing_channel_or_drive_of_a_part_is_refused(change, message):
    with pytest.raises(PluginError, match=message):
        Bench({**SETTINGS, **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"channels": {"torque": "dak.torque"}}, "channel torque: 'dak.torque' belongs to no part"),
        ({"channels": {"torque": "torque"}}, "is not of the form part.name"),
        ({"parts": {}}, "at least 1 item"),
    ],
)
def test_settings_that_do_not_fit_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        CompositeSettings.model_validate({**SETTINGS, **change})


def test_stations_of_the_manual_are_valid():
    page = Path(__file__).parents[4] / "docs" / "how-to" / "combine-instruments.md"
    station, clocks = page.read_text(encoding="utf-8").split("```yaml\n")[1:3]
    text = station.partition("```")[0] + clocks.partition("```")[0]
    document = parse(text.replace("encoder: sync", "press: sync"), str(page))
    settings = validate(CompositeSettings, document, ("devices", "tester", "settings"))
    assert list(settings.parts) == ["daq", "press"]
    assert settings.clocks.latency == pytest.approx(0.002)
    assert load_registry().is_simulated(
        "composite", document.part(("devices", "tester", "settings"))
    )


def test_drives_are_read_back_in_a_stream_of_one_part_only():
    """With several streaming parts the arrival time of samples is itself measured."""
    device = Bench().device
    assert device.reads_back_while_streaming
    load = device.channel_routes["load"]
    device.channel_routes["load"] = replace(load, info=replace(load.info, streams=True))
    assert not device.reads_back_while_streaming
