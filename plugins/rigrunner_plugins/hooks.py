"""What ships with Rigrunner as plugins. Nothing here loads numpy; factories import what they make.

Each `_name` function is the factory of one record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import CompensationRecord, DeviceRecord, hookimpl
from rigrunner.api.measurand import Condition, MeasurandKind, Nature
from rigrunner_plugins.compensations.breakaway_peak_settings import BreakawayPeakSettings
from rigrunner_plugins.compensations.paper_peak_settings import PaperPeakSettings
from rigrunner_plugins.compensations.peak_same_frequency_settings import PeakSameFrequencySettings
from rigrunner_plugins.compensations.settings import (
    EnergySettings,
    InverseSettings,
    TemplateInverseSettings,
)
from rigrunner_plugins.devices.composite.settings import CompositeSettings
from rigrunner_plugins.devices.daq.settings import DaqSettings
from rigrunner_plugins.devices.fault.settings import FaultyDeviceSettings
from rigrunner_plugins.devices.modbus.settings import ModbusSettings
from rigrunner_plugins.devices.modbus.trial import ABSENT as MODBUS_ABSENT
from rigrunner_plugins.devices.modbus.trial import TRIAL as MODBUS_TRIAL
from rigrunner_plugins.devices.opcua.settings import OpcUaSettings
from rigrunner_plugins.devices.other_program.settings import OtherProgramSettings
from rigrunner_plugins.devices.replay.settings import ReplaySettings
from rigrunner_plugins.devices.rotation_tester_sim.settings import RotationTesterSettings
from rigrunner_plugins.devices.swing_tester_ode.settings import SwingTesterOdeSettings
from rigrunner_plugins.devices.swing_tester_sim.settings import SwingTesterSimSettings
from rigrunner_plugins.devices.tabulated.settings import TabulatedSettings
from rigrunner_plugins.devices.text.records import TEXT_DEVICES
from rigrunner_plugins.fits.records import rigrunner_fits
from rigrunner_plugins.importers.records import rigrunner_importers
from rigrunner_plugins.outlier_rules.records import rigrunner_outlier_rules

if TYPE_CHECKING:
    from rigrunner.api.analysis import CompensationMethod
    from rigrunner.api.devices import Device, DeviceContext

__all__ = [
    "api_version",
    "rigrunner_compensations",
    "rigrunner_devices",
    "rigrunner_fits",
    "rigrunner_importers",
    "rigrunner_outlier_rules",
]

api_version = 1

STARTING = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)
RUNNING = MeasurandKind(Nature.LOAD_INDUCED, Condition.UNDER_WAY)
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

OTHER_PHASE = (
    "the loaded and the no-load peak fall at different phases of the swing, and the uncertainty"
    " does not include what comes of that"
)
BREAKAWAY = MeasurandKind(Nature.TOTAL, Condition.FROM_REST)


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Return simulated rigs, replayed recordings, tables of values, and faults for any device."""
    return [
        DeviceRecord(
            name="swing_tester_sim",
            help="Swing tester simulated in closed form, with sensor errors and faults",
            settings=SwingTesterSimSettings,
            factory=_swing_tester_sim,
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="swing_tester_ode",
            help="Swing tester simulated in the time domain, independent of the closed form",
            settings=SwingTesterOdeSettings,
            factory=_swing_tester_ode,
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="replay",
            help="Recordings from CSV or HDF5 files, chosen by set frequency and load",
            settings=ReplaySettings,
            factory=_replay,
            simulated=True,
        ),
        DeviceRecord(
            name="rotation_tester_sim",
            help="Bench that turns a bearing slowly from rest, simulated: breakaway without load",
            settings=RotationTesterSettings,
            factory=_rotation_tester_sim,
            simulated=True,
            absent=UNPLUGGED,
        ),
        DeviceRecord(
            name="tabulated",
            help="Single values from a table, chosen by set-points: a publication's, for one",
            settings=TabulatedSettings,
            trial=TABLE,
            factory=_tabulated,
            simulated=True,
        ),
        DeviceRecord(
            name="other_program",
            help="Rig that another program drives: its recordings are imported, it cannot be run",
            settings=OtherProgramSettings,
            factory=_other_program,
        ),
        DeviceRecord(
            name="fault",
            help="Any other device with faults injected: lost, late, stuck, clipped, gaps, ...",
            settings=FaultyDeviceSettings,
            trial={"plugin": "swing_tester_sim"},
            absent={"settings": UNPLUGGED},
            factory=_fault,
            wired=True,
        ),
        DeviceRecord(
            name="daq",
            help="National Instruments: bridges, voltages and encoders on one sample clock",
            settings=DaqSettings,
            factory=_daq,
            stop_latency_s=1.0,
        ),
        DeviceRecord(
            name="composite",
            help="One role from several instruments, each of a plugin of its own",
            settings=CompositeSettings,
            trial=PARTS,
            factory=_composite,
            wired=True,  # by its parts: it exchanges nothing itself
        ),
        DeviceRecord(
            name="modbus",
            help="Instrument that talks Modbus TCP or RTU: registers and coils, no code",
            settings=ModbusSettings,
            factory=_modbus,
            wired=True,
            trial=MODBUS_TRIAL,
            absent=MODBUS_ABSENT,
        ),
        DeviceRecord(
            name="opcua",
            help="Nodes of an OPC UA server as channels and drives, no code",
            settings=OpcUaSettings,
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


@hookimpl
def rigrunner_compensations() -> list[CompensationRecord]:
    """Return the ways to take the rig's part out of the measured torque."""
    return [
        CompensationRecord(
            name="paper_peak",
            help="Raw peak minus fitted no-load peak, as published (Eq. 2)",
            settings=PaperPeakSettings,
            factory=_paper_peak,
            yields=STARTING,
            not_covered=OTHER_PHASE,
        ),
        CompensationRecord(
            name="peak_same_frequency",
            help="Raw peak minus the no-load peak of the same frequency",
            settings=PeakSameFrequencySettings,
            factory=_peak_same_frequency,
            yields=STARTING,
            not_covered=OTHER_PHASE,
        ),
        CompensationRecord(
            name="template_inverse",
            help="Whole swings: loaded minus no-load, resonance and filter undone (recommended)",
            settings=TemplateInverseSettings,
            factory=_template_inverse,
            yields=STARTING,
        ),
        CompensationRecord(
            name="model_inverse",
            help="As template_inverse, by a model of the sweep: also between its frequencies",
            settings=InverseSettings,
            factory=_model_inverse,
            yields=STARTING,
        ),
        CompensationRecord(
            name="energy",
            help="Running torque: work of a swing over its way, loaded minus no-load",
            settings=EnergySettings,
            factory=_energy,
            yields=RUNNING,
        ),
        CompensationRecord(
            name="breakaway_peak",
            help="Starts from rest: mean of their breakaway torques, another torque than a swing's",
            settings=BreakawayPeakSettings,
            factory=_breakaway_peak,
            yields=BREAKAWAY,
        ),
    ]


def _paper_peak(settings: PaperPeakSettings) -> CompensationMethod:
    from rigrunner_plugins.compensations.paper_peak import PaperPeak  # noqa: PLC0415  (numpy)

    return PaperPeak(settings)


def _peak_same_frequency(settings: PeakSameFrequencySettings) -> CompensationMethod:
    from rigrunner_plugins.compensations.peak_same_frequency import (  # noqa: PLC0415  (numpy)
        PeakSameFrequency,
    )

    return PeakSameFrequency(settings)


def _template_inverse(settings: TemplateInverseSettings) -> CompensationMethod:
    from rigrunner_plugins.compensations.template_inverse import (  # noqa: PLC0415  (scipy)
        TemplateInverse,
    )

    return TemplateInverse(settings)


def _model_inverse(settings: InverseSettings) -> CompensationMethod:
    from rigrunner_plugins.compensations.model_inverse import (  # noqa: PLC0415  (scipy)
        ModelInverse,
    )

    return ModelInverse(settings)


def _energy(settings: EnergySettings) -> CompensationMethod:
    from rigrunner_plugins.compensations.energy import Energy  # noqa: PLC0415  (numpy)

    return Energy(settings)


def _breakaway_peak(settings: BreakawayPeakSettings) -> CompensationMethod:
    from rigrunner_plugins.compensations.breakaway_peak import (  # noqa: PLC0415  (numpy)
        BreakawayPeak,
    )

    return BreakawayPeak(settings)
