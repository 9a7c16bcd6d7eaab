"""The devices that ship with Rigrunner. Nothing here loads numpy or a library of instruments."""

from __future__ import annotations

from rigrunner.api import DeviceRecord, Imported, hookimpl
from rigrunner_plugins.devices import trials


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Return simulated rigs, replayed recordings, tables of values, and faults for any device."""
    return [
        DeviceRecord(
            name="replay",
            help="Recordings from CSV or HDF5 files, chosen by set frequency and load",
            settings="rigrunner_plugins.devices.replay.settings:ReplaySettings",
            factory=Imported("rigrunner_plugins.devices.replay.device:Replay"),
            simulated=True,
        ),
        DeviceRecord(
            name="tabulated",
            help="Single values from a table, chosen by set-points, such as published ones",
            settings="rigrunner_plugins.devices.tabulated.settings:TabulatedSettings",
            trial=trials.TABLE,
            factory=Imported("rigrunner_plugins.devices.tabulated.device:Tabulated"),
            simulated=True,
        ),
        DeviceRecord(
            name="fault",
            help="Any other device with faults injected: lost, late, stuck, clipped, gaps, ...",
            settings="rigrunner_plugins.devices.fault.settings:FaultyDeviceSettings",
            trial={"plugin": "swing_tester_sim"},
            absent={"settings": {"simulate": "unplugged"}},
            factory=Imported("rigrunner_plugins.devices.fault.device:make"),
            wired=True,
        ),
        DeviceRecord(
            name="composite",
            help="One role from several instruments, each with its own plugin",
            settings="rigrunner_plugins.devices.composite.settings:CompositeSettings",
            trial=trials.PARTS,
            factory=Imported("rigrunner_plugins.devices.composite.device:make"),
            wired=True,  # by its parts: it exchanges nothing itself
        ),
        DeviceRecord(
            name="other_program",
            help="Rig that another program controls: its recordings are imported, it cannot be run",
            settings="rigrunner_plugins.devices.other_program.settings:OtherProgramSettings",
            factory=Imported("rigrunner_plugins.devices.other_program.device:OtherProgram"),
        ),
        DeviceRecord(
            name="daq",
            help="National Instruments: bridges, voltages and encoders on one sample clock",
            settings="rigrunner_plugins.devices.daq.settings:DaqSettings",
            factory=Imported("rigrunner_plugins.devices.daq.device:Daq"),
            stop_latency_s=1.0,
        ),
        DeviceRecord(
            name="modbus",
            help="Modbus TCP or RTU instrument: registers and coils, without code",
            settings="rigrunner_plugins.devices.modbus.settings:ModbusSettings",
            factory=Imported("rigrunner_plugins.devices.modbus.device:ModbusDevice"),
            wired=True,
            trial=trials.MODBUS,
            absent=trials.ABSENT_MODBUS,
        ),
        DeviceRecord(
            name="opcua",
            help="Nodes of an OPC UA server as channels and drives, without code",
            settings="rigrunner_plugins.devices.opcua.settings:OpcUaSettings",
            factory=Imported("rigrunner_plugins.devices.opcua.device:OpcUa"),
            wired=True,
            absent={"endpoint": "opc.tcp://127.0.0.1:1"},
        ),
        DeviceRecord(
            name="visa",
            help="SCPI or other ASCII instrument, over a socket, serial line, GPIB or USB",
            settings="rigrunner_plugins.devices.visa.settings:VisaSettings",
            factory=Imported("rigrunner_plugins.devices.visa.streaming:make"),
            wired=True,
            trial=trials.VISA,
            absent=trials.ABSENT_VISA,
        ),
        DeviceRecord(
            name="serial_ascii",
            help="Load cell, torque transducer or balance that sends lines over a serial port",
            settings="rigrunner_plugins.devices.serial_ascii.settings:SerialAsciiSettings",
            factory=Imported("rigrunner_plugins.devices.serial_ascii.streaming:make"),
            wired=True,
            trial=trials.SERIAL_ASCII,
            absent=trials.ABSENT_SERIAL_ASCII,
        ),
        DeviceRecord(
            name="pymeasure",
            help="Instrument for which PyMeasure has a driver: its properties as channels and"
            " drives",
            settings="rigrunner_plugins.devices.pymeasure.settings:PyMeasureSettings",
            factory=Imported("rigrunner_plugins.devices.pymeasure.device:make"),
            wired=True,
            trial=trials.PYMEASURE,
            absent=trials.ABSENT_PYMEASURE,
        ),
    ]
