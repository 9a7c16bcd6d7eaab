"""Exchanges of Modbus as printed in its specifications, byte for byte.

PDUs are from the MODBUS Application Protocol Specification V1.1b3 (Modbus Organization, 2012), in
the clause that each test names. The frames around them are those of MODBUS Messaging on TCP/IP
Implementation Guide V1.0b, clause 3.1.3, and of MODBUS over Serial Line V1.02, clause 2.5.1.
Whole serial frames, with their checksum, are from the manuals of frequency inverters.
"""

from __future__ import annotations

import pytest

from rigrunner.api.errors import DeviceRejectedError
from unit.rigrunner_plugins.devices.helpers_modbus import crc, device, mbap, rtu, rtu_peer, tcp_peer

UNIT = 17
PROBE = ("03 00 00 00 01", "03 02 00 00")
"""The first request of a connection without identification: tests for any answer."""


def exchanges(frame, *pdus):
    """Return the script of these PDUs, in frames counted from 1."""
    return [
        (frame(number, request), frame(number, answer))
        for number, (request, answer) in enumerate(pdus, 1)
    ]


def over_tcp(*pdus):
    return tcp_peer(exchanges(lambda number, pdu: mbap(number, UNIT, pdu), *pdus))


def over_rtu(*pdus):
    return rtu_peer(exchanges(lambda _, pdu: rtu(UNIT, pdu), *pdus))


def settings(where, channels=None, drives=None):
    probe = {"probe": {"holding": 0, "unit": "1"}}
    return {
        **where,
        "unit_id": UNIT,
        "timeout": "500 ms",
        "retries": 0,
        "channels": probe | (channels or {}),
        "drives": drives or {},
    }


@pytest.fixture(params=[over_tcp, over_rtu], ids=["tcp", "rtu"])
def serving(request):
    return request.param


def read(serving, pdus, channels):
    with serving(PROBE, *pdus) as (peer, where):
        unit = device(settings(where, channels))
        unit.connect(1.0)
        values = unit.read(list(channels))
        unit.close()
    assert peer.heard == peer.asked
    return values


def test_checksum_of_worked_example():
    # MODBUS over Serial Line V1.02, clause 6.2.2: of the frame 02 07 it is 41 12
    assert crc(bytes.fromhex("02 07")) == bytes.fromhex("41 12")


def test_coils_are_counted_from_lowest_bit(serving):
    # 6.1: outputs 20 to 38 (addresses 19 to 37), CD 6B 05. CD = 1100 1101 is outputs 27 to 20:
    # 20 on, 21 off, 22 on, 23 on; 05 = 101 is outputs 38 to 36: 36 on, 37 off, 38 on
    expected = {20: 1, 21: 0, 22: 1, 23: 1, 27: 1, 36: 1, 37: 0, 38: 1}
    channels = {f"output_{n}": {"coil": n - 1, "unit": "1"} for n in range(20, 39)}
    values = read(serving, [("01 00 13 00 13", "01 03 CD 6B 05")], channels)
    assert {n: values[f"output_{n}"] for n in expected} == expected


def test_discrete_inputs_are_read(serving):
    # 6.2: inputs 197 to 218 (addresses 196 to 217), AC DB 35. AC = 1010 1100 is inputs 204 to 197;
    # 35 = 11 0101 is inputs 218 to 213
    expected = {197: 0, 198: 0, 199: 1, 200: 1, 204: 1, 213: 1, 214: 0, 217: 1, 218: 1}
    channels = {f"input_{n}": {"discrete": n - 1, "unit": "1"} for n in range(197, 219)}
    values = read(serving, [("02 00 C4 00 16", "02 03 AC DB 35")], channels)
    assert {n: values[f"input_{n}"] for n in expected} == expected


def test_holding_registers_are_read_together(serving):
    # 6.3: registers 108 to 110 (addresses 107 to 109) hold 022B, 0000 and 0064 hex: 555, 0, 100.
    # In 0.01 Hz, °C and N these are 5.55 Hz, 273.15 K and 100 N
    channels = {
        "frequency": {"holding": 107, "scale": 0.01, "unit": "Hz"},
        "temperature": {"reference": 40109, "unit": "°C"},
        "load": {"holding": 109, "unit": "N"},
    }
    values = read(serving, [("03 00 6B 00 03", "03 06 02 2B 00 00 00 64")], channels)
    assert values == {
        "frequency": pytest.approx(5.55),
        "temperature": pytest.approx(273.15),
        "load": 100.0,
    }


def test_input_register_is_read(serving):
    # 6.4: input register 9 (address 8) holds 000A hex: 10 kN = 10 000 N
    channels = {"load": {"reference": 30009, "unit": "kN"}}
    assert read(serving, [("04 00 08 00 01", "04 02 00 0A")], channels) == {"load": 10_000.0}


DRIVE = {"unit": "1", "min": "0 %", "max": "100 %", "safe": "0 %", "tolerance": "60 %"}


def begin(serving, pdus, drive, value):
    with serving(PROBE, *pdus) as (peer, where):
        unit = device(settings(where, drives={"drive": drive}))
        unit.connect(1.0)
        unit.begin("drive", value)
        unit.close()
    assert peer.heard == peer.asked


def test_single_coil_is_written(serving):
    # 6.5: output 173 (address 172) on
    echo = ("05 00 AC FF 00", "05 00 AC FF 00")
    begin(serving, [echo], {**DRIVE, "coil": 172}, 1.0)


def test_single_register_is_written(serving):
    # 6.6: register 2 (address 1) to 0003 hex. 0.03 in steps of 0.01
    echo = ("06 00 01 00 03", "06 00 01 00 03")
    begin(serving, [echo], {**DRIVE, "holding": 1, "scale": 0.01}, 0.03)


def test_coils_are_written_by_function_for_several(serving):
    # the frame of 6.11 (0F 00 13 00 0A 02 CD 01) with one output: quantity 1, one byte
    exchange = ("0F 00 13 00 01 01 01", "0F 00 13 00 01")
    begin(serving, [exchange], {**DRIVE, "coil": 19, "write": "multiple"}, 1.0)


def test_two_registers_are_written_together(serving):
    # 6.12: registers 2 and 3 (addresses 1 and 2) to 000A and 0102 hex.
    # As one number, high word first: 000A0102 hex = 10 * 65536 + 258 = 655 618
    exchange = ("10 00 01 00 02 04 00 0A 01 02", "10 00 01 00 02")
    drive = {
        "holding": 1,
        "type": "uint32",
        "unit": "N",
        "min": "0 N",
        "max": "1000 kN",
        "safe": "0 N",
    }
    begin(serving, [exchange], drive, 655_618.0)


def test_two_registers_are_written_low_word_first(serving):
    # the same bytes: 0102000A hex = 258 * 65536 + 10 = 16 908 298
    exchange = ("10 00 01 00 02 04 00 0A 01 02", "10 00 01 00 02")
    drive = {
        "holding": 1,
        "type": "uint32",
        "word_order": "little",
        "unit": "N",
        "min": "0 N",
        "max": "100000 kN",
        "safe": "0 N",
    }
    begin(serving, [exchange], drive, 16_908_298.0)


def test_exception_response_is_reported_in_words(serving):
    # clause 7, example: output 1186 (address 04A1 hex) does not exist: 81 02
    with serving(PROBE, ("01 04 A1 00 01", "81 02")) as (_, where):
        unit = device(settings(where, {"valve": {"coil": 0x04A1, "unit": "1"}}))
        unit.connect(1.0)
        with pytest.raises(DeviceRejectedError, match=r"read coil 1185.*illegal data address"):
            unit.read(["valve"])
        unit.close()


def objects(*texts):
    """Return objects of Read Device Identification: number, length and text of each, in hex."""
    return " ".join(
        f"{number:02x} {len(text):02x} {text.encode().hex(' ')}" for number, text in texts
    )


COMPANY, PRODUCT, REVISION = (0, "Company identification"), (1, "Product code XX"), (2, "V2.11")


@pytest.mark.parametrize(
    "pdus",
    [
        # 6.21: basic device identification, the three objects in one answer
        [("2B 0E 01 00", f"2B 0E 01 01 00 00 03 {objects(COMPANY, PRODUCT, REVISION)}")],
        # 6.21: in two answers; FF and 02: more follows, from object 2
        [
            ("2B 0E 01 00", f"2B 0E 01 01 FF 02 02 {objects(COMPANY, PRODUCT)}"),
            ("2B 0E 01 02", f"2B 0E 01 01 00 00 01 {objects(REVISION)}"),
        ],
    ],
    ids=["one answer", "two answers"],
)
def test_device_identification_is_read(serving, pdus):
    with serving(*pdus) as (peer, where):
        unit = device({**settings(where), "identification": {"standard": "yes"}})
        identity = unit.connect(1.0)
        unit.close()
    assert (identity.maker, identity.model) == ("Company identification", "Product code XX")
    assert identity.firmware == "V2.11"
    assert peer.heard == peer.asked


@pytest.mark.parametrize(("byte_order", "text"), [("big", "MB 1"), ("little", "BM1 ")])
def test_text_has_two_characters_per_register(serving, byte_order, text):
    # ASCII: 4D 42 20 31 hex is 'MB 1'; NUL and blanks at its end are not part of it
    exchange = ("03 00 10 00 03", "03 06 4D 42 20 31 00 00")
    model = {"holding": 16, "text": 3, "byte_order": byte_order}
    with serving(exchange) as (peer, where):
        unit = device({**settings(where), "identification": {"model": model}})
        assert unit.connect(1.0).model == text.strip()
        unit.close()
    assert peer.heard == peer.asked


def printed(*frames):
    """Return the script of frames as printed in a manual."""
    return rtu_peer([(bytes.fromhex(request), bytes.fromhex(answer)) for request, answer in frames])


def test_frequencies_of_delta_inverter():
    # Delta Electronics, VFD-VE Series User Manual (August 2008, 03VE, SW V2.04), page 4-141:
    # two words from 2102H, set and output frequency. 1770 hex = 6000 in 0.01 Hz: 60 Hz; and 0
    exchange = ("01 03 21 02 00 02 6F F7", "01 03 04 17 70 00 00 FE 5C")
    channels = {
        "set": {"holding": "0x2102", "scale": 0.01, "unit": "Hz"},
        "output": {"holding": "0x2103", "scale": 0.01, "unit": "Hz"},
        "as_one_number": {"holding": "0x2102", "type": "uint32", "unit": "1"},
    }
    identification = {"model": {"holding": "0x2102", "type": "uint32"}}
    with printed(exchange, exchange) as (peer, where):
        unit = device({**where, "channels": channels, "identification": identification})
        assert unit.connect(1.0).model == "393216000"  # 6000 * 65536
        values = unit.read(list(channels))
        unit.close()
    assert peer.heard == peer.asked
    assert values == {"set": pytest.approx(60.0), "output": 0.0, "as_one_number": 393_216_000.0}


def test_two_words_of_invt_inverter():
    # INVT, Goodrive200 operation manual, 10.4.1, page 225: two words from 0004H: 1388 hex and 0
    exchange = ("01 03 00 04 00 02 85 CA", "01 03 04 13 88 00 00 7E 9D")
    channels = {
        "frequency": {"reference": 40005, "scale": 0.01, "unit": "Hz"},
        "zero": {"reference": 40006, "unit": "1"},
    }
    identification = {"model": {"holding": 4, "type": "uint32"}}
    with printed(exchange, exchange) as (peer, where):
        unit = device({**where, "channels": channels, "identification": identification})
        unit.connect(1.0)
        assert unit.read(list(channels)) == {"frequency": pytest.approx(50.0), "zero": 0.0}
        unit.close()
    assert peer.heard == peer.asked


def test_set_point_of_invt_inverter():
    # INVT, Goodrive300-19 operation manual, 10.4.2, page 217: 5000 (1388 hex) to 0004H of unit 2.
    # The first exchange is not printed there: it tests for any answer
    write = "02 06 00 04 13 88 C5 6E"
    request, answer = rtu(2, "03 00 04 00 01"), rtu(2, "03 02 00 00")
    script = [(request, answer), (bytes.fromhex(write), bytes.fromhex(write))]
    drive = {
        "holding": 4,
        "scale": 0.01,
        "unit": "Hz",
        "min": "0 Hz",
        "max": "60 Hz",
        "safe": "0 Hz",
    }
    with rtu_peer(script) as (peer, where):
        unit = device({**where, "unit_id": 2, "drives": {"frequency": drive}})
        unit.connect(1.0)
        unit.begin("frequency", 50.0)
        unit.close()
    assert peer.heard == peer.asked


def test_stop_command_precedes_safe_set_point():
    # VTS, VTS2000 Series frequency inverter User Manual, pages 87 and 88: 0001H, stop, to 2000H.
    # The exchanges around it are not printed there: the first tests for any answer, the
    # last one writes 0 Hz to the set-point, 2001H
    request, answer = rtu(1, "03 20 01 00 01"), rtu(1, "03 02 00 00")
    stop, zero = bytes.fromhex("01 06 20 00 00 01 43 CA"), rtu(1, "06 20 01 00 00")
    drive = {
        "holding": "0x2001",
        "scale": 0.01,
        "unit": "Hz",
        "min": "0 Hz",
        "max": "60 Hz",
        "safe": "0 Hz",
        "stop": [{"holding": "0x2000", "value": 1}],
    }
    with rtu_peer([(request, answer), (stop, stop), (zero, zero)]) as (peer, where):
        unit = device({**where, "drives": {"frequency": drive}})
        unit.connect(1.0)
        unit.begin("frequency", 0.0)
        unit.close()
    assert peer.heard == peer.asked


def test_well_known_serial_frame():
    # 01 04 02 FF FF B8 80 (Wikipedia, 'Modbus'): input register FFFF hex; as int16 it is -1
    request = rtu(1, "04 00 03 00 01")
    answer = bytes.fromhex("01 04 02 FF FF B8 80")
    with rtu_peer([(request, answer), (request, answer)]) as (peer, where):
        channels = {"torque": {"input": 3, "type": "int16", "unit": "N·m"}}
        unit = device({**where, "timeout": "500 ms", "channels": channels})
        unit.connect(1.0)
        assert unit.read(["torque"]) == {"torque": -1.0}
        unit.close()
    assert peer.heard == peer.asked
