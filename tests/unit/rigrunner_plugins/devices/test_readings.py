"""Readings that are not numbers: in texts, in Modbus, and from devices with wrong types."""

from __future__ import annotations

from pathlib import Path

import pytest

from rigrunner.api.devices import DeviceContext, Observing, ReadingInfo
from rigrunner.api.errors import DeviceRejectedError, PluginError
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig
from rigrunner_plugins.devices.composite.device import make as make_composite
from rigrunner_plugins.devices.composite.settings import CompositeSettings
from rigrunner_plugins.devices.text.readings import ReadingInText
from unit.rigrunner_plugins.devices.helpers_instruments import instrument
from unit.rigrunner_plugins.devices.helpers_modbus import mbap, tcp_peer


def reading(text, **settings):
    return ReadingInText.model_validate(settings).reading_in(text, "the answer")


@pytest.mark.parametrize(
    ("text", "settings", "expected"),
    [
        (" V1.2 \r\n", {"kind": "text"}, "V1.2"),
        ("ACME,X,7,V1.2", {"kind": "text", "pattern": ",([^,]*)$"}, "V1.2"),
        ("1", {"kind": "boolean"}, True),
        ("OFF", {"kind": "boolean"}, False),
        ("is open", {"kind": "boolean", "pattern": "is (.*)", "yes": "shut", "no": "open"}, False),
        ("1.5, 2.5,-3e0", {"kind": "array", "unit": "mV"}, (1.5e-3, 2.5e-3, -3e-3)),
        ("0  25", {"kind": "array", "unit": "°C", "separator": " "}, (273.15, 298.15)),
    ],
)  # fmt: skip
def test_answer_is_converted_to_its_kind(text, settings, expected):
    value = reading(text, **settings)
    assert value == (pytest.approx(expected) if isinstance(expected, tuple) else expected)
    assert type(value) is type(expected)


@pytest.mark.parametrize(
    ("text", "settings", "message"),
    [
        ("maybe", {"kind": "boolean"}, "neither yes and no"),
        ("1", {"kind": "boolean", "no": "1"}, "both yes and no"),
        ("1,x", {"kind": "array", "unit": "V"}, "no list of numbers"),
        ("1,nan", {"kind": "array", "unit": "V"}, "not finite"),
        ("a\x07b", {"kind": "text"}, "no text of one line"),
        ("abc", {"kind": "text", "pattern": "x(.)"}, "does not fit the pattern"),
    ],
)
def test_answer_that_does_not_fit_is_refused(text, settings, message):
    with pytest.raises(DeviceRejectedError, match=message):
        reading(text, **settings)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"kind": "text", "unit": "V"}, "kind is text, which has no unit"),
        ({"kind": "array"}, "kind is array, which needs a unit"),
        ({"kind": "text", "pattern": "x"}, "needs one group"),
    ],
)
def test_settings_that_do_not_fit_are_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        ReadingInText.model_validate(settings)


BITS = {
    "readings": {
        "door": {"kind": "boolean", "coil": 3},
        "alarm": {"kind": "boolean", "holding": 5, "bit": 2},
        "type": {"kind": "text", "holding": 16, "text": 2},
    }
}


def test_modbus_reads_coils_bits_and_texts():
    """Requests and answers by hand, by the Application Protocol Specification V1.1b3, 6.1, 6.3."""
    script = [
        (mbap(1, 1, "01 0003 0001"), mbap(1, 1, "01 01 01")),  # the probe on connect
        (mbap(2, 1, "01 0003 0001"), mbap(2, 1, "01 01 01")),
        (mbap(3, 1, "03 0005 0001"), mbap(3, 1, "03 02 0003")),
        (mbap(4, 1, "03 0010 0002"), mbap(4, 1, "03 04 41423100")),
    ]
    with tcp_peer(script) as (_, connection):
        device = instrument("modbus", {**BITS, **connection})
        assert isinstance(device, Observing)
        device.connect(5.0)
        try:
            assert device.observe(["door", "alarm", "type"]) == {
                "door": True, "alarm": False, "type": "AB1",
            }  # fmt: skip
        finally:
            device.close()


def hexadecimal(words):
    return "".join(f"{word:04x}" for word in words)


def test_modbus_reads_an_array_from_a_block_of_registers():
    """63 numbers of two registers are 126, one more than a request may ask for (6.3)."""
    numbers = [1000 * i for i in range(63)]  # int32, high word first
    words = [half for number in numbers for half in (number >> 16, number & 0xFFFF)]
    script = [
        (mbap(1, 1, "03 0100 0002"), mbap(1, 1, "03 04 00000000")),  # the probe on connect
        (mbap(2, 1, "03 0100 007c"), mbap(2, 1, f"03 f8 {hexadecimal(words[:124])}")),
        (mbap(3, 1, "03 017c 0002"), mbap(3, 1, f"03 04 {hexadecimal(words[124:])}")),
    ]
    spectrum = {"kind": "array", "unit": "mV", "holding": 0x100, "type": "int32", "values": 63,
                "scale": 0.1, "offset": -1}  # fmt: skip
    with tcp_peer(script) as (_, connection):
        device = instrument("modbus", {"readings": {"spectrum": spectrum}, **connection})
        device.connect(5.0)
        try:
            spectrum_ = device.observe(["spectrum"])["spectrum"]
        finally:
            device.close()
    assert spectrum_ == pytest.approx([(0.1 * number - 1) / 1000 for number in numbers], abs=1e-12)
    (info,) = device.readings
    assert (info.kind, info.unit) == ("array", "V")


@pytest.mark.parametrize(
    ("reading_settings", "message"),
    [
        ({"kind": "boolean", "holding": 5}, "a boolean is one bit"),
        ({"kind": "text", "coil": 5}, "a text is in registers"),
        ({"kind": "text", "holding": 5}, "a text is in registers"),
        ({"kind": "array", "unit": "V", "holding": 5}, "an array is in registers"),
        ({"kind": "array", "unit": "V", "coil": 5, "values": 2}, "an array is in registers"),
        ({"kind": "array", "unit": "V", "holding": 65535, "values": 2}, "end beyond 65535"),
        ({"kind": "boolean", "coil": 5, "values": 2}, "values, scale and offset are of an array"),
    ],
)
def test_modbus_readings_without_a_valid_address_are_refused(reading_settings, message):
    settings = {"tcp": {"host": "127.0.0.1"}, "readings": {"x": reading_settings}}
    with pytest.raises((PluginError, ValueError), match=message):
        instrument("modbus", settings)


def test_name_of_both_channel_and_reading_is_refused():
    settings = {
        "tcp": {"host": "127.0.0.1"},
        "channels": {"x": {"holding": 1, "unit": "V"}},
        "readings": {"x": {"kind": "boolean", "coil": 1}},
    }
    with pytest.raises((PluginError, ValueError), match="'x' is a channel and a reading"):
        instrument("modbus", settings)


class FixedReading:
    """A device whose one reading has a fixed value."""

    channels = drives = ()
    non_blocking = True

    def __init__(self, kind, value):
        self.readings = (ReadingInfo("x", kind, "X"),)
        self.value = value

    def connect(self, timeout_s):  # noqa: ARG002
        from rigrunner.api.devices import Identity  # noqa: PLC0415

        return Identity("a", "b", "c")

    def make_safe(self):
        return {}

    def close(self):
        pass

    def observe(self, readings):
        return dict.fromkeys(readings, self.value)


@pytest.mark.parametrize(
    ("kind", "value", "needed"),
    [
        ("text", 1.0, "a str"),
        ("boolean", 1, "a bool"),
        ("boolean", "yes", "a bool"),
        ("array", (1.0, float("nan")), "a tuple of finite numbers"),
        ("array", 1.0, "a tuple of finite numbers"),
        ("text", None, "a str"),
    ],
)
def test_rig_refuses_a_value_of_another_kind(kind, value, needed):
    rig = Rig({"role": FixedReading(kind, value)}, SimulatedClock())
    rig.connect()
    with pytest.raises(DeviceRejectedError) as raised:
        rig.observe("role", ["x"])
    assert raised.value.hint == f"expected {needed}"


def test_rig_prefixes_readings_with_the_role():
    rig = Rig({"role": FixedReading("array", [1, 2])}, SimulatedClock())
    rig.connect()
    assert rig.observe("role", ["x"]) == {"role.x": (1.0, 2.0)}


def composite(readings, **parts):
    settings = {"parts": {name: {"plugin": name} for name in parts}, "readings": readings}

    def make(plugin, settings, /, part=""):  # noqa: ARG001
        return parts[plugin]

    context = DeviceContext("role", SimulatedClock(), Path(), make=make)
    return make_composite(CompositeSettings.model_validate(settings), context)


def test_composite_has_the_readings_of_its_parts():
    device = composite(
        {"guard": "plc.x", "spectrum": "scope.x"},
        plc=FixedReading("text", "V1"), scope=FixedReading("array", (1.0, 2.0)),
    )  # fmt: skip
    assert [(info.name, info.kind) for info in device.readings] == [
        ("guard", "text"), ("spectrum", "array"),
    ]  # fmt: skip
    rig = Rig({"role": device}, SimulatedClock())
    rig.connect()
    readings = rig.observe("role", ["spectrum", "guard"])
    assert readings == {"role.spectrum": (1.0, 2.0), "role.guard": "V1"}


@pytest.mark.parametrize("place", ["plc.y", "clock.x"])
def test_composite_refuses_a_reading_that_no_part_has(place):
    silent = FixedReading("text", "")
    silent.readings = ()
    with pytest.raises(PluginError, match=r"the part '(plc|clock)' has no reading"):
        composite({"guard": place}, plc=FixedReading("text", "V1"), clock=silent)


def test_composite_without_readings_is_not_observing():
    assert not isinstance(composite({}, plc=FixedReading("text", "V1")), Observing)
