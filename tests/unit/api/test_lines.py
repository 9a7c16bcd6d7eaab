"""Drivers of line-based instruments: over loopback, and with their simulator."""

from __future__ import annotations

import threading
import time
from types import SimpleNamespace

import pytest
from pydantic import ValidationError

from rigrunner.api import line_link, lines
from rigrunner.api.devices import ChannelInfo, DeviceContext, DriveInfo, Identity, Patience
from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    MissingPackageError,
    PluginError,
)
from rigrunner.api.hooks import DeviceRecord
from rigrunner.api.line_link import LineLink
from rigrunner.api.lines import LineDriver, LineSettings
from rigrunner.clock import SimulatedClock
from rigrunner.registry import Plugin, Provider, Registry
from unit.api.helpers_lines import HANG_UP, peer
from unit.rigrunner_plugins.devices.helpers_peers import SerialPeer

IDENTITY = b"Example,lamp,0007,1.2\n"
SCRIPT = {b"*IDN?\n": IDENTITY, b"LEVEL?\n": b"0.25\n", b"LEVEL 0\n": b"ok\n"}


class SimulatedLamp:
    """Answers like the lamp."""

    level = "0"

    def answer(self, request):
        if request.startswith("LEVEL "):
            self.level = request.removeprefix("LEVEL ")
            return "ok"
        return {"*IDN?": "Example,lamp,SIM,1.2", "LEVEL?": self.level}.get(request, "")


class Lamp(LineDriver):
    """Answers each line with one line."""

    channels = (ChannelInfo("level", "1", "Level"),)
    drives = (DriveInfo("level", "1", "Level", 0.0, 1.0),)
    simulator = SimulatedLamp

    def get(self, channel):
        return float(self.ask(f"{channel.upper()}?"))

    def put(self, drive, value):
        self.ask(f"{drive.upper()} {value:g}")


class LampOfCarriageReturns(Lamp):
    """The same with another terminator."""

    terminator = "\r\n"


class Log:
    """Keeps the messages of a driver."""

    def __init__(self):
        self.messages = []

    def info(self, text, *values):
        self.messages.append(("info", text % values))

    def warning(self, text, *values):
        self.messages.append(("warning", text % values))

    def error(self, text, *values):
        self.messages.append(("error", text % values))


def lamp(tmp_path, driver_class=Lamp, log=None, **settings):
    context = DeviceContext("lamp", SimulatedClock(), tmp_path, log=log or Log())
    return driver_class(LineSettings(**settings), context)


def failure_of(tmp_path, script):
    """Return the error of connecting and reading the level."""
    with peer(SCRIPT | script) as instrument:
        device = lamp(tmp_path, address=instrument.address, timeout="1 s")
        try:
            device.connect(5.0)
            device.read(["level"])
        except Exception as error:  # noqa: BLE001  (whatever it is)
            return error
        finally:
            device.close()
    raise AssertionError("nothing failed")


def test_simulator_replaces_the_instrument(tmp_path):
    device = lamp(tmp_path, simulated=True)
    identity = device.connect(1.0)
    assert (identity.maker, identity.model, identity.serial) == ("Example", "lamp", "SIM")
    assert identity.simulated
    device.set("level", 0.5)
    assert device.read(["level"]) == {"level": 0.5}
    assert device.make_safe() == {"level": 0.0}


def test_exact_bytes_are_sent_over_a_socket(tmp_path):
    with peer(SCRIPT) as instrument:
        device = lamp(tmp_path, address=instrument.address)
        identity = device.connect(1.0)
        assert (identity.serial, identity.firmware, identity.simulated) == ("0007", "1.2", False)
        assert device.read(["level"]) == {"level": 0.25}
        device.begin("level", 0.0)
        device.close()
    assert instrument.heard == [b"*IDN?\n", b"LEVEL?\n", b"LEVEL 0\n"]


def test_driver_may_set_its_terminator(tmp_path):
    script = {b"*IDN?\r\n": b"Example,lamp,0007,1.2\r\n", b"LEVEL?\r\n": b"1e-1\r\n"}
    with peer(script, b"\r\n") as instrument:
        device = lamp(tmp_path, LampOfCarriageReturns, address=instrument.address)
        device.connect(1.0)
        assert device.read(["level"]) == {"level": 0.1}
        device.close()


def test_unreachable_address_is_a_missing_device(tmp_path):
    with peer({}) as instrument:
        address = instrument.address
    with pytest.raises(DeviceNotFoundError, match=r"127\.0\.0\.1:\d+ cannot be reached.*address"):
        lamp(tmp_path, address=address).connect(1.0)


def test_missing_answer_times_out(tmp_path):
    error = failure_of(tmp_path, {b"LEVEL?\n": b""})
    assert isinstance(error, DeviceTimeoutError)
    assert "did not answer 'LEVEL?' within 1 s" in str(error)


def test_answer_may_arrive_in_pieces(tmp_path):
    with peer(SCRIPT | {b"LEVEL?\n": (b"0.", b"25", b"\n")}) as instrument:
        device = lamp(tmp_path, address=instrument.address)
        device.connect(1.0)
        assert device.read(["level"]) == {"level": 0.25}
        device.close()


@pytest.mark.parametrize(
    ("answer", "kind", "text"),
    [
        (b"0.25\r", DeviceTimeoutError, r"b'0.25\r' and no b'\n' within 1 s (does the instr"),
        (HANG_UP, DeviceLostError, "closed the connection at 'LEVEL?'"),
        (b"n/a\n", DeviceRejectedError, "'n/a'"),
        (b"\xff1\n", DeviceRejectedError, "expected one line of text"),
        (b"1\n2\n", DeviceRejectedError, "expected one line of text"),
        (b"9" * 70000, DeviceRejectedError, "more than 65536 bytes"),
    ],
)
def test_error_for_an_invalid_answer_shows_it(tmp_path, answer, kind, text):
    error = failure_of(tmp_path, {b"LEVEL?\n": answer})
    assert isinstance(error, kind)
    assert text in str(error)


@pytest.mark.parametrize("answer", [b"ERROR 3\n", b"a,b,c\n", b"a,b,c,d,e\n"])
def test_invalid_identity_is_refused(tmp_path, answer):
    error = failure_of(tmp_path, {b"*IDN?\n": answer})
    assert isinstance(error, DeviceNotFoundError)
    assert "is it the right instrument" in str(error)


def test_extra_line_is_not_taken_for_the_next_answer(tmp_path):
    """The connection is dropped, with anything still to come over it, and opened again."""
    with peer(SCRIPT | {b"LEVEL 1\n": b"ok\nlate\n"}) as instrument:
        device = lamp(tmp_path, address=instrument.address)
        device.connect(1.0)
        with pytest.raises(DeviceRejectedError, match="one line"):
            device.begin("level", 1.0)
        assert device.read(["level"]) == {"level": 0.25}
        device.close()
    assert instrument.heard == [
        b"*IDN?\n", b"LEVEL 1\n",
        b"*IDN?\n", b"LEVEL?\n",
    ]  # fmt: skip


class Once(dict):
    """A script with some answers that are given once, before the usual ones."""

    def __init__(self, script, once):
        super().__init__(script)
        self.once = once

    def get(self, line, default):
        return self.once.pop(line, None) or super().get(line, default)


@pytest.mark.parametrize("wrong", ["late", HANG_UP, b"n/a\n", b"1\n2\n"])
def test_call_after_a_failed_answer_succeeds(tmp_path, wrong):
    """The first answer is late, missing or invalid."""
    log, failed = Log(), threading.Event()
    wrong = (failed, b"0.75\n") if wrong == "late" else wrong
    with peer(Once(SCRIPT, {b"LEVEL?\n": wrong})) as instrument:
        device = lamp(tmp_path, address=instrument.address, timeout="1 s", log=log)
        device.connect(1.0)
        with pytest.raises(DeviceError):
            device.read(["level"])
        failed.set()
        device.settings = device.settings.model_copy(update={"timeout": 30.0})
        for _ in range(3):
            assert device.read(["level"]) == {"level": 0.25}
        device.close()
    assert instrument.heard.count(b"*IDN?\n") == 2
    ((level, text),) = log.messages
    assert level == "warning"
    assert text.startswith("reconnected to Example lamp 0007 after: ")


def test_other_instrument_on_reconnecting_is_refused_and_not_driven(tmp_path):
    once = {b"LEVEL?\n": HANG_UP, b"*IDN?\n": IDENTITY}
    script = {**SCRIPT, b"*IDN?\n": b"Example,lamp,0008,1.2\n"}
    with peer(Once(script, once)) as instrument:
        device = lamp(tmp_path, address=instrument.address)
        device.connect(1.0)
        with pytest.raises(DeviceLostError, match="closed the connection"):
            device.read(["level"])
        for use in (lambda: device.read(["level"]), device.make_safe):
            with pytest.raises(DeviceLostError, match=r"lamp 0008, but the run began with .* 0007"):
                use()
        device.close()
    assert b"LEVEL 0\n" not in instrument.heard


def test_late_answer_on_a_serial_line_is_discarded(tmp_path):
    """A serial port delivers late bytes to the next program that opens it."""
    answers, timed_out = iter([b"0.75\n"]), threading.Event()

    def talk(heard):
        line, end, _ = heard.partition(b"\n")
        if line == b"LEVEL?" and (late := next(answers, None)):
            assert timed_out.wait(30)
            time.sleep(0.2)
            return len(line) + 1, late
        return (len(line) + 1, SCRIPT.get(line + end, b"")) if end else (0, b"")

    serial_peer = SerialPeer(talk)
    device = lamp(tmp_path, address=serial_peer.port, baud=115200, timeout="1 s")
    device.connect(1.0)
    with pytest.raises(DeviceTimeoutError):
        device.read(["level"])
    timed_out.set()
    device.settings = device.settings.model_copy(update={"timeout": 5.0})
    assert device.read(["level"]) == {"level": 0.25}
    device.close()
    serial_peer.close()


def test_unsolicited_answer_is_refused(tmp_path):
    class Careless(Lamp):
        def put(self, drive, value):  # noqa: ARG002  (of one drive)
            self.tell(f"LEVEL {value:g}")  # but the instrument answers

    with peer(SCRIPT) as instrument:
        device = lamp(tmp_path, Careless, address=instrument.address)
        device.connect(1.0)
        device.begin("level", 0.0)
        assert device._link._port.ready(60.0)
        with pytest.raises(DeviceLostError, match=r"sent b'ok.n' without being asked"):
            device.read(["level"])
        device.close()


def test_make_safe_reopens_a_lost_connection(tmp_path):
    with peer(SCRIPT | {b"LEVEL 1\n": HANG_UP, b"LEVEL?\n": b"0\n"}) as instrument:
        device = lamp(tmp_path, address=instrument.address)
        device.connect(1.0)
        with pytest.raises(DeviceLostError):
            device.begin("level", 1.0)
        assert device.make_safe() == {"level": 0.0}
        device.close()
    assert instrument.heard[-4:-1] == [b"*IDN?\n", b"LEVEL 0\n", b"LEVEL?\n"]


def test_simulator_checks_for_missing_and_unexpected_answers(tmp_path):
    device = lamp(tmp_path, simulated=True)
    device.connect(1.0)
    with pytest.raises(DeviceTimeoutError, match="'COLOUR\\?' was not answered"):
        device.ask("COLOUR?")
    with pytest.raises(DeviceRejectedError, match="where no answer is expected"):
        device.tell("LEVEL 1")


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"address": "10.0.0.5"},
        {"address": "10.0.0.5:0"},
        {"address": "10.0.0.5:70000"},
        {"address": "10.0.0.5:65536"},
        {"address": "a b:5025"},
        {"address": "", "simulated": False},
        {"address": "nonsense", "simulated": True},
    ],
)
def test_invalid_address_is_refused(settings):
    with pytest.raises(
        ValidationError, match="expected host:port, a serial port, or 'simulated: yes'"
    ):
        LineSettings(**settings)


def lines_of(script):
    """Return the answers of a SerialPeer by a script."""

    def talk(heard):
        line, end, _ = heard.partition(b"\n")
        return (len(line) + 1, script.get(line + end, b"")) if end else (0, b"")

    return talk


@pytest.fixture
def wired(tmp_path):
    """Return a function that makes a lamp behind a pseudo-terminal with a script."""
    peers, lamps = [], []

    def make(script, timeout="9 s"):
        peers.append(SerialPeer(lines_of(SCRIPT | script)))
        lamps.append(lamp(tmp_path, address=peers[-1].port, baud=115200, timeout=timeout))
        lamps[-1].connect(5.0)
        return lamps[-1], peers[-1]

    yield make
    for peer_ in (*lamps,):
        peer_.close()
    for peer_ in peers:
        peer_.unplug()


def test_driver_works_over_a_serial_port(wired):
    device, _ = wired({})
    assert device.read(["level"]) == {"level": 0.25}
    device.begin("level", 0.0)


def test_silent_serial_instrument_times_out(wired):
    device, _ = wired({b"LEVEL?\n": b""}, timeout="1 s")
    with pytest.raises(DeviceTimeoutError, match=r"did not answer 'LEVEL\?' within 1 s"):
        device.read(["level"])


def test_unplugged_adapter_is_a_lost_device(wired):
    device, instrument = wired({})
    instrument.unplug()
    with pytest.raises(DeviceLostError, match="was lost at 'LEVEL"):
        device.read(["level"])


def test_missing_serial_port_is_a_missing_device(tmp_path):
    with pytest.raises(DeviceNotFoundError, match=r"ttyNone cannot be opened.*plugged in"):
        lamp(tmp_path, address="/dev/ttyNone").connect(1.0)


def test_missing_pyserial_names_the_extra_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(lines, "find_spec", lambda name: None)  # noqa: ARG005  (any package)
    with pytest.raises(MissingPackageError, match=r"rigrunner\[serial\]"):
        lamp(tmp_path, address="/dev/ttyUSB0")


def test_time_out_must_be_below_the_patience_of_the_station(tmp_path):
    patience = Patience(answer_s=3.0)
    context = DeviceContext("lamp", SimulatedClock(), tmp_path, patience=patience)
    assert Lamp(LineSettings(simulated=True, timeout="2.9 s"), context)
    with pytest.raises(PluginError, match=r"timeout: got 3 s, expected less than 3 s .*patience"):
        Lamp(LineSettings(simulated=True, timeout="3 s"), context)


@pytest.mark.parametrize(
    "address", ["10.0.0.5:5025", "bench-3.lab:80", "[::1]:5025", "/dev/ttyUSB0", "COM3"]
)
def test_valid_addresses_are_accepted(address):
    assert LineSettings(address=address).address == address


def test_settings_decide_whether_the_device_is_simulated():
    record = DeviceRecord(name="lamp", help="A lamp.", settings=LineSettings, factory=Lamp)
    registry = Registry([Plugin("device", record, Provider("lab", "1"))])
    assert registry.is_simulated("lamp", {"simulated": True})
    assert not registry.is_simulated("lamp", {"address": "10.0.0.5:5025"})


@pytest.mark.parametrize("address", ["10.0.0.5:1", "10.0.0.5:65535", "[::1]:5025"])
def test_all_port_numbers_are_accepted(address):
    assert LineSettings(address=address).address == address


def test_network_instrument_needs_no_pyserial(tmp_path, monkeypatch):
    monkeypatch.setattr(lines, "find_spec", lambda _name: None)
    lamp(tmp_path, address="10.0.0.5:5025")
    with pytest.raises(MissingPackageError, match="pyserial"):
        lamp(tmp_path, address="/dev/ttyUSB0")


@pytest.mark.parametrize(("address", "written"), [("", "nothing"), ("10.0.0.5", "'10.0.0.5'")])
def test_refused_address_is_shown_as_written(address, written):
    with pytest.raises(ValidationError, match=f"address: got {written}, expected host:port"):
        LineSettings(address=address)


class DeafPort:
    """Accepts everything that is sent, and never answers."""

    def __init__(self):
        self.closed = False
        self.waited_s = 0.0

    def ready(self, within_s):
        self.waited_s += within_s
        return False

    def receive(self):
        raise AssertionError("nothing is there")

    def transmit(self, data, within_s):
        pass

    def close(self):
        self.closed = True


def test_port_is_closed_after_a_time_out():
    """Otherwise a late answer would be read as that of the next line."""
    port = DeafPort()
    link = LineLink("lamp", port, "\n", 0.2)
    with pytest.raises(DeviceTimeoutError, match=r"lamp did not answer 'LEVEL\?' within 0.2 s"):
        link.ask("LEVEL?")
    assert 0.0 < port.waited_s <= 0.2
    assert port.closed
    with pytest.raises(DeviceLostError, match="abandoned after an earlier failure"):
        link.ask("LEVEL?")


def test_serial_line_waits_for_silence_only_on_reconnecting(wired, monkeypatch):
    waits_s = []
    monkeypatch.setattr(
        LineLink, "wait_for_silence", lambda _link, quiet_s: waits_s.append(quiet_s)
    )
    device, _ = wired({})
    assert waits_s == []
    device.reconnect()
    assert waits_s == [2.5]  # a quarter of the station's patience


def test_socket_does_not_wait_for_silence(tmp_path, monkeypatch):
    waits_s = []
    monkeypatch.setattr(
        LineLink, "wait_for_silence", lambda _link, quiet_s: waits_s.append(quiet_s)
    )
    with peer(SCRIPT) as instrument:
        device = lamp(tmp_path, address=instrument.address)
        device.connect(1.0)
        device.reconnect()
        device.close()
    assert waits_s == []


def test_connecting_again_closes_the_previous_port(tmp_path, monkeypatch):
    class Identified(Lamp):
        def identify(self):
            return Identity("Example", "lamp", "0007", "1.2")

    ports = []

    def port(_address, _timeout_s):
        ports.append(DeafPort())
        return ports[-1]

    monkeypatch.setattr(lines, "TcpPort", port)
    device = lamp(tmp_path, Identified, address="10.0.0.5:5025")
    device.connect(1.0)
    device.connect(1.0)
    assert [port.closed for port in ports] == [True, False]


def test_time_out_applies_to_the_whole_answer(monkeypatch):
    """Each piece comes within the time-out, but not all of them."""
    now_s = 0.0

    class Trickle(DeafPort):
        def ready(self, within_s):
            nonlocal now_s
            now_s += min(within_s, 0.4)
            return within_s > 0.0

        def receive(self):
            return b"1"

    monkeypatch.setattr(line_link, "time", SimpleNamespace(monotonic=lambda: now_s))
    with pytest.raises(DeviceTimeoutError, match=r"by b'1+' and no b'.n' within 1 s"):
        LineLink("lamp", Trickle(), "\n", 1.0).ask("LEVEL?")
    assert now_s == pytest.approx(1.0)


def test_wait_for_silence_is_limited_to_three_times_its_length(monkeypatch):
    now_s, heard = 0.0, []

    class Chatter(DeafPort):
        def ready(self, within_s):
            nonlocal now_s
            now_s += within_s
            return True

        def receive(self):
            heard.append(now_s)
            return b"?"

    monkeypatch.setattr(line_link, "time", SimpleNamespace(monotonic=lambda: now_s))
    LineLink("lamp", Chatter(), "\n", 0.2).wait_for_silence(0.5)
    assert heard == [0.5, 1.0, 1.5]


@pytest.mark.parametrize(
    ("error", "words"),
    [(OSError(5, "Input/output error"), "Input/output error"), (OSError("unplugged"), "unplugged")],
)
def test_port_error_has_the_message_of_the_system(error, words):
    class Failing(DeafPort):
        def transmit(self, data, within_s):  # noqa: ARG002  (the Protocol's)
            raise error

    with pytest.raises(DeviceLostError) as caught:
        LineLink("lamp", Failing(), "\n", 0.2).ask("LEVEL?")
    assert caught.value.message == f"lamp was lost at 'LEVEL?': {words}"
