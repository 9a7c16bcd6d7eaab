"""The devices that ship with Rigrunner; each `_name` function is the factory of one record.

Nothing here loads numpy or a library of instruments: factories import their device.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DeviceRecord, hookimpl
from rigrunner_plugins.devices.modbus import trial as of_modbus
from rigrunner_plugins.devices.pymeasure import trial as of_pymeasure
from rigrunner_plugins.devices.serial_ascii import trial as of_serial_ascii
from rigrunner_plugins.devices.visa import trial as of_visa

if TYPE_CHECKING:
    from rigrunner.api import Device, DeviceContext
    from rigrunner_plugins.devices.composite.settings import CompositeSettings
    from rigrunner_plugins.devices.daq.settings import DaqSettings
    from rigrunner_plugins.devices.fault.settings import FaultyDeviceSettings
    from rigrunner_plugins.devices.modbus.settings import ModbusSettings
    from rigrunner_plugins.devices.opcua.settings import OpcUaSettings
    from rigrunner_plugins.devices.other_program.settings import OtherProgramSettings
    from rigrunner_plugins.devices.pymeasure.settings import PyMeasureSettings
    from rigrunner_plugins.devices.replay.settings import ReplaySettings
    from rigrunner_plugins.devices.serial_ascii.settings import SerialAsciiSettings
    from rigrunner_plugins.devices.tabulated.settings import TabulatedSettings
    from rigrunner_plugins.devices.visa.settings import VisaSettings

TABLE = {
    "title": "A table of three rows",
    "set_points": ["frequency", "load"],
    "cycle_frequency": "frequency",
    "rows": [
        {"frequency": "0 Hz", "load": "0 N", "angle": "0 deg", "torque": "0 N·m"},
        {"frequency": "1 Hz", "load": "10 N", "angle": "2 deg", "torque": "1.2 N·m"},
        {"frequency": "10 Hz", "load": "100 N", "angle": "2 deg", "torque": "1.3 N·m"},
    ],
}
"""With which the table is tried."""
PARTS = {
    "parts": {
        "rig": {"plugin": "swing_tester_sim"},
        "table": {"plugin": "tabulated", "settings": TABLE},
    },
    "channels": {"angle": "rig.angle", "torque": "rig.torque", "reference": "table.torque"},
    "drives": {"frequency": "rig.frequency", "load": "rig.load"},
}
"""With which a role of several instruments is tried."""


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Return simulated rigs, replayed recordings, tables of values, and faults for any device."""
    return [
        DeviceRecord(
            name="replay",
            help="Recordings from CSV or HDF5 files, chosen by set frequency and load",
            settings="rigrunner_plugins.devices.replay.settings:ReplaySettings",
            factory=_replay,
            simulated=True,
        ),
        DeviceRecord(
            name="tabulated",
            help="Single values from a table, chosen by set-points, such as published ones",
            settings="rigrunner_plugins.devices.tabulated.settings:TabulatedSettings",
            trial=TABLE,
            factory=_tabulated,
            simulated=True,
        ),
        DeviceRecord(
            name="fault",
            help="Any other device with faults injected: lost, late, stuck, clipped, gaps, ...",
            settings="rigrunner_plugins.devices.fault.settings:FaultyDeviceSettings",
            trial={"plugin": "swing_tester_sim"},
            absent={"settings": {"simulate": "unplugged"}},
            factory=_fault,
            wired=True,
        ),
        DeviceRecord(
            name="composite",
            help="One role made of several instruments, each with its own plugin",
            settings="rigrunner_plugins.devices.composite.settings:CompositeSettings",
            trial=PARTS,
            factory=_composite,
            wired=True,  # by its parts: it exchanges nothing itself
        ),
        DeviceRecord(
            name="other_program",
            help="Rig that another program controls: its recordings are imported, it cannot be run",
            settings="rigrunner_plugins.devices.other_program.settings:OtherProgramSettings",
            factory=_other_program,
        ),
        DeviceRecord(
            name="daq",
            help="National Instruments: bridges, voltages and encoders on one sample clock",
            settings="rigrunner_plugins.devices.daq.settings:DaqSettings",
            factory=_daq,
            stop_latency_s=1.0,
        ),
        DeviceRecord(
            name="modbus",
            help="Modbus TCP or RTU instrument: registers and coils, without code",
            settings="rigrunner_plugins.devices.modbus.settings:ModbusSettings",
            factory=_modbus,
            wired=True,
            trial=of_modbus.TRIAL,
            absent=of_modbus.ABSENT,
        ),
        DeviceRecord(
            name="opcua",
            help="Nodes of an OPC UA server as channels and drives, without code",
            settings="rigrunner_plugins.devices.opcua.settings:OpcUaSettings",
            factory=_opcua,
            wired=True,
            absent={"endpoint": "opc.tcp://127.0.0.1:1"},
        ),
        DeviceRecord(
            name="visa",
            help="SCPI or other ASCII instrument, over a socket, serial line, GPIB or USB",
            settings="rigrunner_plugins.devices.visa.settings:VisaSettings",
            factory=_visa,
            wired=True,
            trial=of_visa.TRIAL,
            absent=of_visa.ABSENT,
        ),
        DeviceRecord(
            name="serial_ascii",
            help="Load cell, torque transducer or balance that sends lines over a serial port",
            settings="rigrunner_plugins.devices.serial_ascii.settings:SerialAsciiSettings",
            factory=_serial_ascii,
            wired=True,
            trial=of_serial_ascii.TRIAL,
            absent=of_serial_ascii.ABSENT,
        ),
        DeviceRecord(
            name="pymeasure",
            help="Instrument for which PyMeasure has a driver: its properties as channels and"
            " drives",
            settings="rigrunner_plugins.devices.pymeasure.settings:PyMeasureSettings",
            factory=_pymeasure,
            wired=True,
            trial=of_pymeasure.TRIAL,
            absent=of_pymeasure.ABSENT,
        ),
    ]


def _replay(settings: ReplaySettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.replay.device import Replay  # noqa: PLC0415  (numpy)

    return Replay(settings, context)


def _tabulated(settings: TabulatedSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.tabulated.device import Tabulated  # noqa: PLC0415  (when needed)

    return Tabulated(settings, context)


def _fault(settings: FaultyDeviceSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.fault.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _composite(settings: CompositeSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.composite.device import make  # noqa: PLC0415  (when needed)

    return make(settings, context)


def _other_program(settings: OtherProgramSettings, _: DeviceContext) -> Device:
    from rigrunner_plugins.devices.other_program.device import (  # noqa: PLC0415  (when needed)
        OtherProgram,
    )

    return OtherProgram(settings)


def _daq(settings: DaqSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.daq.device import Daq  # noqa: PLC0415  (numpy)

    return Daq(settings, context)


def _modbus(settings: ModbusSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.modbus.device import ModbusDevice  # noqa: PLC0415  (when needed)

    return ModbusDevice(settings, context)


def _opcua(settings: OpcUaSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.opcua.device import OpcUa  # noqa: PLC0415  (when needed)

    return OpcUa(settings, context)


def _visa(settings: VisaSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.visa import device, streaming  # noqa: PLC0415  (numpy)

    if settings.stream is None:
        return device.Visa(settings, context)
    return streaming.StreamingVisa(settings, settings.stream, context)


def _serial_ascii(settings: SerialAsciiSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.serial_ascii import device, streaming  # noqa: PLC0415  (numpy)

    if settings.rate is None:
        return device.SerialAscii(settings, context)
    return streaming.StreamingSerialAscii(settings, settings.rate, context)


def _pymeasure(settings: PyMeasureSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.pymeasure.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)
