"""Settings of a Modbus instrument in a station."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from rigrunner.registry import load_registry
from rigrunner_plugins.devices.modbus.opening import open_client
from rigrunner_plugins.devices.modbus.settings import ModbusSettings
from unit.rigrunner_plugins.devices.helpers_modbus import FREQUENCY, device, rtu_peer

TCP = {"tcp": {"host": "127.0.0.1"}}
CHANNEL = {"frequency": {"input": 1, "unit": "Hz"}}


def settings(**changes):
    return {**TCP, "channels": CHANNEL, **changes}


def drive(**changes):
    return settings(drives={"frequency": {**FREQUENCY, **changes}})


def test_defaults_are_those_of_the_standards():
    settings_ = ModbusSettings.model_validate({"rtu": {"port": "COM3"}, "channels": CHANNEL})
    assert settings_.rtu is not None
    assert (settings_.rtu.baud, settings_.rtu.parity, settings_.rtu.stop_bits) == (19200, "even", 1)
    assert ModbusSettings.model_validate(settings()).tcp.port == 502


@pytest.mark.parametrize(
    ("settings_", "message"),
    [
        ({"channels": CHANNEL}, "expected one of tcp, rtu and simulator"),
        (settings(rtu={"port": "COM3"}), "expected one of tcp, rtu and simulator"),
        (TCP, "neither channels nor drives"),
        ({"rtu": {"port": "COM3"}, "unit_id": 248, "channels": CHANNEL}, "1 to 247"),
        (settings(unit_id=256), "less than or equal to 255"),
        ({"rtu": {"port": "COM3"}, "unit_id": 0, "channels": CHANNEL}, "1 to 247"),
        (settings(identification={"expect": {"model": "X"}}), "expect names model"),
        (
            settings(identification={"model": {"holding": 1, "text": 4, "type": "int16"}}),
            "a text is in registers",
        ),
        (settings(watchdog={"input": 1, "every": "1 s", "write": [1]}), "an input is only read"),
        (drive(holding=None, input=1), "an input is only read"),
        (drive(bit=3), "a single bit of a register cannot be a drive"),
        (drive(type="float32", write="single"), "float32 takes 2 registers"),
        (drive(max="700 Hz"), r"max is 700 Hz: 70000 does not fit into uint16: 0 to 65535"),
        (drive(min="-1 Hz"), r"min is -1 Hz: -100 does not fit"),
        (drive(scale=1.0), "steps of 1 Hz, too coarse for the tolerance of 0.05 Hz"),
        (
            drive(scale=0.06, read_back={"input": 1, "unit": "Hz", "scale": 0.05}),
            "too coarse for the tolerance of 0.05 Hz",  # half of both steps is 0.055 Hz
        ),
        (
            drive(read_back={"input": 1, "unit": "Hz"}),
            "steps of 1 Hz, too coarse for the tolerance of 0.05 Hz",
        ),
        (drive(read_back={"input": 1, "unit": "N"}), "read_back is in N, the drive in Hz"),
        (drive(run=[{"input": 0, "value": 1}]), "an input is only read"),
        (drive(run=[{"coil": 0, "value": 2}]), "expected 0 or 1 in a coil"),
        (drive(run=[{"holding": 0, "value": "0x10000"}]), "less than or equal to 65535"),
        (drive(run=[{"holding": 0, "value": "0xG"}]), "valid integer"),
    ],
)
def test_contradictory_settings_are_refused(settings_, message):
    with pytest.raises(ValidationError, match=message):
        ModbusSettings.model_validate(settings_)


def test_word_may_be_hexadecimal():
    settings = ModbusSettings.model_validate(drive(run=[{"holding": 0, "value": "0x047F"}]))
    assert settings.drives["frequency"].run[0].value == 0x047F


def test_channels_and_drives_are_known_without_an_instrument():
    unit = device(drive(unit="rpm", scale=1.0, tolerance="1 Hz"))
    assert [info.unit for info in (*unit.channels, *unit.drives)] == ["Hz", "Hz"]
    assert unit.drives[0].maximum == 35.0
    assert unit.drives[0].sets_cycle_frequency


@pytest.mark.parametrize(("parity", "letter"), [("even", "E"), ("odd", "O"), ("none", "N")])
def test_serial_line_is_opened_with_its_settings(parity, letter):
    with rtu_peer([]) as (_, connection):
        settings = {"rtu": {**connection["rtu"], "parity": parity, "baud": 9600, "stop_bits": 2}}
        model = ModbusSettings.model_validate({**settings, "channels": CHANNEL})
        client = open_client(model, 1.0, lambda _, data: data)
        port = client.socket
        assert (port.parity, port.baudrate, port.stopbits) == (letter, 9600, 2)
        client.close()


def test_unknown_settings_are_forbidden():
    schema = load_registry().settings_of("device", "modbus").model_json_schema()
    assert schema["additionalProperties"] is False
