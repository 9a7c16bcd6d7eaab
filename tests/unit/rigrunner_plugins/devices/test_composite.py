"""One role from several instruments: what each is asked, and that none leaves another unsafe."""

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

    def _told(self, call):
        self.calls.append(call)
        self.before(call)

    def connect(self, timeout_s):  # noqa: ARG002
        self._told("connect")
        return self.identity

    def make_safe(self):
        self._told("make_safe")
        self.at = 0.0
        return {"frequency": self.at}

    def close(self):
        self._told("close")

    def set(self, drive, value):
        self._told(f"set {drive} {value:g}")
        self.at = value

    def read_back(self, drive):
        self._told(f"read_back {drive}")
        return self.at


class Press(Inverter):
    """A press whose load follows its set-point a while later, as the cell sees it."""

    drives = (replace(LOAD, settle_s=1.0, rate_per_s=None),)

    def begin(self, drive, value):
        self._told(f"begin {drive} {value:g}")
        self.at = value

    def arrived(self, drive):
        self._told(f"arrived {drive}")
        return True

    def make_safe(self):
        self._told("make_safe")
        self.at = 0.0
        return {"load": self.at}


class Cell:
    """Reads the force on the press, which comes nearer with every look."""

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


class StreamsAlone:
    """A card that gives no single values."""

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
    """A composite of four fakes, and what each was told."""

    def __init__(self, settings=None, answer_s=0.2, **others):
        press = others.pop("press", None) or Press()
        self.daq, self.inverter, self.press, self.cell = Daq(), Inverter(), press, Cell(press)
        for name, device in others.items():
            setattr(self, name, device)
        self.roles = []
        patience = Patience(connect_s=0.2, answer_s=answer_s)
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
    return lambda request: release.wait(5) if request.startswith(call) else None


def test_it_has_the_abilities_of_its_parts():
    device = Bench().device
    for ability in (Readable, Settable, Approaching, Streaming, Pausable):
        assert isinstance(device, ability)
    alone = {"parts": {"cell": {"plugin": "cell"}}, "channels": {"load": "cell.force"}}
    device = Bench(alone).device
    assert isinstance(device, Readable)
    assert not any(isinstance(device, ability) for ability in (Settable, Streaming, Pausable))


def test_channels_and_drives_have_the_names_of_the_role():
    device = Bench().device
    assert [info.name for info in device.channels] == ["torque", "angle", "load"]
    assert [info.streams for info in device.channels] == [True, True, False]
    assert [info.name for info in device.drives] == ["frequency", "load"]
    assert [info.unit for info in device.drives] == ["Hz", "N"]
    assert device.drives[0].sets_cycle_frequency


def test_each_part_is_asked_once_for_what_it_has():
    bench = Bench()
    values = bench.connected().read(["load", "torque", "angle"])
    assert list(values) == ["load", "torque", "angle"]
    assert bench.daq.calls == ["connect", "read torque,angle"]
    assert bench.cell.calls == ["read force"]


def test_who_answers_is_on_record_for_every_part():
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


def test_a_drive_is_read_back_from_the_part_that_measures_it():
    device = Bench().connected()
    device.begin("load", 1000.0)
    assert not device.arrived("load")
    seen = 0
    while not device.arrived("load"):
        seen += 1
    assert seen < 10
    assert device.read_back("load") == pytest.approx(1000.0, abs=30.0)


def test_how_near_the_measured_value_has_to_be_can_be_told():
    source = {"set": "press.load", "read_back": "cell.force", "tolerance": "400 N"}
    drives = {**SETTINGS["drives"], "load": source}
    device = Bench({**SETTINGS, "drives": drives}).connected()
    assert device.drives[1].tolerance == 400.0
    device.begin("load", 1000.0)
    assert device.arrived("load")  # the cell shows 700 N at the first look


def test_a_load_that_the_cell_does_not_see_is_not_reached():
    press = Press()
    bench = Bench(press=press, cell=Cell(Press()))
    bench.cell.press.at = 0.0
    device = bench.connected()
    with pytest.raises(DeviceTimeoutError, match=r"load reads back .* N after 1 s, set to 1000 N"):
        device.set("load", 1000.0)


def test_a_drive_is_not_set_beyond_its_limits():
    bench = Bench()
    device = bench.connected()
    with pytest.raises(DeviceRejectedError, match=r"load: 4000 N is out of range \(0 to"):
        device.begin("load", 4000.0)
    assert not [call for call in bench.press.calls if "begin" in call]


def test_the_engine_polls_it():
    bench = Bench()
    rig = Rig({"tester": bench.device}, SimulatedClock())
    rig.connect()
    looked = []
    rig.set("tester", "load", 1000.0, meanwhile=lambda: looked.append(1))
    assert len(looked) > 1


def test_all_are_made_safe_in_the_order_of_the_drives():
    bench = Bench()
    order = []
    for name in ("daq", "inverter", "press", "cell"):
        device_ = getattr(bench, name)
        plain = device_.make_safe
        device_.make_safe = lambda plain=plain, name=name: (order.append(name), plain())[1]
    device = bench.connected()
    device.set("load", 1000.0)
    safe = device.make_safe()
    assert order == ["inverter", "press", "daq", "cell"]
    assert safe["frequency"] == 0.0
    assert safe["load"] == pytest.approx(0.0, abs=30.0)


@pytest.mark.parametrize("error", [DeviceLostError("unplugged"), ValueError("a bug of the plugin")])
def test_a_part_that_cannot_be_made_safe_keeps_no_other_from_it(error):
    bench = Bench(inverter=Inverter(raising("make_safe", error)))
    device = bench.connected()
    device.set("load", 1000.0)
    with pytest.raises((DeviceLostError, DeviceRejectedError)) as caught:
        device.make_safe()
    assert bench.press.at == 0.0
    assert str(error) in str(caught.value)
    assert "frequency at 3 Hz, load at" in str(caught.value)


def test_what_a_part_reads_back_away_from_safe_is_told():
    bench = Bench()
    bench.inverter.make_safe = lambda: {"frequency": 2.0}
    device = bench.connected()
    with pytest.raises(DeviceRejectedError, match="inverter: frequency reads back 2, safe is 0 Hz"):
        device.make_safe()
    assert bench.press.calls[-1] == "make_safe"


def test_a_drive_of_a_part_that_is_not_read_back_is_not_safe():
    bench = Bench()
    bench.inverter.make_safe = dict
    device = bench.connected()
    with pytest.raises(DeviceRejectedError, match="inverter: frequency reads back nan, safe is 0"):
        device.make_safe()


def test_a_part_that_hangs_keeps_no_other_from_being_made_safe(monkeypatch):
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    release = threading.Event()
    inverter = Inverter(hanging("make_safe", release))
    inverter.non_blocking = False
    inverter.drives = (replace(FREQUENCY, rate_per_s=None),)
    bench = Bench(inverter=inverter)
    device = bench.connected()
    before = time.monotonic()
    with pytest.raises(DeviceTimeoutError, match="inverter: 'make safe' did not return"):
        device.make_safe()
    assert time.monotonic() - before < 10.0
    assert bench.press.calls[-1] == "make_safe"
    device.close()
    assert bench.press.calls[-1] == "close"
    release.set()


def test_a_part_that_hung_is_made_safe_from_a_fresh_thread(monkeypatch):
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
    device.begin("frequency", 0.0)  # to the safe value all the same
    assert inverter.at == 0.0
    with pytest.raises(DeviceRejectedError, match=r"inverter: 'set frequency' .* may still move"):
        device.make_safe()
    assert bench.press.calls[-1] == "make_safe"
    release.set()
    assert device.make_safe()["frequency"] == 0.0
    device.close()


def test_behind_a_set_that_comes_late_the_part_is_made_safe_once_more(monkeypatch):
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.05)
    release = threading.Event()

    def let_go_once_the_others_are_safe(request):
        if request == "make_safe":
            release.set()

    inverter = Inverter(hanging("set frequency 10", release))
    inverter.non_blocking = False
    bench = Bench(inverter=inverter, press=Press(let_go_once_the_others_are_safe))
    device = bench.connected()
    with pytest.raises(DeviceTimeoutError):
        device.begin("frequency", 10.0)
    monkeypatch.setattr(ThreadCaller, "grace_s", 5.0)
    assert device.make_safe()["frequency"] == 0.0
    assert inverter.at == 0.0
    assert inverter.calls.count("make_safe") == 2
    device.close()


def test_what_reads_goes_on_while_another_part_hangs(monkeypatch):
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


def test_all_are_connected_or_none():
    press = Press(raising("connect", DeviceNotFoundError("nobody there")))
    bench = Bench(press=press)
    with pytest.raises(DeviceNotFoundError, match="press: nobody there"):
        bench.device.connect(1.0)
    assert bench.inverter.calls[-2:] == ["make_safe", "close"]
    assert bench.daq.calls[-2:] == ["make_safe", "close"]
    assert "make_safe" not in press.calls
    with pytest.raises(DeviceLostError, match="not connected"):
        bench.device.read(["torque"])


def test_what_stays_energised_after_a_failed_connect_is_told():
    press = Press(raising("connect", DeviceNotFoundError("nobody there")))
    inverter = Inverter(raising("make_safe", DeviceLostError("unplugged")))
    with pytest.raises(DeviceNotFoundError, match="nobody there; then inverter: unplugged"):
        Bench(press=press, inverter=inverter).device.connect(1.0)


def test_all_are_closed_whatever_fails():
    bench = Bench(inverter=Inverter(raising("close", DeviceLostError("unplugged"))))
    device = bench.connected()
    with pytest.raises(DeviceLostError, match="inverter: unplugged"):
        device.close()
    assert bench.cell.calls[-1] == bench.press.calls[-1] == "close"


def test_a_pause_stops_what_moves_in_cycles_and_nothing_else():
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


def test_what_is_only_read_is_not_streamed():
    with pytest.raises(DeviceRejectedError, match="load cannot be recorded"):
        Bench().connected().stream(["torque", "load"], 0.1, threading.Event())


def test_a_part_that_only_streams_gives_a_short_mean():
    values = Bench(daq=StreamsAlone()).connected().read(["torque"])
    assert values["torque"] == pytest.approx(-0.01 + 1e-6 * 49.5)


def test_a_part_that_only_streams_is_not_read_while_it_records():
    device = Bench(daq=StreamsAlone()).connected()
    blocks = device.stream(["torque"], 1.0, threading.Event())
    next(blocks)
    with pytest.raises(DeviceRejectedError, match="daq: angle cannot be read while it records"):
        device.read(["angle"])
    blocks.close()
    assert device.read(["angle"])


def test_what_a_part_finds_of_its_stream_has_the_names_of_the_role():
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
    def spoil(whole):
        yield from whole[:blocks]
        raise DeviceLostError("unplugged")

    return spoil


def test_a_part_that_is_lost_in_a_recording_ends_the_run_with_all_others_safe():
    bench = Bench()
    bench.daq.spoil = lost_after(1)
    bench.inverter.at, bench.press.at = 0.0, 0.0
    kinds = Listener()
    drives = ("load", 1000.0, "N"), ("frequency", 10.0, "Hz")
    plan = plan_of(
        setup=(), main=(*(SetDrive("tester", *each) for each in drives), record("001_10Hz"))
    )
    summary = run(bench.device, plan, critical=[kinds])
    assert isinstance(summary.error, DeviceLostError)
    assert "tester: daq: unplugged" in str(summary.error)
    assert (bench.inverter.at, bench.press.at) == (0.0, 0.0)
    (event,) = kinds.of(MadeSafe)
    assert event.problems == ()


def test_a_rig_with_a_part_that_cannot_be_made_safe_is_not_called_safe():
    inverter = Inverter(raising("make_safe", DeviceLostError("no answer")))
    bench = Bench(inverter=inverter)
    bench.daq.spoil = lost_after(1)
    kinds = Listener()
    plan = plan_of(setup=(), main=(SetDrive("tester", "frequency", 10.0, "Hz"), record("001")))
    summary = run(bench.device, plan, critical=[kinds])
    assert "daq: unplugged" in str(summary.error)
    event = kinds.of(MadeSafe)[-1]
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
def test_what_a_part_lacks_is_told(change, message):
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


def test_the_stations_of_the_manual_are_taken():
    page = Path(__file__).parents[4] / "docs" / "how-to" / "combine-instruments.md"
    station, clocks = page.read_text(encoding="utf-8").split("```yaml\n")[1:3]
    text = station.partition("```")[0] + clocks.partition("```")[0]
    document = parse(text.replace("encoder: sync", "press: sync"), str(page))
    problems = validate(CompositeSettings, document, ("devices", "tester", "settings"))
    assert list(problems.parts) == ["daq", "press"]
    assert problems.clocks.latency == pytest.approx(0.002)
    assert load_registry().is_simulated(
        "composite", document.part(("devices", "tester", "settings"))
    )


def test_drives_are_read_back_while_one_part_streams_but_not_while_clocks_are_compared():
    """With several streaming parts the arrival of samples is a measurement of its own."""
    device = Bench().device
    assert device.reads_back_while_streaming
    load = device.channel_routes["load"]
    device.channel_routes["load"] = replace(load, info=replace(load.info, streams=True))
    assert not device.reads_back_while_streaming
