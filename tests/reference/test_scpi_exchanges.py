"""Exchanges from standards and a maker's manual, served byte for byte.

IEEE Std 488.2-1992: *IDN? (10.14), numbers (8.7.2 to 8.7.4), blocks (7.7.6, 8.7.9 and 8.7.10).
SCPI-99: the error queue and its numbers (vol. 2, 21.8), infinity and 'not a number' (vol. 1,
7.2.1.4 and 7.2.1.5), REAL,32 (vol. 2, 9). Hewlett-Packard, 34401A User's Guide, chapter 4, 'Output
Data Formats': a single reading is SD.DDDDDDDDESDD, ended by <nl> on the bus and <cr><nl> on RS-232.
The values are ours, the formats are theirs.
"""

from __future__ import annotations

from math import pi

import pytest

from rigrunner.api.devices import Identity
from rigrunner.api.errors import DeviceRejectedError
from rigrunner_plugins.devices.visa.link import whole_block
from unit.rigrunner_plugins.devices.helpers_instruments import instrument, merged
from unit.rigrunner_plugins.devices.helpers_peers import Script, SerialPeer, SocketPeer, peer

IDN = (b"*IDN?\n", b"HEWLETT-PACKARD,34401A,0,11-5-2\n")
NO_ERROR = (b"SYST:ERR?\n", b'+0,"No error"\n')
MULTIMETER = {
    "termination": "LF",
    "timeout": "500 ms",
    "identification": {"expect": "HEWLETT-PACKARD,34401A,.*"},
    "error_queue": {},
    # a torque transducer that gives 5 V at 20 N·m: 4 N·m per volt
    "channels": {"torque": {"query": "READ?", "unit": "N·m", "scale": 4.0}},
}


class Never:
    def is_set(self):
        return False


def served(lines, settings, kind=SocketPeer):
    """Yield the connected device; at the end the script must be used up and nothing else sent."""
    script = Script(lines)
    with peer(kind, script) as server:
        device = instrument("visa", merged(settings, resource=server.resource))
        device.identity = device.connect(2.0)
        yield device
        device.close()
    assert not script.left
    assert not script.unexpected


def exchange(lines, settings=MULTIMETER, kind=SocketPeer):
    return served(lines, settings, kind)


@pytest.mark.parametrize(
    ("reading", "torque_nm"),
    [
        (b"+4.99980000E+00\n", 19.9992),  # 4.9998 V * 4 N·m/V
        (b"-1.25000000E-01\n", -0.5),  # -0.125 V * 4
        (b"+1.20000000E-04\n", 0.00048),  # 0.12 mV * 4
    ],
)
def test_reading_of_34401a(reading, torque_nm):
    for device in exchange([IDN, NO_ERROR, (b"READ?\n", reading)]):
        assert device.identity == Identity("HEWLETT-PACKARD", "34401A", "", "11-5-2")
        assert device.read(["torque"])["torque"] == pytest.approx(torque_nm, rel=1e-12)


def test_reading_of_34401a_over_rs_232():
    lines = [
        (b"*IDN?\n", b"HEWLETT-PACKARD,34401A,0,11-5-2\r\n"),
        (b"SYST:ERR?\n", b'+0,"No error"\r\n'),
        (b"SYST:REM\n", b""),  # RS-232 requires it before any other setting
        (b"SYST:ERR?\n", b'+0,"No error"\r\n'),
        (b"READ?\n", b"+4.99980000E+00\r\n"),
    ]
    settings = merged(
        MULTIMETER, termination="CRLF", write_termination="LF", on_connect=["SYST:REM"]
    )
    for device in exchange(lines, settings, SerialPeer):
        assert device.read(["torque"])["torque"] == pytest.approx(19.9992, rel=1e-12)


@pytest.mark.parametrize("reading", [b"+9.90000000E+37\n", b"-9.90000000E+37\n", b"9.91E37\n"])
def test_infinity_and_not_a_number_are_rejected(reading):
    for device in exchange([IDN, NO_ERROR, (b"READ?\n", reading)]):
        with pytest.raises(DeviceRejectedError, match="overload or 'not a number'"):
            device.read(["torque"])


def test_refused_command_is_reported():
    frequency = {
        "command": "FREQ {value}",
        "read_back": "FREQ?",
        "unit": "Hz",
        "min": "0 Hz",
        "max": "50 Hz",
        "safe": "0 Hz",
    }
    settings = merged(MULTIMETER, drives={"frequency": frequency})
    lines = [
        IDN,
        NO_ERROR,
        (b"FREQ 12.5\n", b""),
        (b"SYST:ERR?\n", b'+0,"No error"\n'),
        (b"FREQ?\n", b"+1.250000000E+01\n"),
        (b"FREQ 45\n", b""),
        (b"SYST:ERR?\n", b'-222,"Data out of range"\n'),
        (b"SYST:ERR?\n", b'+0,"No error"\n'),
    ]
    for device in exchange(lines, settings):
        device.set("frequency", 12.5)
        with pytest.raises(DeviceRejectedError, match="'FREQ 45': -222,\"Data out of range\""):
            device.set("frequency", 45.0)


REAL_32 = bytes.fromhex("3f800000 c0000000 40490fdb 41200000")
"""IEEE 754: 1, -2, pi (to 24 bits) and 10, the highest byte first, as SCPI's REAL,32 has it."""
STREAM = {
    "rate": "100 Hz",
    "channels": ["angle", "torque"],
    "start": "INIT",
    "stop": "ABOR",
    "fetch": "FETC? {samples}",
    "format": "float32",
    "byte_order": "big",
    "samples": 2,
}


@pytest.mark.parametrize("header", [b"#216", b"#3016", b"#800000016"])
def test_block_of_definite_length(header):
    """488.2 itself writes its example of five bytes as #15 and as #3005."""
    channels = {
        "angle": {"query": "ANGL?", "unit": "deg"},
        "torque": {"query": "TORQ?", "unit": "mN·m", "scale": 2.0, "offset": 1.0},
    }
    lines = [
        IDN,
        NO_ERROR,
        (b"INIT\n", b""),
        NO_ERROR,
        (b"FETC? 2\n", header + REAL_32 + b"\n"),
        (b"ABOR\n", b""),
        NO_ERROR,
    ]
    stream = merged(STREAM, paced="no")
    for device in exchange(lines, merged(MULTIMETER, channels=channels, stream=stream)):
        (block,) = device.stream(["angle", "torque"], 0.02, Never())
        # 1 deg and pi deg in rad; (-2 * 2 + 1) and (10 * 2 + 1) mN·m in N·m
        assert block.channels["angle"] == pytest.approx([pi / 180, pi * pi / 180], rel=1e-7)
        assert block.channels["torque"] == pytest.approx([-0.003, 0.021], rel=1e-12)


def test_block_with_line_feeds_in_data():
    """Bytes of a block are only data: 0x0a0a0a0a is 6.6468e-33."""
    lines = [
        IDN,
        NO_ERROR,
        (b"INIT\n", b""),
        NO_ERROR,
        (b"FETC? 1\n", b"#14" + bytes.fromhex("0a0a0a0a") + b"\n"),
        (b"ABOR\n", b""),
        NO_ERROR,
    ]
    stream = merged(STREAM, paced="no", channels=["torque"], samples=1)
    for device in exchange(lines, merged(MULTIMETER, stream=stream)):
        (block,) = device.stream(["torque"], 0.01, Never())
        # sign 0, exponent 0x14 = 20, fraction 0x0a0a0a: (1 + 657930 / 2**23) * 2**(20 - 127)
        assert block.channels["torque"] == pytest.approx(4 * (1 + 657930 / 2**23) * 2**-107)


@pytest.mark.parametrize("message", [b"#15abcde", b"#3005abcde\n", b"#0abcde\n", b"#15abcde\r\n"])
def test_all_forms_of_488_2_example(message):
    assert whole_block(message, "CURV?") == b"abcde"


@pytest.mark.parametrize("message", [b"#15abcd", b"#15abcdef", b"#0abcde", b"15abcde", b"#"])
def test_malformed_block_is_rejected(message):
    with pytest.raises(DeviceRejectedError, match=r"'CURV\?'"):
        whole_block(message, "CURV?")
