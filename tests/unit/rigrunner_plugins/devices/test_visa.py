"""Instruments behind VISA: messages sent, answers read, and reports of failures."""

from __future__ import annotations

import socket
import threading

import pytest

from rigrunner.api.devices import Approaching, Device, Identity, Readable, Streaming
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner_plugins.devices.visa.opening import _socket_of
from unit.rigrunner_plugins.devices.helpers_instruments import REGISTRY, instrument, merged
from unit.rigrunner_plugins.devices.helpers_peers import (
    HANG_UP,
    SILENCE,
    Lines,
    SerialPeer,
    SocketPeer,
    peer,
)

SOURCE = {
    "termination": "LF",
    "timeout": "1500 ms",
    "identification": {"expect": "ACME,.*"},
    "error_queue": {},
    "on_connect": ["*CLS"],
    "channels": {"torque": {"query": "MEAS:TORQ?", "unit": "mN·m", "unit_in_answer": "mNm"}},
    "drives": {
        "speed": {
            "command": "SOUR:SPE {value:.1f}",
            "read_back": "SOUR:SPE?",
            "unit": "rpm",
            "min": "0 rpm",
            "max": "1200 rpm",
            "safe": "0 rpm",
        }
    },
    "safe_commands": ["OUTP OFF"],
}


class Instrument:
    """Understands the messages of SOURCE; `answers` replaces some of its answers."""

    def __init__(self):
        self.speed = "600.0"
        self.errors = []
        self.answers = {}
        self.ending = "\n"
        self.late = {}
        """By line: the event that its answer waits for."""
        self.prefixes = {}
        """By line: what comes before its answer, once."""

    def __call__(self, line):
        if line in self.late:
            self.late.pop(line).wait(60)
        return self.prefixes.pop(line, b"") + self.answer(line)

    def answer(self, line):
        if line in self.answers:
            answer = self.answers[line]
            return answer if isinstance(answer, bytes) else f"{answer}{self.ending}".encode()
        if line.startswith("SOUR:SPE "):
            self.speed = line.split()[1]
            return SILENCE
        answers = {
            "*IDN?": "ACME,T-10,0,1.2",
            "MEAS:TORQ?": "1500.0 mNm",
            "SOUR:SPE?": self.speed,
            "SYST:ERR?": self.errors.pop(0) if self.errors else '0,"No error"',
        }
        return f"{answers[line]}{self.ending}".encode() if line in answers else SILENCE


@pytest.fixture
def acme():
    return Instrument()


@pytest.fixture
def talk(acme):
    return Lines(acme)


@pytest.fixture
def bench(talk):
    with peer(SocketPeer, talk) as server:
        yield server


@pytest.fixture
def device(bench):
    device = instrument("visa", merged(SOURCE, resource=bench.resource))
    yield device
    device.close()


@pytest.fixture
def connected(device):
    device.connect(2.0)
    return device


def test_device_streams_only_with_a_stream_setting(device):
    assert all(isinstance(device, ability) for ability in (Device, Readable, Approaching))
    assert not isinstance(device, Streaming)


def test_identity_is_read_and_commands_are_sent_on_connect(device, talk):
    assert device.connect(2.0) == Identity("ACME", "T-10", "", "1.2")
    assert talk.heard == ["*IDN?", "SYST:ERR?", "*CLS", "SYST:ERR?"]


def test_channel_is_queried_and_converted_from_its_unit(connected):
    assert connected.read(["torque"]) == {"torque": pytest.approx(1.5)}


def test_text_and_boolean_readings_are_queried(bench):
    readings = {
        "firmware": {"kind": "text", "query": "*IDN?", "pattern": ",([^,]*)$"},
        "quiet": {"kind": "boolean", "query": "SYST:ERR?", "yes": "0,.*", "no": "[^0].*"},
    }
    device = instrument("visa", merged(SOURCE, resource=bench.resource, readings=readings))
    device.connect(2.0)
    try:
        assert device.observe(["firmware", "quiet"]) == {"firmware": "1.2", "quiet": True}
        with pytest.raises(DeviceRejectedError, match="there is no reading 'torque'"):
            device.observe(["torque"])
    finally:
        device.close()


def test_drive_is_set_in_its_own_unit_and_read_back(connected, talk):
    connected.set("speed", 10.0)  # Hz: 600 rpm
    assert talk.heard[-3:] == ["SOUR:SPE 600.0", "SYST:ERR?", "SOUR:SPE?"]
    assert connected.read_back("speed") == 10.0


def test_making_safe_sends_the_safe_commands_last(connected, acme, talk):
    connected.set("speed", 10.0)
    assert connected.make_safe() == {"speed": 0.0}
    assert acme.speed == "0.0"
    assert talk.heard[-2:] == ["OUTP OFF", "SYST:ERR?"]


def test_instrument_error_names_the_command_that_caused_it(connected, acme):
    acme.errors = ['-222,"Data out of range"', '-350,"Queue overflow"']
    with pytest.raises(DeviceRejectedError) as raised:
        connected.set("speed", 10.0)
    assert str(raised.value) == (
        "the instrument does not accept 'SOUR:SPE 600.0':"
        ' -222,"Data out of range"; -350,"Queue overflow"'
    )


def test_errors_from_before_connecting_are_ignored(device, acme):
    acme.errors = ['-113,"Undefined header"']
    device.connect(2.0)


def test_query_does_not_wait_for_the_acknowledgement_of_a_command(connected):
    """Otherwise Nagle's algorithm and delayed acknowledgements add 40 ms to each set-point."""
    wire = _socket_of(connected._link._resource)
    assert wire.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


class TestSetupAfterFailure:
    """After silence or a lost connection its settings are unknown: it is set up again."""

    VERIFIED = merged(SOURCE, verify=[{"query": "UNIT?", "good": "NM"}])

    @pytest.fixture
    def device(self, bench, acme):
        acme.answers["UNIT?"] = "NM"
        device = instrument("visa", merged(self.VERIFIED, resource=bench.resource))
        device.connect(2.0)
        yield device
        device.close()

    @pytest.mark.parametrize("trouble", [SILENCE, HANG_UP], ids=["silence", "a lost connection"])
    def test_instrument_is_set_up_before_it_is_read_again(self, device, acme, talk, trouble):
        acme.answers["MEAS:TORQ?"] = trouble
        with pytest.raises((DeviceTimeoutError, DeviceLostError)):
            device.read(["torque"])
        del acme.answers["MEAS:TORQ?"]
        talk.heard.clear()
        assert device.read(["torque"]) == {"torque": 1.5}
        setup_messages = ["*IDN?", "SYST:ERR?", "*CLS", "SYST:ERR?", "UNIT?"]
        assert talk.heard == [*setup_messages, "MEAS:TORQ?"]

    def test_instrument_that_returned_in_another_unit_is_not_read(self, device, acme):
        acme.answers["MEAS:TORQ?"] = HANG_UP
        with pytest.raises(DeviceLostError):
            device.read(["torque"])
        del acme.answers["MEAS:TORQ?"]
        acme.answers["UNIT?"] = "INLB"
        for _ in range(2):
            with pytest.raises(DeviceRejectedError, match=r"not set as the station says"):
                device.read(["torque"])

    def test_instrument_with_other_settings_can_still_be_made_safe(self, device, acme, bench, talk):
        device.set("speed", 10.0)
        acme.answers["UNIT?"] = "INLB"
        bench.hang_up()
        assert device.make_safe() == {"speed": 0.0}
        assert acme.speed == "0.0"
        assert "*CLS" not in talk.heard[talk.heard.index("SOUR:SPE 600.0") :]
        with pytest.raises(DeviceRejectedError, match=r"not set as the station says"):
            device.read(["torque"])

    def test_instrument_that_was_never_set_up_can_be_made_safe(self, bench, acme):
        acme.answers["UNIT?"] = "INLB"
        device = instrument("visa", merged(self.VERIFIED, resource=bench.resource))
        with pytest.raises(DeviceRejectedError, match=r"not set as the station says"):
            device.connect(2.0)
        assert device.make_safe() == {"speed": 0.0}
        assert acme.speed == "0.0"
        device.close()


class TestIdentity:
    def test_another_instrument_is_refused_before_anything_is_sent(self, device, acme, talk):
        acme.answers["*IDN?"] = "OTHER,PSU,1,2"
        with pytest.raises(DeviceNotFoundError, match=r"'OTHER,PSU,1,2'.*does not fit 'ACME,\.\*'"):
            device.connect(2.0)
        assert talk.heard == ["*IDN?"]

    def test_unreachable_instrument_is_reported(self, device, bench):
        bench.close()
        with pytest.raises(DeviceNotFoundError, match=r"no answer from TCPIP::127\.0\.0\.1"):
            device.connect(2.0)

    def test_missing_port_is_reported(self):
        device = instrument("visa", merged(SOURCE, resource="ASRL/dev/ttyNONE9::INSTR"))
        with pytest.raises(DeviceNotFoundError, match="could not open port /dev/ttyNONE9"):
            device.connect(1.0)

    def test_instrument_with_other_settings_is_refused(self, bench, acme):
        acme.answers["UNIT?"] = "INLB"
        verify = [{"query": "UNIT?", "good": "NM"}]
        device = instrument("visa", merged(SOURCE, resource=bench.resource, verify=verify))
        with pytest.raises(DeviceRejectedError, match=r"not set as the station says.*'INLB'"):
            device.connect(2.0)

    def test_identity_without_four_fields_is_the_model(self, device, acme):
        acme.answers["*IDN?"] = "ACME, LSG 1234"
        assert device.connect(2.0).model == "ACME, LSG 1234"


class TestInvalidAnswers:
    @pytest.mark.parametrize(
        ("answer", "message"),
        [
            (
                "12.0 Nm",
                r"after the number is 'Nm', expected 'mNm'.*change `unit_in_answer`",
            ),
            ("1,5 mNm", r"after the number is ',5 mNm'"),
            ("OVER", "'OVER' is not a decimal number"),
            ("", "'' is not a decimal number"),
            ("+9.90000000E+37 mNm", "9.9e.37: the instrument reports overload"),
            ("9.91E37 mNm", "overload or 'not a number'"),
            ("nan mNm", "'nan mNm' is not a decimal number"),
        ],
    )
    def test_invalid_answers_are_refused_and_shown(self, connected, acme, answer, message):
        acme.answers["MEAS:TORQ?"] = answer
        with pytest.raises(DeviceRejectedError, match=message) as raised:
            connected.read(["torque"])
        assert "the answer to 'MEAS:TORQ?'" in str(raised.value)

    def test_missing_answer_times_out(self, connected, acme):
        acme.answers["MEAS:TORQ?"] = SILENCE
        with pytest.raises(DeviceTimeoutError, match=r"no answer to 'MEAS:TORQ\?' within 1.5 s"):
            connected.read(["torque"])

    def test_unknown_query_times_out_with_the_instrument_s_error(self, connected, acme):
        acme.answers["MEAS:TORQ?"] = SILENCE
        acme.errors = ['-113,"Undefined header"']
        with pytest.raises(
            DeviceTimeoutError, match='the instrument says: -113,"Undefined header"'
        ):
            connected.read(["torque"])

    def test_late_answer_is_not_taken_for_that_of_the_next_query(self, connected, acme):
        acme.late["MEAS:TORQ?"] = gave_up = threading.Event()
        with pytest.raises(DeviceTimeoutError):
            connected.read(["torque"])
        gave_up.set()
        assert connected.read_back("speed") == 10.0

    def test_unrequested_text_is_not_taken_for_an_answer(self, connected, acme):
        acme.answers["MEAS:TORQ?"] = b"1500.0 mNm\n77.7\n"
        connected.read(["torque"])
        with pytest.raises(DeviceRejectedError, match=r"had sent '77\.7.n' unasked.*`acknowledge`"):
            connected.read_back("speed")
        assert connected.read_back("speed") == 10.0

    @pytest.mark.parametrize(
        ("ending", "message"),
        [
            ("\r", "LF, as `termination` says"),
            ("\n\r", r"had sent '.r' unasked.*is `termination` right"),
        ],
    )
    def test_wrong_termination_is_reported(self, device, acme, ending, message):
        acme.ending = ending
        with pytest.raises((DeviceTimeoutError, DeviceRejectedError), match=message):
            device.connect(2.0)

    def test_wrong_termination_of_two_characters_is_reported(self, bench):
        settings = merged(
            SOURCE, resource=bench.resource, termination="CRLF", write_termination="LF"
        )
        with pytest.raises(DeviceRejectedError, match=r"'.*,1.2.n', which does not end with CRLF"):
            instrument("visa", settings).connect(2.0)


class TestUnexpectedAnswersToCommands:
    def test_answer_to_a_command_is_not_taken_for_a_read_back(self, bench, acme):
        acme.prefixes["SOUR:SPE?"] = b"OK\n"  # it comes after the next query was sent
        settings = merged(SOURCE, resource=bench.resource, error_queue=None)
        device = instrument("visa", settings)
        device.connect(2.0)
        with pytest.raises(DeviceRejectedError, match="'OK' is not a decimal number"):
            device.set("speed", 10.0)
        acme.speed = "1200.0"
        assert device.read_back("speed") == 20.0
        device.close()

    def test_answer_to_a_command_is_reported_as_not_accepted(self, connected, acme):
        acme.errors = ["OK"]  # it comes after the next query was sent
        with pytest.raises(DeviceRejectedError, match=r"does not accept .*: OK.*`acknowledge`"):
            connected.set("speed", 10.0)
        assert connected.read_back("speed") == 10.0


def test_safe_commands_are_sent_even_if_a_drive_does_not_move(bench, acme, talk):
    drive = {**SOURCE["drives"]["speed"], "settle": "100 ms"}
    device = instrument("visa", merged(SOURCE, resource=bench.resource, drives={"speed": drive}))
    device.connect(2.0)
    acme.answers["SOUR:SPE?"] = "600.0"
    with pytest.raises(DeviceTimeoutError, match=r"speed reads back 10 Hz after 0.1 s, set to 0"):
        device.make_safe()
    assert "OUTP OFF" in talk.heard
    device.close()


class TestLostConnections:
    def test_closed_connection_is_reported_as_lost(self, connected, acme):
        acme.answers["MEAS:TORQ?"] = HANG_UP
        with pytest.raises(
            DeviceLostError, match=r"'MEAS:TORQ.': the other end closed the connection"
        ):
            connected.read(["torque"])

    def test_calls_fail_as_lost_while_the_instrument_is_gone(self, connected, bench):
        bench.close()
        with pytest.raises(DeviceLostError):
            connected.read(["torque"])
        with pytest.raises(DeviceLostError, match=r"no answer from|cannot be opened"):
            connected.read(["torque"])

    def test_making_safe_connects_again(self, connected, bench, acme):
        connected.set("speed", 10.0)
        bench.hang_up()
        assert connected.make_safe() == {"speed": 0.0}
        assert acme.speed == "0.0"

    def test_making_safe_fails_without_an_instrument(self, connected, bench):
        connected.set("speed", 10.0)
        bench.close()
        with pytest.raises((DeviceLostError, DeviceNotFoundError, DeviceTimeoutError)):
            connected.make_safe()

    def test_closing_twice_is_permitted(self, connected):
        connected.close()
        connected.close()
        with pytest.raises(DeviceLostError, match="not connected"):
            connected.read(["torque"])


class TestSerialLine:
    SERIAL = merged(SOURCE, termination="CRLF", serial={"baud": 115200})

    def test_instrument_on_a_serial_line_reads_and_sets(self, acme):
        acme.ending = "\r\n"
        with peer(SerialPeer, Lines(acme, b"\r\n")) as far:
            device = instrument("visa", merged(self.SERIAL, resource=far.resource))
            assert device.connect(2.0).model == "T-10"
            device.set("speed", 20.0)
            assert device.read(["torque"]) == {"torque": 1.5}
            device.close()

    def test_unplugged_serial_line_is_reported_as_lost(self, acme):
        acme.ending = "\r\n"
        with peer(SerialPeer, Lines(acme, b"\r\n")) as far:
            device = instrument("visa", merged(self.SERIAL, resource=far.resource))
            device.connect(2.0)
            far.unplug()
            with pytest.raises(DeviceLostError, match=r"could not be|no answer|Input/output"):
                device.read(["torque"])
            with pytest.raises(DeviceLostError, match="cannot be opened"):
                device.read(["torque"])
            device.close()


class TestAcknowledgedCommands:
    SETTINGS = merged(SOURCE, acknowledge="OK", error_queue=None, on_connect=None)

    def test_expected_answer_acknowledges_a_command(self, bench, acme):
        acme.answers |= {"SOUR:SPE 600.0": "OK"}
        acme.speed = "600.0"
        device = instrument("visa", merged(self.SETTINGS, resource=bench.resource))
        device.connect(2.0)
        device.set("speed", 10.0)
        assert device.read(["torque"]) == {"torque": 1.5}
        device.close()

    def test_other_answer_refuses_a_command(self, bench, acme):
        acme.answers |= {"SOUR:SPE 600.0": "ERR 7"}
        device = instrument("visa", merged(self.SETTINGS, resource=bench.resource))
        device.connect(2.0)
        with pytest.raises(DeviceRejectedError, match=r"'SOUR:SPE 600.0': it answers 'ERR 7'"):
            device.set("speed", 10.0)
        device.close()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"resource": "COM3"}, "got 'COM3', expected a VISA name such as TCPIP::192"),
        ({"resource": "192.168.0.7:5025"}, "expected a VISA name"),
        ({"termination": "CLRF"}, "got 'CLRF', expected one of: LF, CR, CRLF"),
        ({"termination": None}, "termination: Field required"),
        ({"termination": "none"}, "need a terminator"),
        ({"backend": "@evil"}, "got '@evil', expected @py, @ivi or FILE.yaml@sim"),
        ({"backend": "/opt/evil.so@ivi"}, "backend"),
        ({"backend": "@sim"}, "backend @sim is a simulation: write 'simulated: yes'"),
        ({"simulated": "yes"}, "backend @py talks to an instrument: simulated needs @sim"),
        ({"serial": {"baud": 9600, "parity": "even"}}, "is not a serial line"),
        ({"identification": {"expect": "(ACME"}}, "is not a regular expression"),
        ({"channels": {}, "drives": {}}, "neither channels nor drives"),
        ({"channels": {"torque": {"query": "T?", "unit": "N·m", "pattern": "T=.*"}}}, "one group"),
        ({"channels": {"t": {"query": "T?", "unit": "K", "pattern": "(.*)", "field": 2}}}, "two"),
    ],
)
def test_invalid_settings_are_refused(changes, message):
    settings = {"resource": "TCPIP::127.0.0.1::5025::SOCKET", **SOURCE}
    with pytest.raises(PluginError, match=message):
        instrument("visa", merged(settings, **changes))


@pytest.mark.parametrize(
    "command", ["SOUR:SPE", "S {value} {value}", "S {value.real}", "S {speed}"]
)
def test_command_must_contain_the_set_point_once(command):
    drive = {**SOURCE["drives"]["speed"], "command": command}
    settings = merged(SOURCE, resource="GPIB0::5::INSTR", drives={"speed": drive})
    with pytest.raises(PluginError, match="has to hold the set-point once"):
        instrument("visa", settings)


@pytest.mark.parametrize(
    ("command", "tolerance", "message"),
    [
        ("SPE {value:.0f}", "0.3 rpm", "rounds a set-point by 0.008"),  # 0.5 rpm are 0.0083 Hz
        ("SPE {value:.0f}", "0.6 rpm", ""),
        ("SPE {value:.3g}", "1 rpm", "rounds a set-point"),  # 1195 rpm are sent as 1.2e+03
        ("SPE {value}", "0.001 rpm", ""),
    ],
)
def test_command_that_rounds_beyond_the_tolerance_is_refused(command, tolerance, message):
    drive = {**SOURCE["drives"]["speed"], "command": command, "tolerance": tolerance}
    settings = merged(SOURCE, resource="GPIB0::5::INSTR", drives={"speed": drive})
    if message:
        with pytest.raises(PluginError, match=message):
            instrument("visa", settings)
    else:
        instrument("visa", settings)


def test_missing_package_names_the_extra(device, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyvisa", None)
    with pytest.raises(PluginError, match=r"'pyvisa' is not installed.*rigrunner\[visa\]"):
        device.connect(1.0)


def test_serial_port_is_set_up_from_its_settings():
    line = {
        "baud": 4800,
        "data_bits": 7,
        "parity": "odd",
        "stop_bits": 2,
        "flow_control": "rts_cts",
    }
    trial = REGISTRY.find("device", "visa").record.trial
    device = instrument("visa", merged(trial, serial=line))
    device.connect(1.0)
    resource = device._link._resource
    assert (resource.baud_rate, resource.data_bits, resource.parity.name) == (4800, 7, "odd")
    assert (resource.stop_bits.name, resource.flow_control.name) == ("two", "rts_cts")
    device.close()


class TestTrial:
    """The trial in the plugin's record: a simulation of pyvisa-sim."""

    @pytest.fixture
    def device(self):
        device = instrument("visa", REGISTRY.find("device", "visa").record.trial)
        yield device
        device.close()

    def test_trial_works_without_an_instrument(self, device):
        assert device.connect(1.0) == Identity("unknown", "LSG Serial #1234", "", simulated=True)
        device.set("level", 2.5)
        assert device.read(["level"]) == {"level": 2.5}
        assert device.make_safe() == {"level": 0.0}
