"""Drivers that talk in lines of text: over loopback, and with their simulator."""

from __future__ import annotations

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
    """Answers as the lamp does."""

    level = "0"

    def answer(self, request):
        if request.startswith("LEVEL "):
            self.level = request.removeprefix("LEVEL ")
            return "ok"
        return {"*IDN?": "Example,lamp,SIM,1.2", "LEVEL?": self.level}.get(request, "")


class Lamp(LineDriver):
    """Answers each line with one."""

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
    """Keeps what a driver tells."""

    def __init__(self):
        self.told = []

    def info(self, text, *values):
        self.told.append(("info", text % values))

    def warning(self, text, *values):
        self.told.append(("warning", text % values))

    def error(self, text, *values):
        self.told.append(("error", text % values))


def lamp(tmp_path, driver_class=Lamp, log=None, **settings):
    context = DeviceContext("lamp", SimulatedClock(), tmp_path, log=log or Log())
    return driver_class(LineSettings(**settings), context)


def failing(tmp_path, script):
    """Return what is raised by reading the level, how long that took, and the driver."""
    with peer(SCRIPT | script) as instrument:
        device = lamp(tmp_path, address=instrument.address, timeout="1 s")
        began = time.monotonic()
        try:
            device.connect(5.0)
            device.read(["level"])
        except Exception as error:  # noqa: BLE001  (whatever it is)
            return error, time.monotonic() - began, device
        finally:
            device.close()
    raise AssertionError("nothing failed")


def test_the_simulator_stands_in_for_the_instrument(tmp_path):
    device = lamp(tmp_path, simulated=True)
    identity = device.connect(1.0)
    assert (identity.maker, identity.model, identity.serial) == ("Example", "lamp", "SIM")
    assert identity.simulated
    device.set("level", 0.5)
    assert device.read(["level"]) == {"level": 0.5}
    assert device.make_safe() == {"level": 0.0}


def test_over_a_socket_the_very_bytes_are_as_written_down(tmp_path):
    with peer(SCRIPT) as instrument:
        device = lamp(tmp_path, address=instrument.address)
        identity = device.connect(1.0)
        assert (identity.serial, identity.firmware, identity.simulated) == ("0007", "1.2", False)
        assert device.read(["level"]) == {"level": 0.25}
        device.begin("level", 0.0)
        device.close()
    assert instrument.heard == [b"*IDN?\n", b"LEVEL?\n", b"LEVEL 0\n"]


def test_a_driver_has_its_own_terminator(tmp_path):
    script = {b"*IDN?\r\n": b"Example,lamp,0007,1.2\r\n", b"LEVEL?\r\n": b"1e-1\r\n"}
    with peer(script, b"\r\n") as instrument:
        device = lamp(tmp_path, LampOfCarriageReturns, address=instrument.address)
        device.connect(1.0)
        assert device.read(["level"]) == {"level": 0.1}
        device.close()


def test_nobody_at_the_address(tmp_path):
    with peer({}) as instrument:
        address = instrument.address
    with pytest.raises(DeviceNotFoundError, match=r"127\.0\.0\.1:\d+ cannot be reached.*address"):
        lamp(tmp_path, address=address).connect(1.0)


def test_no_answer_ends_in_time(tmp_path):
    error, took_s, _ = failing(tmp_path, {b"LEVEL?\n": b""})
    assert isinstance(error, DeviceTimeoutError)
    assert "did not answer 'LEVEL?' within 1 s" in str(error)
    assert took_s < 10.0


def test_the_time_is_that_of_the_whole_answer(tmp_path):
    """Two hundred pieces in 10 s; each comes within the 1 s, all of them do not."""
    error, took_s, _ = failing(tmp_path, {b"LEVEL?\n": (b"1",) * 200})
    assert isinstance(error, DeviceTimeoutError)
    assert took_s < 8.0


def test_an_answer_may_come_in_pieces(tmp_path):
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
def test_a_wrong_answer_says_what_came(tmp_path, answer, kind, text):
    error, _, _ = failing(tmp_path, {b"LEVEL?\n": answer})
    assert isinstance(error, kind)
    assert text in str(error)


@pytest.mark.parametrize("answer", [b"ERROR 3\n", b"a,b,c\n", b"a,b,c,d,e\n"])
def test_another_instrument_is_refused(tmp_path, answer):
    error, _, _ = failing(tmp_path, {b"*IDN?\n": answer})
    assert isinstance(error, DeviceNotFoundError)
    assert "is it the right instrument" in str(error)


def test_an_answer_that_comes_late_is_never_taken_for_another(tmp_path):
    """The connection is given up with what may still come over it, and opened again."""
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
    """A script of which some answers come once, and from then on others."""

    def __init__(self, script, once):
        super().__init__(script)
        self.once = once

    def get(self, line, default):
        return self.once.pop(line, None) or super().get(line, default)


@pytest.mark.parametrize("wrong", [(b"", b"0.75\n"), HANG_UP, b"n/a\n", b"1\n2\n"])
def test_the_next_call_is_answered_whatever_became_of_the_one_before(tmp_path, wrong):
    """A first answer that comes late (in two pieces, 0.05 s apart), none, or nonsense."""
    log = Log()
    with peer(Once(SCRIPT, {b"LEVEL?\n": wrong})) as instrument:
        device = lamp(tmp_path, address=instrument.address, timeout="0.02 s", log=log)
        device.connect(1.0)
        with pytest.raises(DeviceError):
            device.read(["level"])
        device.settings = device.settings.model_copy(update={"timeout": 2.0})
        for _ in range(3):
            assert device.read(["level"]) == {"level": 0.25}
        device.close()
    assert instrument.heard.count(b"*IDN?\n") == 2
    ((level, text),) = log.told
    assert level == "warning"
    assert text.startswith("reconnected to Example lamp 0007 after: ")


def test_another_instrument_is_refused_on_reconnecting_and_its_drives_are_left_alone(tmp_path):
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


def test_a_late_answer_on_a_serial_line_is_thrown_away(tmp_path):
    """A serial port gives what came late to who opens it next."""
    answers = iter([b"0.75\n"])

    def talk(heard):
        line, end, _ = heard.partition(b"\n")
        if line == b"LEVEL?" and (late := next(answers, None)):
            time.sleep(1.2)
            return len(line) + 1, late
        return (len(line) + 1, SCRIPT.get(line + end, b"")) if end else (0, b"")

    far = SerialPeer(talk)
    device = lamp(tmp_path, address=far.port, baud=115200, timeout="1 s")
    device.connect(1.0)
    with pytest.raises(DeviceTimeoutError):
        device.read(["level"])
    device.settings = device.settings.model_copy(update={"timeout": 5.0})
    assert device.read(["level"]) == {"level": 0.25}
    device.close()
    far.close()


def test_what_was_not_asked_for_is_refused(tmp_path):
    class Careless(Lamp):
        def put(self, drive, value):  # noqa: ARG002  (of one drive)
            self.tell(f"LEVEL {value:g}")  # but the instrument answers

    with peer(SCRIPT) as instrument:
        device = lamp(tmp_path, Careless, address=instrument.address)
        device.connect(1.0)
        device.begin("level", 0.0)
        while instrument.heard[-1] != b"LEVEL 0\n":
            time.sleep(0.01)
        time.sleep(0.2)
        with pytest.raises(DeviceLostError, match=r"sent b'ok.n' without being asked"):
            device.read(["level"])
        device.close()


def test_safety_opens_a_lost_connection_once_more(tmp_path):
    with peer(SCRIPT | {b"LEVEL 1\n": HANG_UP, b"LEVEL?\n": b"0\n"}) as instrument:
        device = lamp(tmp_path, address=instrument.address)
        device.connect(1.0)
        with pytest.raises(DeviceLostError):
            device.begin("level", 1.0)
        assert device.make_safe() == {"level": 0.0}
        device.close()
    assert instrument.heard[-4:-1] == [b"*IDN?\n", b"LEVEL 0\n", b"LEVEL?\n"]


def test_a_simulator_is_as_silent_as_the_instrument(tmp_path):
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
def test_an_address_that_cannot_be_is_refused(settings):
    with pytest.raises(
        ValidationError, match="expected host:port, a serial port, or 'simulated: yes'"
    ):
        LineSettings(**settings)


def lines_of(script):
    """Return what a SerialPeer is to answer."""

    def talk(heard):
        line, end, _ = heard.partition(b"\n")
        return (len(line) + 1, script.get(line + end, b"")) if end else (0, b"")

    return talk


@pytest.fixture
def wired(tmp_path):
    """Make a lamp behind a pseudo-terminal that answers as a script says."""
    peers, lamps = [], []

    def make(script):
        peers.append(SerialPeer(lines_of(SCRIPT | script)))
        lamps.append(lamp(tmp_path, address=peers[-1].port, baud=115200, timeout="1 s"))
        lamps[-1].connect(5.0)
        return lamps[-1], peers[-1]

    yield make
    for peer_ in (*lamps,):
        peer_.close()
    for peer_ in peers:
        peer_.unplug()


def test_over_a_serial_port_it_is_the_same(wired):
    device, _ = wired({})
    assert device.read(["level"]) == {"level": 0.25}
    device.begin("level", 0.0)


def test_a_silent_serial_instrument_ends_in_time(wired):
    device, _ = wired({b"LEVEL?\n": b""})
    began = time.monotonic()
    with pytest.raises(DeviceTimeoutError, match=r"did not answer 'LEVEL\?' within 1 s"):
        device.read(["level"])
    assert time.monotonic() - began < 10.0


def test_an_adapter_that_is_pulled_is_a_lost_device(wired):
    device, instrument = wired({})
    instrument.unplug()
    with pytest.raises(DeviceLostError, match="was lost at 'LEVEL"):
        device.read(["level"])


def test_a_serial_port_that_is_not_there(tmp_path):
    with pytest.raises(DeviceNotFoundError, match=r"ttyNone cannot be opened.*plugged in"):
        lamp(tmp_path, address="/dev/ttyNone").connect(1.0)


def test_without_pyserial_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(lines, "find_spec", lambda name: None)  # noqa: ARG005  (whatever is asked)
    with pytest.raises(MissingPackageError, match=r"rigrunner\[serial\]"):
        lamp(tmp_path, address="/dev/ttyUSB0")


def test_it_gives_up_before_the_station_gives_it_up(tmp_path):
    patience = Patience(answer_s=3.0)
    context = DeviceContext("lamp", SimulatedClock(), tmp_path, patience=patience)
    assert Lamp(LineSettings(simulated=True, timeout="2.9 s"), context)
    with pytest.raises(PluginError, match=r"timeout: got 3 s, expected less than 3 s .*patience"):
        Lamp(LineSettings(simulated=True, timeout="3 s"), context)


@pytest.mark.parametrize(
    "address", ["10.0.0.5:5025", "bench-3.lab:80", "[::1]:5025", "/dev/ttyUSB0", "COM3"]
)
def test_addresses(address):
    assert LineSettings(address=address).address == address


def test_its_settings_say_whether_it_is_simulated():
    record = DeviceRecord(name="lamp", help="A lamp.", settings=LineSettings, factory=Lamp)
    registry = Registry([Plugin("device", record, Provider("lab", "1"))])
    assert registry.is_simulated("lamp", {"simulated": True})
    assert not registry.is_simulated("lamp", {"address": "10.0.0.5:5025"})


@pytest.mark.parametrize("address", ["10.0.0.5:1", "10.0.0.5:65535", "[::1]:5025"])
def test_every_port_there_is_may_be_the_instruments(address):
    assert LineSettings(address=address).address == address


def test_an_instrument_on_the_network_needs_no_package_for_serial_ports(tmp_path, monkeypatch):
    monkeypatch.setattr(lines, "find_spec", lambda _name: None)
    lamp(tmp_path, address="10.0.0.5:5025")
    with pytest.raises(MissingPackageError, match="pyserial"):
        lamp(tmp_path, address="/dev/ttyUSB0")


@pytest.mark.parametrize(("address", "written"), [("", "nothing"), ("10.0.0.5", "'10.0.0.5'")])
def test_an_address_that_is_refused_is_told_as_it_was_written(address, written):
    with pytest.raises(ValidationError, match=f"address: got {written}, expected host:port"):
        LineSettings(address=address)


class DeafPort:
    """Takes all that is sent, and never has an answer."""

    def __init__(self):
        self.closed = False

    def ready(self, within_s):  # noqa: ARG002  (the Protocol's)
        return False

    def receive(self):
        raise AssertionError("nothing is there")

    def transmit(self, data, within_s):
        pass

    def close(self):
        self.closed = True


def test_a_port_is_closed_once_an_answer_is_given_up():
    """Else what comes late would wait there for the next line."""
    port = DeafPort()
    link = LineLink("lamp", port, "\n", 0.2)
    with pytest.raises(DeviceTimeoutError, match=r"lamp did not answer 'LEVEL\?' within 0.2 s"):
        link.ask("LEVEL?")
    assert port.closed
    with pytest.raises(DeviceLostError, match="abandoned after an earlier failure"):
        link.ask("LEVEL?")


def test_only_on_reconnecting_late_answers_on_a_serial_line_are_waited_for(wired, monkeypatch):
    waits_s = []
    monkeypatch.setattr(
        LineLink, "wait_for_silence", lambda _link, quiet_s: waits_s.append(quiet_s)
    )
    device, _ = wired({})
    assert waits_s == []
    device.reconnect()
    assert waits_s == [1.0]


def test_a_socket_has_no_late_answers_to_wait_for(tmp_path, monkeypatch):
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


def test_a_connection_that_is_opened_again_closes_the_one_before(tmp_path, monkeypatch):
    class Known(Lamp):
        def identify(self):
            return Identity("Example", "lamp", "0007", "1.2")

    ports = []

    def port(_address, _timeout_s):
        ports.append(DeafPort())
        return ports[-1]

    monkeypatch.setattr(lines, "TcpPort", port)
    device = lamp(tmp_path, Known, address="10.0.0.5:5025")
    device.connect(1.0)
    device.connect(1.0)
    assert [port.closed for port in ports] == [True, False]


def test_a_port_that_is_never_silent_is_waited_for_three_times_as_long(monkeypatch):
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
def test_a_port_that_fails_is_told_in_the_words_of_the_system(error, words):
    class Failing(DeafPort):
        def transmit(self, data, within_s):  # noqa: ARG002  (the Protocol's)
            raise error

    with pytest.raises(DeviceLostError) as raised:
        LineLink("lamp", Failing(), "\n", 0.2).ask("LEVEL?")
    assert raised.value.message == f"lamp was lost at 'LEVEL?': {words}"
