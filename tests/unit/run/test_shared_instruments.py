"""One instrument in two station files: the second is refused, naming who has it."""

from __future__ import annotations

import sys

import pytest

from e2e.helpers_supply import SupplyLab
from helpers_cli import call
from rigrunner.api.errors import DeviceError, ExitCode
from rigrunner.api.lines import LineSettings
from rigrunner.registry import load_registry
from rigrunner.rig_state import DriveMark, Owner, RigMarks, read_marker, record_made_safe
from rigrunner.run.lab_plugins import with_lab_plugins
from rigrunner.run.rig_lock import station_lock
from rigrunner.station import load_station, parse_station
from rigrunner_testing.station import bound_subject

HEAD = """\
rigrunner: station/1
id: {id}
title: T
devices:
  {role}: {{type: t, plugin: {plugin}, settings: {settings}{more}}}
"""


@pytest.fixture(autouse=True)
def own_state(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))


class FakeRegistry:
    """A registry in which every device has these addresses."""

    def __init__(self, *addresses):
        self.addresses = list(addresses)

    def is_simulated(self, plugin, settings):  # noqa: ARG002  (the registry's)
        return False

    def physical_addresses(self, plugin, settings):  # noqa: ARG002  (the registry's)
        return self.addresses


def station(station_id, more="", role="psu"):
    text = HEAD.format(id=station_id, role=role, plugin="p", settings="{}", more=more)
    return parse_station(text, f"{station_id}.yaml")


def test_second_station_of_instrument_is_refused_naming_its_holder():
    one, other = FakeRegistry("tcp:localhost:5025"), FakeRegistry("tcp:127.0.0.1:5025")
    message = (
        r"the instrument of 'supply' at tcp:127\.0\.0\.1:5025 is in use:"
        r" WEAR on station first, process \d+"
    )
    with (
        station_lock(station("first"), one, "WEAR"),
        pytest.raises(DeviceError, match=message),
        station_lock(station("second", role="supply"), other, "jog supply"),
    ):
        pass
    with station_lock(station("second"), other, "jog psu"):
        pass


def test_refused_station_holds_no_lock():
    with station_lock(station("first"), FakeRegistry("tcp:127.0.0.1:5025"), "WEAR"):
        with (
            pytest.raises(DeviceError),
            station_lock(
                station("second"), FakeRegistry("serial:/dev/a", "tcp:127.0.0.1:5025"), "jog"
            ),
        ):
            pass
        with station_lock(station("third"), FakeRegistry("serial:/dev/a"), "jog"):
            pass


def test_two_roles_of_one_instrument_share_a_lock():
    with station_lock(
        station("first"), FakeRegistry("tcp:localhost:502", "tcp:127.0.0.1:502"), "WEAR"
    ):
        pass


def test_shared_instrument_is_not_locked():
    instrument = FakeRegistry("tcp:127.0.0.1:5025")
    with (
        station_lock(station("first", ", shared: yes"), instrument, "WEAR"),
        station_lock(station("second", ", shared: yes"), instrument, "WEAR"),
    ):
        pass


def test_instrument_left_energised_is_refused_until_safe():
    registry = FakeRegistry("tcp:127.0.0.1:5025")
    owner = Owner("first", "/lab/first.yaml", "WEAR", 1, "bench", "2026-03-01T12:00:00.000Z")
    with station_lock(station("first"), registry, "WEAR") as marks:
        owner = marks.owner
    left = RigMarks(owner, ["psu"])
    left._add(DriveMark("psu.voltage", "V", 0.0, 40.0))
    text = r"'psu' at tcp:127.* is not known to be safe: .*left energised by WEAR.*psu.voltage 40 V"
    with (
        pytest.raises(DeviceError, match=text) as caught,
        station_lock(station("second"), registry, "jog"),
    ):
        pass
    assert "first.yaml' makes it safe first" in caught.value.hint
    record_made_safe("first", "'devices' made it safe")
    with station_lock(station("second"), registry, "jog"):
        pass


SPEED = {"channels": {"speed": {"input": 1, "unit": "Hz"}}}
INVERTER = {"tcp": {"host": "localhost", "port": 1502}, "unit_id": 3, **SPEED}
CELL = {"rtu": {"port": "/dev/ttyUSB0"}, **SPEED}


@pytest.mark.parametrize(
    ("plugin", "settings", "addresses"),
    [
        ("modbus", INVERTER, ["tcp:localhost:1502/unit 3"]),
        ("modbus", CELL, ["serial:/dev/ttyUSB0"]),
        ("fault", {"plugin": "modbus", "settings": CELL}, ["serial:/dev/ttyUSB0"]),
        (
            "composite",
            {
                "parts": {
                    "drive": {"plugin": "modbus", "settings": INVERTER},
                    "cell": {"plugin": "modbus", "settings": CELL},
                },
                "channels": {"speed": "drive.speed"},
            },
            ["tcp:localhost:1502/unit 3", "serial:/dev/ttyUSB0"],
        ),
        ("tabulated", {}, []),
        ("modbus", {"simulated": True, "simulator": "inverter", **SPEED}, []),
    ],
)
def test_addresses_of_device_include_those_of_its_parts(plugin, settings, addresses):
    assert load_registry().physical_addresses(plugin, settings) == addresses


@pytest.mark.parametrize(
    ("plugin", "settings", "addresses"),
    [
        ("visa", {"resource": "GPIB0::12::INSTR"}, ("visa:GPIB0::12::INSTR",)),
        ("pymeasure", {"resource": "GPIB0::16::INSTR"}, ("visa:GPIB0::16::INSTR",)),
        ("opcua", {"endpoint": "opc.tcp://plc/rig"}, ("tcp:plc:4840",)),
        ("opcua", {"endpoint": "opc.tcp://plc:4841"}, ("tcp:plc:4841",)),
        ("serial_ascii", {"port": "/dev/ttyUSB1"}, ("serial:/dev/ttyUSB1",)),
        ("daq", {"device": "cDAQ1"}, ("daq:cDAQ1",)),
    ],
)
def test_settings_of_instruments_have_addresses(plugin, settings, addresses):
    model = load_registry().settings_of("device", plugin)
    assert model.model_construct(**settings).physical_addresses() == addresses


def test_line_settings_have_addresses():
    assert LineSettings(address="192.0.2.7:5025").physical_addresses() == ("tcp:192.0.2.7:5025",)
    assert LineSettings(address="COM3").physical_addresses() == ("serial:COM3",)
    assert LineSettings(simulated=True).physical_addresses() == ()


@pytest.mark.skipif(sys.platform == "win32", reason="as the e2e tests of the supply")
def test_jog_of_second_station_is_refused(tmp_path):
    """A jog by the file of another station once moved the device during a run."""
    lab = SupplyLab(tmp_path / "lab")
    other = lab.add_station("other.yaml", "other")
    station = load_station(lab.station)
    registry = with_lab_plugins(load_registry(), station, lab.folder)
    with station_lock(station, registry, "STEPS"):
        result = call("jog", other, "psu", "--set", "voltage=5 V", "--log", lab.folder / "jog.log")
    assert result.code == ExitCode.DEVICE
    assert "the instrument of 'psu' at file:supply.json" in result.err
    assert "is in use: STEPS on station supply, process" in result.err
    assert lab.outputs() == (0.0, 0.0)


@pytest.mark.skipif(sys.platform == "win32", reason="as the e2e tests of the supply")
def test_kit_marks_rig_while_it_drives_it(tmp_path):
    lab = SupplyLab(tmp_path / "lab")
    states = []
    with bound_subject(lab.station, "psu", "supply") as subject:
        with subject.connected() as device:
            device.set("voltage", 20.0)
            states.append(read_marker("supply").set_points)
        states.append(read_marker("supply"))
    assert states == ["psu.voltage at an unknown value, psu.speed at an unknown value", None]


def test_kit_refuses_rig_left_energised(tmp_path):
    lab = SupplyLab(tmp_path / "lab")
    station = load_station(lab.station)
    registry = with_lab_plugins(load_registry(), station, lab.folder)
    with station_lock(station, registry, "STEPS") as marks:
        marks._add(DriveMark("psu.voltage", "V", 0.0, 40.0))
    with (
        pytest.raises(DeviceError, match="left energised by STEPS"),
        bound_subject(lab.station, "psu", "supply"),
    ):
        pass
