"""The devices that ship with Rigrunner. Nothing here loads numpy; factories import what they make.

Each `_name` function is the factory of one record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import DeviceRecord, hookimpl
from rigrunner_plugins.devices.modbus.trial import ABSENT as MODBUS_ABSENT
from rigrunner_plugins.devices.modbus.trial import TRIAL as MODBUS_TRIAL
from rigrunner_plugins.devices.records_of_text import TEXT_DEVICES

if TYPE_CHECKING:
    from rigrunner.api.devices import Device, DeviceContext
    from rigrunner_plugins.devices.composite.settings import CompositeSettings
    from rigrunner_plugins.devices.daq.settings import DaqSettings
    from rigrunner_plugins.devices.fault.settings import FaultyDeviceSettings
    from rigrunner_plugins.devices.modbus.settings import ModbusSettings
    from rigrunner_plugins.devices.opcua.settings import OpcUaSettings
    from rigrunner_plugins.devices.other_program.settings import OtherProgramSettings
    from rigrunner_plugins.devices.replay.settings import ReplaySettings
    from rigrunner_plugins.devices.rotation_tester_sim.settings import RotationTesterSettings
    from rigrunner_plugins.devices.swing_tester_ode.settings import SwingTesterOdeSettings
    from rigrunner_plugins.devices.swing_tester_sim.settings import SwingTesterSimSettings
    from rigrunner_plugins.devices.tabulated.settings import TabulatedSettings

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
UNPLUGGED = {"simulate": "unplugged"}
"""With which a simulator is as if nobody was there."""


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Return simulated rigs, replayed recordings, tables of values, and faults for any device."""
    return [
        DeviceRecord(
            name="swing_tester_sim",
            help="Swing tester simulated in closed form, with sensor errors and faults",
            settings="rigrunner_plugins.devices.swing_tester_sim.settings:SwingTesterSimSettings",
            factory=_swing_tester_sim,
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="swing_tester_ode",
            help="Swing tester simulated in the time domain, independent of the closed form",
            settings="rigrunner_plugins.devices.swing_tester_ode.settings:SwingTesterOdeSettings",
            factory=_swing_tester_ode,
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="replay",
            help="Recordings from CSV or HDF5 files, chosen by set frequency and load",
            settings="rigrunner_plugins.devices.replay.settings:ReplaySettings",
            factory=_replay,
            simulated=True,
        ),
        DeviceRecord(
            name="rotation_tester_sim",
            help="Bench that turns a bearing slowly from rest, simulated: breakaway without load",
            settings="rigrunner_plugins.devices.rotation_tester_sim.settings:RotationTesterSettings",
            factory=_rotation_tester_sim,
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="tabulated",
            help="Single values from a table, chosen by set-points: a publication's, for one",
            settings="rigrunner_plugins.devices.tabulated.settings:TabulatedSettings",
            trial=TABLE,
            factory=_tabulated,
            simulated=True,
        ),
        DeviceRecord(
            name="other_program",
            help="Rig that another program drives: its recordings are imported, it cannot be run",
            settings="rigrunner_plugins.devices.other_program.settings:OtherProgramSettings",
            factory=_other_program,
        ),
        DeviceRecord(
            name="fault",
            help="Any other device with faults injected: lost, late, stuck, clipped, gaps, ...",
            settings="rigrunner_plugins.devices.fault.settings:FaultyDeviceSettings",
            trial={"plugin": "swing_tester_sim"},
            absent={"settings": UNPLUGGED},
            factory=_fault,
            wired=True,
        ),
        DeviceRecord(
            name="daq",
            help="National Instruments: bridges, voltages and encoders on one sample clock",
            settings="rigrunner_plugins.devices.daq.settings:DaqSettings",
            factory=_daq,
            stop_latency_s=1.0,
        ),
        DeviceRecord(
            name="composite",
            help="One role from several instruments, each of a plugin of its own",
            settings="rigrunner_plugins.devices.composite.settings:CompositeSettings",
            trial=PARTS,
            factory=_composite,
            wired=True,  # by its parts: it exchanges nothing itself
        ),
        DeviceRecord(
            name="modbus",
            help="Instrument that talks Modbus TCP or RTU: registers and coils, no code",
            settings="rigrunner_plugins.devices.modbus.settings:ModbusSettings",
            factory=_modbus,
            wired=True,
            trial=MODBUS_TRIAL,
            absent=MODBUS_ABSENT,
        ),
        DeviceRecord(
            name="opcua",
            help="Nodes of an OPC UA server as channels and drives, no code",
            settings="rigrunner_plugins.devices.opcua.settings:OpcUaSettings",
            factory=_opcua,
            wired=True,
            absent={"endpoint": "opc.tcp://127.0.0.1:1"},
        ),
        *TEXT_DEVICES,
    ]


def _swing_tester_sim(settings: SwingTesterSimSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.swing_tester_sim.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _swing_tester_ode(settings: SwingTesterOdeSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.swing_tester_ode.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _replay(settings: ReplaySettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.replay.device import Replay  # noqa: PLC0415  (numpy)

    return Replay(settings, context)


def _rotation_tester_sim(settings: RotationTesterSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.rotation_tester_sim.device import (  # noqa: PLC0415  (numpy)
        RotationTester,
    )

    return RotationTester(settings, context)


def _tabulated(settings: TabulatedSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.tabulated.device import Tabulated  # noqa: PLC0415  (when needed)

    return Tabulated(settings, context)


def _other_program(settings: OtherProgramSettings, _: DeviceContext) -> Device:
    from rigrunner_plugins.devices.other_program.device import (  # noqa: PLC0415  (when needed)
        OtherProgram,
    )

    return OtherProgram(settings)


def _fault(settings: FaultyDeviceSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.fault.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _daq(settings: DaqSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.daq.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


def _composite(settings: CompositeSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.composite.device import make  # noqa: PLC0415  (when needed)

    return make(settings, context)


def _opcua(settings: OpcUaSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.opcua.device import make  # noqa: PLC0415  (when needed)

    return make(settings, context)


def _modbus(settings: ModbusSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.modbus.device import make  # noqa: PLC0415  (when needed)

    return make(settings, context)
