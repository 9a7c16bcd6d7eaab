"""Instruments with a protocol of their own, and rigs that another program drives.

Nothing here loads numpy; each `_name` function is the factory of one record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DeviceRecord
from rigrunner_plugins.devices.modbus.trial import ABSENT as MODBUS_ABSENT
from rigrunner_plugins.devices.modbus.trial import TRIAL as MODBUS_TRIAL

if TYPE_CHECKING:
    from rigrunner.api import Device, DeviceContext
    from rigrunner_plugins.devices.daq.settings import DaqSettings
    from rigrunner_plugins.devices.modbus.settings import ModbusSettings
    from rigrunner_plugins.devices.opcua.settings import OpcUaSettings
    from rigrunner_plugins.devices.other_program.settings import OtherProgramSettings


def _other_program(settings: OtherProgramSettings, _: DeviceContext) -> Device:
    from rigrunner_plugins.devices.other_program.device import (  # noqa: PLC0415  (when needed)
        OtherProgram,
    )

    return OtherProgram(settings)


def _daq(settings: DaqSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.daq.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _modbus(settings: ModbusSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.modbus.device import make  # noqa: PLC0415  (when needed)

    return make(settings, context)


def _opcua(settings: OpcUaSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.opcua.device import make  # noqa: PLC0415  (when needed)

    return make(settings, context)


INSTRUMENTS = (
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
        trial=MODBUS_TRIAL,
        absent=MODBUS_ABSENT,
    ),
    DeviceRecord(
        name="opcua",
        help="Nodes of an OPC UA server as channels and drives, without code",
        settings="rigrunner_plugins.devices.opcua.settings:OpcUaSettings",
        factory=_opcua,
        wired=True,
        absent={"endpoint": "opc.tcp://127.0.0.1:1"},
    ),
)
